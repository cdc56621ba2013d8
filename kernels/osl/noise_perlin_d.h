// Perlin's noise with its partial derivatives: the forms of noise_perlin.h, named with `_d` at the end.
//
// In: coordinates, and periods, as there; then a pointer per coordinate (x y z of a point, then t). Out: the same value
// to the bit, and the partial derivatives by the coordinates, each of the result's type. Periods have none.
//
// A corner's gradient is linear in the offset, so its components are its products with the unit vectors; the rest is the
// product rule over the interpolation's weights.
#ifndef OSLCL_OSL_NOISE_PERLIN_D_H
#define OSLCL_OSL_NOISE_PERLIN_D_H

#include "osl/noise_perlin.h"

// The derivative of noise_fade.
static inline real noise_fade_d(real t) { return 30 * t * t * (t * (t - 2) + 1); }

static inline real perlin_1_d(uint2 h, uint shift, NoiseCell x, real *dx) {
    real ga = perlin_gradient_1(h.x >> shift, 1), gb = perlin_gradient_1(h.y >> shift, 1);
    real a = perlin_gradient_1(h.x >> shift, x.fraction);
    real b = perlin_gradient_1(h.y >> shift, x.fraction - 1);
    real u = noise_fade(x.fraction);
    *dx = 0.25 * (noise_lerp(ga, gb, u) + noise_fade_d(x.fraction) * (b - a));
    return 0.25 * noise_lerp(a, b, u);
}

static inline real perlin_2_d(uint4 h, uint shift, NoiseCell x, NoiseCell y, real *dx, real *dy) {
    const real4 zero = (real4)(0), one = (real4)(1);
    real4 gx = x.fraction - (real4)(0, 1, 0, 1), gy = y.fraction - (real4)(0, 0, 1, 1);
    h = h >> shift;
    real4 g = perlin_gradient_2(h, gx, gy);
    real u = noise_fade(x.fraction), v = noise_fade(y.fraction);
    real2 along_x = g.odd - g.even, along_y = g.hi - g.lo;
    real slope_x = noise_fade_d(x.fraction) * noise_lerp(along_x.x, along_x.y, v);
    real slope_y = noise_fade_d(y.fraction) * noise_lerp(along_y.x, along_y.y, u);
    *dx = 0.6616 * (noise_lerp4(perlin_gradient_2(h, one, zero), u, v) + slope_x);
    *dy = 0.6616 * (noise_lerp4(perlin_gradient_2(h, zero, one), u, v) + slope_y);
    return 0.6616 * noise_lerp4(g, u, v);
}

// Differences of the corners along x, y and z: lanes in the order of the other two.
#define PERLIN_ALONG_X(g) ((g).odd - (g).even)
#define PERLIN_ALONG_Y(g) ((g).s2367 - (g).s0145)
#define PERLIN_ALONG_Z(g) ((g).hi - (g).lo)

static inline real perlin_3_d(uint8 h, uint shift, NoiseCell x, NoiseCell y, NoiseCell z, real *dx, real *dy,
                              real *dz) {
    const real8 zero = (real8)(0), one = (real8)(1);
    real8 gx = x.fraction - (real8)(0, 1, 0, 1, 0, 1, 0, 1);
    real8 gy = y.fraction - (real8)(0, 0, 1, 1, 0, 0, 1, 1);
    real8 gz = z.fraction - (real8)(0, 0, 0, 0, 1, 1, 1, 1);
    h = h >> shift;
    real8 g = perlin_gradient_3(h, gx, gy, gz);
    real u = noise_fade(x.fraction), v = noise_fade(y.fraction), w = noise_fade(z.fraction);
    real slope_x = noise_fade_d(x.fraction) * noise_lerp4(PERLIN_ALONG_X(g), v, w);
    real slope_y = noise_fade_d(y.fraction) * noise_lerp4(PERLIN_ALONG_Y(g), u, w);
    real slope_z = noise_fade_d(z.fraction) * noise_lerp4(PERLIN_ALONG_Z(g), u, v);
    *dx = 0.982 * (noise_lerp8(perlin_gradient_3(h, one, zero, zero), u, v, w) + slope_x);
    *dy = 0.982 * (noise_lerp8(perlin_gradient_3(h, zero, one, zero), u, v, w) + slope_y);
    *dz = 0.982 * (noise_lerp8(perlin_gradient_3(h, zero, zero, one), u, v, w) + slope_z);
    return 0.982 * noise_lerp8(g, u, v, w);
}

// h: corners of the lower cell along w, k: of the upper one.
static inline real perlin_4_d(uint8 h, uint8 k, uint shift, NoiseCell x, NoiseCell y, NoiseCell z, NoiseCell w,
                              real *dx, real *dy, real *dz, real *dw) {
    const real8 zero = (real8)(0), one = (real8)(1);
    real8 gx = x.fraction - (real8)(0, 1, 0, 1, 0, 1, 0, 1);
    real8 gy = y.fraction - (real8)(0, 0, 1, 1, 0, 0, 1, 1);
    real8 gz = z.fraction - (real8)(0, 0, 0, 0, 1, 1, 1, 1);
    h = h >> shift;
    k = k >> shift;
    real8 a = perlin_gradient_4(h, gx, gy, gz, (real8)(w.fraction));
    real8 b = perlin_gradient_4(k, gx, gy, gz, (real8)(w.fraction - 1));
    real u = noise_fade(x.fraction), v = noise_fade(y.fraction), s = noise_fade(z.fraction);
    real t = noise_fade(w.fraction);
    real8 g = (1 - t) * a + t * b;
    real slope_x = noise_fade_d(x.fraction) * noise_lerp4(PERLIN_ALONG_X(g), v, s);
    real slope_y = noise_fade_d(y.fraction) * noise_lerp4(PERLIN_ALONG_Y(g), u, s);
    real slope_z = noise_fade_d(z.fraction) * noise_lerp4(PERLIN_ALONG_Z(g), u, v);
    real slope_w = noise_fade_d(w.fraction) * noise_lerp8(b - a, u, v, s);
#define PERLIN_COMPONENT_4(X, Y, Z, W)                                                                                 \
    noise_lerp8((1 - t) * perlin_gradient_4(h, X, Y, Z, W) + t * perlin_gradient_4(k, X, Y, Z, W), u, v, s)
    *dx = 0.8344 * (PERLIN_COMPONENT_4(one, zero, zero, zero) + slope_x);
    *dy = 0.8344 * (PERLIN_COMPONENT_4(zero, one, zero, zero) + slope_y);
    *dz = 0.8344 * (PERLIN_COMPONENT_4(zero, zero, one, zero) + slope_z);
    *dw = 0.8344 * (PERLIN_COMPONENT_4(zero, zero, zero, one) + slope_w);
#undef PERLIN_COMPONENT_4
    return 0.8344 * noise_lerp8(g, u, v, s);
}

// One and three values, from the cells of 1 to 4 coordinates.
static inline real perlin_f_1_d(NoiseCell x, real *dx) { return perlin_1_d(perlin_hash_1(x), 0, x, dx); }

static inline real3 perlin_v_1_d(NoiseCell x, real3 *dx) {
    uint2 h = perlin_hash_1(x);
    real x0, x1, x2;
    real3 r = (real3)(perlin_1_d(h, 0, x, &x0), perlin_1_d(h, 8, x, &x1), perlin_1_d(h, 16, x, &x2));
    *dx = (real3)(x0, x1, x2);
    return r;
}

static inline real perlin_f_2_d(NoiseCell x, NoiseCell y, real *dx, real *dy) {
    return perlin_2_d(perlin_hash_2(x, y), 0, x, y, dx, dy);
}

static inline real3 perlin_v_2_d(NoiseCell x, NoiseCell y, real3 *dx, real3 *dy) {
    uint4 h = perlin_hash_2(x, y);
    real x0, x1, x2, y0, y1, y2;
    real3 r = (real3)(perlin_2_d(h, 0, x, y, &x0, &y0), perlin_2_d(h, 8, x, y, &x1, &y1),
                      perlin_2_d(h, 16, x, y, &x2, &y2));
    *dx = (real3)(x0, x1, x2);
    *dy = (real3)(y0, y1, y2);
    return r;
}

static inline real perlin_f_3_d(NoiseCell x, NoiseCell y, NoiseCell z, real *dx, real *dy, real *dz) {
    return perlin_3_d(perlin_hash_3(x, y, z), 0, x, y, z, dx, dy, dz);
}

static inline real3 perlin_v_3_d(NoiseCell x, NoiseCell y, NoiseCell z, real3 *dx, real3 *dy, real3 *dz) {
    uint8 h = perlin_hash_3(x, y, z);
    real x0, x1, x2, y0, y1, y2, z0, z1, z2;
    real3 r = (real3)(perlin_3_d(h, 0, x, y, z, &x0, &y0, &z0), perlin_3_d(h, 8, x, y, z, &x1, &y1, &z1),
                      perlin_3_d(h, 16, x, y, z, &x2, &y2, &z2));
    *dx = (real3)(x0, x1, x2);
    *dy = (real3)(y0, y1, y2);
    *dz = (real3)(z0, z1, z2);
    return r;
}

static inline real perlin_f_4_d(NoiseCell x, NoiseCell y, NoiseCell z, NoiseCell w, real *dx, real *dy, real *dz,
                                real *dw) {
    uint8 k, h = perlin_hash_4(x, y, z, w, &k);
    return perlin_4_d(h, k, 0, x, y, z, w, dx, dy, dz, dw);
}

static inline real3 perlin_v_4_d(NoiseCell x, NoiseCell y, NoiseCell z, NoiseCell w, real3 *dx, real3 *dy, real3 *dz,
                                 real3 *dw) {
    uint8 k, h = perlin_hash_4(x, y, z, w, &k);
    real x0, x1, x2, y0, y1, y2, z0, z1, z2, w0, w1, w2;
    real3 r = (real3)(perlin_4_d(h, k, 0, x, y, z, w, &x0, &y0, &z0, &w0),
                      perlin_4_d(h, k, 8, x, y, z, w, &x1, &y1, &z1, &w1),
                      perlin_4_d(h, k, 16, x, y, z, w, &x2, &y2, &z2, &w2));
    *dx = (real3)(x0, x1, x2);
    *dy = (real3)(y0, y1, y2);
    *dz = (real3)(z0, z1, z2);
    *dw = (real3)(w0, w1, w2);
    return r;
}

// A list of macro arguments within one.
#define PERLIN_LIST(...) __VA_ARGS__

// osl_NAME_perlin_R_ARGS_d and osl_NAME_uperlin_R_ARGS_d from a form above; uperlin is half of perlin, moved.
#define PERLIN_FORM_D(NAME, R, TYPE, ARGS, N, PARAMS, CELLS, OUT, GIVE, HALVE)                                         \
    static inline TYPE osl_##NAME##_perlin_##R##_##ARGS##_d(PARAMS, OUT) {                                             \
        return perlin_##R##_##N##_d(CELLS, GIVE);                                                                      \
    }                                                                                                                  \
    static inline TYPE osl_##NAME##_uperlin_##R##_##ARGS##_d(PARAMS, OUT) {                                            \
        TYPE r = perlin_unsigned_##R(perlin_##R##_##N##_d(CELLS, GIVE));                                               \
        HALVE;                                                                                                         \
        return r;                                                                                                      \
    }

#define PERLIN_FORM_1_D(NAME, R, TYPE, ARGS, PARAMS, CELLS)                                                            \
    PERLIN_FORM_D(NAME, R, TYPE, ARGS, 1, PERLIN_LIST(PARAMS), PERLIN_LIST(CELLS), TYPE *dx, dx, *dx *= 0.5)
#define PERLIN_FORM_2_D(NAME, R, TYPE, ARGS, PARAMS, CELLS)                                                            \
    PERLIN_FORM_D(NAME, R, TYPE, ARGS, 2, PERLIN_LIST(PARAMS), PERLIN_LIST(CELLS), PERLIN_LIST(TYPE *dx, TYPE *dy),    \
                  PERLIN_LIST(dx, dy), *dx *= 0.5; *dy *= 0.5)
#define PERLIN_FORM_3_D(NAME, R, TYPE, ARGS, PARAMS, CELLS)                                                            \
    PERLIN_FORM_D(NAME, R, TYPE, ARGS, 3, PERLIN_LIST(PARAMS), PERLIN_LIST(CELLS),                                     \
                  PERLIN_LIST(TYPE *dx, TYPE *dy, TYPE *dz), PERLIN_LIST(dx, dy, dz), *dx *= 0.5; *dy *= 0.5;          \
                  *dz *= 0.5)
#define PERLIN_FORM_4_D(NAME, R, TYPE, ARGS, PARAMS, CELLS)                                                            \
    PERLIN_FORM_D(NAME, R, TYPE, ARGS, 4, PERLIN_LIST(PARAMS), PERLIN_LIST(CELLS),                                     \
                  PERLIN_LIST(TYPE *dx, TYPE *dy, TYPE *dz, TYPE *dt), PERLIN_LIST(dx, dy, dz, dt), *dx *= 0.5;        \
                  *dy *= 0.5; *dz *= 0.5; *dt *= 0.5)

#define PERLIN_FORMS_D(R, TYPE)                                                                                        \
    PERLIN_FORM_1_D(noise, R, TYPE, f, real x, noise_cell(x))                                                          \
    PERLIN_FORM_1_D(pnoise, R, TYPE, ff, PERLIN_LIST(real x, real px), noise_cell_periodic(x, px))                     \
    PERLIN_FORM_2_D(noise, R, TYPE, ff, PERLIN_LIST(real x, real y), PERLIN_LIST(noise_cell(x), noise_cell(y)))        \
    PERLIN_FORM_2_D(pnoise, R, TYPE, ffff, PERLIN_LIST(real x, real y, real px, real py),                              \
                    PERLIN_LIST(noise_cell_periodic(x, px), noise_cell_periodic(y, py)))                               \
    PERLIN_FORM_3_D(noise, R, TYPE, v, real3 p, PERLIN_LIST(noise_cell(p.x), noise_cell(p.y), noise_cell(p.z)))        \
    PERLIN_FORM_3_D(pnoise, R, TYPE, vv, PERLIN_LIST(real3 p, real3 pp),                                               \
                    PERLIN_LIST(noise_cell_periodic(p.x, pp.x), noise_cell_periodic(p.y, pp.y),                        \
                                noise_cell_periodic(p.z, pp.z)))                                                       \
    PERLIN_FORM_4_D(noise, R, TYPE, vf, PERLIN_LIST(real3 p, real t),                                                  \
                    PERLIN_LIST(noise_cell(p.x), noise_cell(p.y), noise_cell(p.z), noise_cell(t)))                     \
    PERLIN_FORM_4_D(pnoise, R, TYPE, vfvf, PERLIN_LIST(real3 p, real t, real3 pp, real pt),                            \
                    PERLIN_LIST(noise_cell_periodic(p.x, pp.x), noise_cell_periodic(p.y, pp.y),                        \
                                noise_cell_periodic(p.z, pp.z), noise_cell_periodic(t, pt)))

PERLIN_FORMS_D(f, real)
PERLIN_FORMS_D(v, real3)

#endif
