// environment(): a latitude-longitude map, filtered around a direction (OSL specification ch. 7, "Texture").
//
// In: what the row environment_lookup of the compiler's table takes. Out: a colour or a number. Directions, filter and levels
// of detail are those of OpenImageIO's TextureSystem; there are no derivatives, as in OSL's reference implementation.
#ifndef OSLCL_OSL_ENVIRONMENT_H
#define OSLCL_OSL_ENVIRONMENT_H

#include "osl/texture_sample.h"

#define ENVIRONMENT_ANISOTROPY ((real)32)

static inline real3 environment_unit(real3 v)
{
    const real size = length(v);
    return size > 0 && size <= REAL_MAX ? v / size : (real3)(0);
}

// s and t of a direction.
static inline real2 environment_place(real3 r, int y_up)
{
    const real2 around = y_up ? (real2)(-r.x, r.z) : (real2)(r.y, r.x);
    const real up = y_up ? r.y : r.z;
    const real s = atan2(around.x, around.y) / (real)(2 * PI) + (real)0.5;
    const real t = (real)0.5 - atan2(up, hypot(around.x, around.y)) / (real)PI;
    return (real2)(isfinite(s) ? s : 0, isfinite(t) ? t : 0);
}

static inline real environment_angle(real3 a, real3 b) { return atan2(length(cross(a, b)), dot(a, b)); }

static inline real3 environment_lookup(__global const uint *data, int channels, int file, real3 R, real3 dx, real3 dy,
                                       int mode, int first, int subimage, int name, real2 width, real2 blur, real fill,
                                       real3 missing)
{
    Texture x;
    real s = 0, t = 0;
    if (!texture_open(&x, data, file, &s, &t, subimage, name)) return texture_absent(mode, fill, missing);
    const uint flags = texture_flags(&x);
    texture_options(&x, first, channels, flags & SUB_BORDER ? WRAP_SHARED_BORDER : WRAP_PERIODIC, WRAP_CLAMP);
    const real3 r = environment_unit(R), rx = environment_unit(R + dx), ry = environment_unit(R + dy);
    const real x_angle = fmax(environment_angle(r, rx), (real)1e-8);
    const real y_angle = fmax(environment_angle(r, ry), (real)1e-8);
    const int natural = (int)((real)PI / fmin(x_angle, y_angle));
    const real x_size = x_angle * width.x + blur.x, y_size = y_angle * width.y + blur.y;
    const int along_x = x_size >= y_size;
    real major = along_x ? x_size : y_size, minor = along_x ? y_size : x_size;
    real aspect = clamp(major / minor, (real)1, (real)1e6);
    if (!(aspect <= ENVIRONMENT_ANISOTROPY)) {
        aspect = ENVIRONMENT_ANISOTROPY;
        major = (real)0.5 * (major + minor * ENVIRONMENT_ANISOTROPY);
        minor = major / ENVIRONMENT_ANISOTROPY;
    }
    const int count = max(1, (int)ceil(aspect - (real)0.25));
    TextureLevels levels = {-1, -1, 0, 0};
    for (int m = 0; m < texture_levels(&x); m++) {
        // Half a turn from pole to pole.
        const real texels = TEXTURE_BIASED((real)texture_height(&x, m) * minor / (real)PI);
        if (texels <= 1) {
            levels.fine = m - 1;
            levels.coarse = m;
            levels.share = clamp(2 * texels - 1, (real)0, (real)1);
            break;
        }
    }
    texture_level_range(&levels, texture_levels(&x));
    TextureSum sum = texture_nothing();
    for (int i = 0; i < count; i++) {
        const real place = ((real)i + (real)0.5) / (real)count - (real)0.5;
        const real2 st = environment_place(r + (along_x ? rx : ry) * place, flags & SUB_Y_UP);
        for (int k = 0; k < 2; k++) {
            const real share = k == 0 ? 1 - levels.share : levels.share;
            if (share == 0) continue;
            const int level = k == 0 ? levels.fine : levels.coarse;
            int how = TEXTURE_INTERP(mode);
            if (how == INTERP_SMART)
                how = level == 0 || texture_height(&x, level) < natural / 2 ? INTERP_CUBIC : INTERP_LINEAR;
            texture_sample(&x, how, level, st.x, st.y, share / (real)count, 1, &sum);
        }
    }
    return texture_filled(&x, &sum, fill);
}

static inline real3 osl_environment_lookup_v_svvviiisfffffv(const ShaderGlobals *sg, int file, real3 R, real3 dRdx,
                                                            real3 dRdy, int mode, int first, int subimage, int name,
                                                            real swidth, real twidth, real sblur, real tblur, real fill,
                                                            real3 missing)
{
    return environment_lookup(sg->textures, 3, file, R, dRdx, dRdy, mode, first, subimage, name, (real2)(swidth, twidth),
                              (real2)(sblur, tblur), fill, missing);
}

static inline real osl_environment_lookup_f_svvviiisfffffv(const ShaderGlobals *sg, int file, real3 R, real3 dRdx,
                                                           real3 dRdy, int mode, int first, int subimage, int name,
                                                           real swidth, real twidth, real sblur, real tblur, real fill,
                                                           real3 missing)
{
    return environment_lookup(sg->textures, 1, file, R, dRdx, dRdy, mode, first, subimage, name, (real2)(swidth, twidth),
                              (real2)(sblur, tblur), fill, missing)
        .x;
}

#endif
