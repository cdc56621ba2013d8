// Samples of one level of detail of a texture: the closest texel, linear, cubic.
//
// In: a texture, coordinates, a weight. Out: the weighted channels, added up, with their derivatives by s and t. The cubic
// is the uniform B-spline (Sigg, Hadwiger: Fast Third-Order Texture Filtering, GPU Gems 2, ch. 20). Results follow
// OpenImageIO's TextureSystem.
#ifndef OSLCL_OSL_TEXTURE_SAMPLE_H
#define OSLCL_OSL_TEXTURE_SAMPLE_H

#include "osl/texture_data.h"

// The renderer may overrule what lookups say, and shift the levels of detail: docs/accuracy.md.
#ifdef TEXTURE_FILTER
#define TEXTURE_INTERP(mode) TEXTURE_FILTER
#else
#define TEXTURE_INTERP(mode) MODE_INTERP(mode)
#endif
#ifdef TEXTURE_MIP_SCALE
#define TEXTURE_BIASED(texels) ((texels) * (real)TEXTURE_MIP_SCALE)
#else
#define TEXTURE_BIASED(texels) (texels)
#endif

// What samples add up to.
typedef struct {
    real3 value, ds, dt;
    real covered; // weight of what lies on the texture, and not in black around it
} TextureSum;

static inline TextureSum texture_nothing(void)
{
    TextureSum sum;
    sum.value = sum.ds = sum.dt = (real3)(0);
    sum.covered = 0;
    return sum;
}

static inline void texture_add(TextureSum *sum, const TextureSum *other, real weight)
{
    sum->value += other->value * weight;
    sum->ds += other->ds * weight;
    sum->dt += other->dt * weight;
    sum->covered += other->covered * weight;
}

// Texel coordinates of s and t: texel i has its centre at i.
static inline void texture_place(const Texture *x, int width, int height, real s, real t, real *column, real *row)
{
    if (texture_flags(x) & SUB_BORDER) {
        *column = s * (real)(width - 1);
        *row = t * (real)(height - 1);
    } else {
        *column = s * (real)width - (real)0.5;
        *row = t * (real)height - (real)0.5;
    }
}

static inline void texture_closest(const Texture *x, int level, real s, real t, real weight, TextureSum *sum)
{
    const uint l = texture_level(x, level);
    const int width = texture_width(x, level), height = texture_height(x, level);
    real column, row, u, v;
    texture_place(x, width, height, s, t, &column, &row);
    int i = texture_floor(column, &u), j = texture_floor(row, &v);
    i += u > (real)0.5;
    j += v > (real)0.5;
    if (!texture_wrap(x->swrap, &i, width) || !texture_wrap(x->twrap, &j, height)) return;
    sum->value += texture_texel(x, l, i, j) * weight;
    sum->covered += weight;
}

// Environments: where the first or last row of a level ends, its mean colour takes over towards the pole.
static inline void texture_pole(const Texture *x, int level, real t, real *weight, TextureSum *sum)
{
    const uint poles = x->data[texture_level(x, level) + LEVEL_POLES];
    if (poles == 0) return;
    const real height = (real)(texture_height(x, level) - (texture_flags(x) & SUB_BORDER ? 1 : 0));
    const real row = t * height;
    if (!(row < 1 || row > height - 1)) return;
    const real near = row < 1 ? 1 - row : row - floor(row);
    const real share = clamp(near, (real)0, (real)1) * clamp(near, (real)0, (real)1);
    const uint channels = x->data[x->sub + SUB_CHANNELS];
    __global const float *color = (__global const float *)(x->data + poles) + (row < 1 ? 0 : channels) + x->first;
    real3 c = (real3)(0);
    if (x->actual > 0) c.x = color[0];
    if (x->actual > 1) c.y = color[1];
    if (x->actual > 2) c.z = color[2];
    sum->value += c * (*weight * share);
    *weight *= 1 - share;
}

// Linear (`count` 2) or cubic (4) between texels; the weights of columns and rows, and their derivatives, are given.
static inline void texture_weighted(const Texture *x, int level, int column, int row, int count, const real *wx,
                                    const real *wy, const real *dx, const real *dy, real weight, TextureSum *sum)
{
    const uint l = texture_level(x, level);
    const int width = texture_width(x, level), height = texture_height(x, level);
    const real by_s = weight * (real)width, by_t = weight * (real)height;
    for (int j = 0; j < count; j++) {
        int y = row + j;
        if (!texture_wrap(x->twrap, &y, height)) continue;
        for (int i = 0; i < count; i++) {
            int k = column + i;
            if (!texture_wrap(x->swrap, &k, width)) continue;
            const real3 c = texture_texel(x, l, k, y);
            sum->value += c * (weight * wx[i] * wy[j]);
            sum->ds += c * (by_s * dx[i] * wy[j]);
            sum->dt += c * (by_t * wx[i] * dy[j]);
            sum->covered += weight * wx[i] * wy[j];
        }
    }
}

static inline void texture_linear(const Texture *x, int level, real s, real t, real weight, int poles, TextureSum *sum)
{
    real column, row, u, v;
    texture_place(x, texture_width(x, level), texture_height(x, level), s, t, &column, &row);
    const int i = texture_floor(column, &u), j = texture_floor(row, &v);
    if (poles) texture_pole(x, level, t, &weight, sum);
    const real wx[2] = {1 - u, u}, wy[2] = {1 - v, v}, slope[2] = {-1, 1};
    texture_weighted(x, level, i, j, 2, wx, wy, slope, slope, weight, sum);
}

// Weights of the uniform cubic B-spline, `f` behind the second of four knots, and their derivatives.
static inline void texture_spline(real f, real *w, real *d)
{
    const real g = 1 - f;
    w[0] = g * g * g / 6;
    w[1] = (real)(2.0 / 3.0) - f * f * (2 - f) / 2;
    w[2] = (real)(2.0 / 3.0) - g * g * (2 - g) / 2;
    w[3] = f * f * f / 6;
    d[0] = -g * g / 2;
    d[1] = f * (3 * f - 4) / 2;
    d[2] = -g * (3 * g - 4) / 2;
    d[3] = f * f / 2;
}

static inline void texture_cubic(const Texture *x, int level, real s, real t, real weight, int poles, TextureSum *sum)
{
    real column, row, u, v, wx[4], wy[4], dx[4], dy[4];
    texture_place(x, texture_width(x, level), texture_height(x, level), s, t, &column, &row);
    const int i = texture_floor(column, &u), j = texture_floor(row, &v);
    if (poles) texture_pole(x, level, t, &weight, sum);
    texture_spline(u, wx, dx);
    texture_spline(v, wy, dy);
    texture_weighted(x, level, i - 1, j - 1, 4, wx, wy, dx, dy, weight, sum);
}

// One sample by an interpolation that is not INTERP_SMART.
static inline void texture_sample(const Texture *x, int interp, int level, real s, real t, real weight, int poles,
                                  TextureSum *sum)
{
#ifdef HAS_TEXTURE_CLOSEST
    if (interp == INTERP_CLOSEST) {
        texture_closest(x, level, s, t, weight, sum);
        return;
    }
#endif
#ifdef HAS_TEXTURE_CUBIC
    if (interp == INTERP_CUBIC) {
        texture_cubic(x, level, s, t, weight, poles, sum);
        return;
    }
#endif
    texture_linear(x, level, s, t, weight, poles, sum);
}

// Which of two levels of detail to blend: the smaller number, and the share of the one behind it. `texels`: the filter's size
// in texels of each level is `size` times what `side` gives.
typedef struct {
    int fine, coarse;
    real share; // of coarse
    int finest; // even the finest level is too coarse
} TextureLevels;

static inline void texture_level_range(TextureLevels *l, int levels)
{
    l->finest = l->coarse >= 0 && l->fine < 0;
    if (l->coarse < 0) {
        l->fine = l->coarse = levels - 1;
        l->share = 0;
    } else if (l->fine < 0) {
        l->fine = l->coarse = 0;
        l->share = 0;
    }
}

// The result's channels: those that the file lacks are `fill` where the texture lies.
static inline real3 texture_filled(const Texture *x, const TextureSum *sum, real fill)
{
    real3 c = sum->value;
    const real f = sum->covered * fill;
    if (x->actual < 1) c.x = f;
    if (x->actual < 2) c.y = f;
    if (x->actual < 3) c.z = f;
    return c;
}

static inline real3 texture_absent(int mode, real fill, real3 missing)
{
    if (MODE_HAS_MISSING(mode)) return missing;
    return (real3)(fill);
}

#endif
