// texture(): anisotropic filtering of levels of detail (OSL specification ch. 7, "Texture").
//
// In: what the rows texture_* of the compiler's table of built-ins take. Out: a colour or a number, or its derivative by s or
// t. The derivatives of s and t span an ellipse (Heckbert: Fundamentals of Texture Mapping, 1989, section 3); its minor axis
// chooses two levels of detail, and samples along its major axis, weighted by a Gaussian, cover it. Choice of levels, number
// and weights of samples are those of OpenImageIO's TextureSystem.
#ifndef OSLCL_OSL_TEXTURE_H
#define OSLCL_OSL_TEXTURE_H

#include "osl/texture_sample.h"

// Shorter derivatives count as this long.
#define TEXTURE_TINY ((real)1e-8)
// Most samples along the ellipse, per length of its minor axis.
#define TEXTURE_ANISOTROPY ((real)32)

// The filter: an ellipse in texture coordinates.
typedef struct {
    real major, minor; // lengths
    real s, t;         // unit, along the major axis
    real aspect;       // 1 .. TEXTURE_ANISOTROPY
} TextureEllipse;

// Both axes get a length, at a right angle where one has none.
static inline void texture_lengthen(real2 *dx, real2 *dy)
{
    const real x = dot(*dx, *dx), y = dot(*dy, *dy), tiny = TEXTURE_TINY * TEXTURE_TINY;
    if (x < tiny && y < tiny) {
        *dx = (real2)(TEXTURE_TINY, 0);
        *dy = (real2)(0, TEXTURE_TINY);
    } else if (x < tiny) {
        *dx = (real2)(dy->y, -dy->x) * (TEXTURE_TINY / sqrt(y));
    } else if (y < tiny) {
        *dy = (real2)(-dx->y, dx->x) * (TEXTURE_TINY / sqrt(x));
    }
}

static inline TextureEllipse texture_ellipse(real2 dx, real2 dy, real sblur, real tblur)
{
    TextureEllipse e;
    texture_lengthen(&dx, &dy);
    const real a = dx.y * dx.y + dy.y * dy.y;
    const real b = -2 * (dx.x * dx.y + dy.x * dy.y);
    const real c = dx.x * dx.x + dy.x * dy.x;
    const real longest = b == 0 ? sqrt(fmax(a, c)) : sqrt((a + c + hypot(a - c, b)) / 2);
    e.major = fmin(longest, (real)1000);
    // The product of both lengths is the area that the derivatives span. Along the axes they are known without rounding, which
    // counts where the number of samples is about to change.
    e.minor = fmin(b == 0 ? sqrt(fmin(a, c)) : fabs(dx.x * dy.y - dx.y * dy.x) / longest, e.major);
    const real theta = (real)0.5 * atan2(b, a - c) + (real)(PI / 2);
    e.s = cos(theta);
    e.t = sin(theta);
    if (sblur + tblur != 0) {
        e.major += hypot(sblur * e.s, tblur * e.t);
        e.minor += hypot(sblur * e.t, tblur * e.s);
        if (e.minor > e.major) {
            const real length = e.major, s = e.s;
            e.major = e.minor;
            e.minor = length;
            e.s = -e.t;
            e.t = s;
        }
    }
    e.aspect = clamp(e.major / e.minor, (real)1, (real)1e6);
    if (!(e.aspect <= TEXTURE_ANISOTROPY)) {
        // Too long: a little too blurred across, a little too sharp along.
        e.aspect = TEXTURE_ANISOTROPY;
        e.major = (real)0.5 * (e.major + e.minor * TEXTURE_ANISOTROPY);
        e.minor = e.major / TEXTURE_ANISOTROPY;
    }
    return e;
}

static inline TextureLevels texture_choose(const Texture *x, TextureEllipse *e)
{
    TextureLevels l = {-1, -1, 0, 0};
    const int levels = texture_levels(x);
    for (int m = 0; m < levels; m++) {
        const real texels = TEXTURE_BIASED(e->minor * (real)min(texture_width(x, m), texture_height(x, m)));
        if (texels <= 1) {
            l.fine = m - 1;
            l.coarse = m;
            l.share = clamp(2 * texels - 1, (real)0, (real)1);
            break;
        }
    }
    texture_level_range(&l, levels);
    if (l.finest) {
        // Samples closer than half a texel of the finest level would tell nothing.
        const real full = (real)x->data[x->sub + SUB_FULL];
        if (e->minor * full < (real)0.5) e->aspect = clamp(e->major * full * 2, (real)1, TEXTURE_ANISOTROPY);
    }
    return l;
}

// Samples of one level along the ellipse, their weights adding up to 1.
static inline TextureSum texture_along(const Texture *x, int interp, int level, real s, real t, const TextureEllipse *e)
{
    const int count = max(1, (int)(2 * e->aspect - 1));
    const real reach = e->major - e->minor; // of the outermost samples, about
    const real scale = count > 2 ? e->major / (2 * reach) : (real)0;
    TextureSum sum = texture_nothing();
    real total = 0;
    for (int i = 0; i < count; i++) {
        const real place = 2 * ((real)i + (real)0.5) / (real)count - 1;
        const real weight = exp(-2 * place * scale * place * scale);
        texture_sample(x, interp, level, s + place * reach * e->s, t + place * reach * e->t, weight, 0, &sum);
        total += weight;
    }
    TextureSum mean = texture_nothing();
    texture_add(&mean, &sum, 1 / total);
    return mean;
}

static inline TextureSum texture_filter(const Texture *x, int interp, real s, real t, real2 dx, real2 dy, real2 width,
                                        real2 blur)
{
    // Whether texels are larger than what is asked for decides before width and blur.
    const int natural_s = (int)(1 / fmax(fmax(fabs(dx.x), fabs(dy.x)), TEXTURE_TINY));
    const int natural_t = (int)(1 / fmax(fmax(fabs(dx.y), fabs(dy.y)), TEXTURE_TINY));
    const real s_scale = as_float(x->data[x->sub + SUB_SSCALE]), t_scale = as_float(x->data[x->sub + SUB_TSCALE]);
    TextureEllipse e = texture_ellipse(dx * width, dy * width, blur.x, blur.y);
    const TextureLevels levels = texture_choose(x, &e);
    TextureSum sum = texture_nothing();
    for (int k = 0; k < 2; k++) {
        const real share = k == 0 ? 1 - levels.share : levels.share;
        if (share == 0) continue;
        const int level = k == 0 ? levels.fine : levels.coarse;
        int how = interp;
        if (how == INTERP_SMART)
            how = level == 0 || texture_width(x, level) < natural_s / 2 || texture_height(x, level) < natural_t / 2
                      ? INTERP_CUBIC
                      : INTERP_LINEAR;
        const TextureSum part = texture_along(x, how, level, s, t, &e);
        texture_add(&sum, &part, share);
    }
    sum.ds *= s_scale;
    sum.dt *= t_scale;
    return sum;
}

// A whole lookup; `by` is 0 for the value, 1 and 2 for its derivatives by s and t.
static inline real3 texture_lookup(__global const uint *data, int channels, int by, int file, real s, real t, real2 dx,
                                   real2 dy, int mode, int first, int subimage, int name, real2 width, real2 blur,
                                   real fill, real3 missing)
{
    Texture x;
    if (!texture_open(&x, data, file, &s, &t, subimage, name))
        return by == 0 ? texture_absent(mode, fill, missing) : (real3)(0);
    texture_options(&x, first, channels, MODE_SWRAP(mode), MODE_TWRAP(mode));
    __global const uint *sub = data + x.sub;
    const real2 scale = (real2)(as_float(sub[SUB_SSCALE]), as_float(sub[SUB_TSCALE]));
    s = s * scale.x + as_float(sub[SUB_SOFFSET]);
    t = t * scale.y + as_float(sub[SUB_TOFFSET]);
    const TextureSum sum = texture_filter(&x, TEXTURE_INTERP(mode), s, t, dx * scale, dy * scale, width, blur);
    return by == 0 ? texture_filled(&x, &sum, fill) : by == 1 ? sum.ds : sum.dt;
}

// The rows of the compiler's table: NAME is lookup, ds or dt, BY as above.
#define OSL_TEXTURE(NAME, BY)                                                                                          \
    static inline real3 osl_texture_##NAME##_v_sffffffiiisfffffv(                                                      \
        const ShaderGlobals *sg, int file, real s, real t, real dsdx, real dtdx, real dsdy, real dtdy, int mode,       \
        int first, int subimage, int name, real swidth, real twidth, real sblur, real tblur, real fill, real3 missing) \
    {                                                                                                                  \
        return texture_lookup(sg->textures, 3, BY, file, s, t, (real2)(dsdx, dtdx), (real2)(dsdy, dtdy), mode, first,  \
                              subimage, name, (real2)(swidth, twidth), (real2)(sblur, tblur), fill, missing);          \
    }                                                                                                                  \
    static inline real osl_texture_##NAME##_f_sffffffiiisfffffv(                                                       \
        const ShaderGlobals *sg, int file, real s, real t, real dsdx, real dtdx, real dsdy, real dtdy, int mode,       \
        int first, int subimage, int name, real swidth, real twidth, real sblur, real tblur, real fill, real3 missing) \
    {                                                                                                                  \
        return texture_lookup(sg->textures, 1, BY, file, s, t, (real2)(dsdx, dtdx), (real2)(dsdy, dtdy), mode, first,  \
                              subimage, name, (real2)(swidth, twidth), (real2)(sblur, tblur), fill, missing)           \
            .x;                                                                                                        \
    }
OSL_TEXTURE(lookup, 0)
OSL_TEXTURE(ds, 1)
OSL_TEXTURE(dt, 2)

// The message of a lookup that finds nothing; 0, the empty string, when it finds something.
static inline int osl_texture_error_s_sffis(const ShaderGlobals *sg, int file, real s, real t, int subimage, int name)
{
    __global const uint *data = sg->textures;
    const uint whole = texture_node(data, file);
    if (whole == 0) return 0;
    uint node = whole;
    if (data[node] == TEXTURE_TILES) node = texture_tile(data, node, &s, &t);
    if (texture_subimage(data, node, subimage, name) != 0) return 0;
    // A file that is there lacks the subimage; sets and files carry the message for that behind their lists.
    switch (data[whole]) {
    case TEXTURE_NONE: return (int)data[whole + 1];
    case TEXTURE_FILE: return (int)data[whole + 2 + data[whole + 1]];
    default: return (int)data[whole + 3 + data[whole + 1] * data[whole + 2]];
    }
}

#endif
