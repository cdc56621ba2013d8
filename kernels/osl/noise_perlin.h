// Perlin's gradient noise: `perlin` (= snoise, in [-1, 1]), `uperlin` (= noise, in [0, 1]), and their periodic forms.
//
// K. Perlin, "Improving Noise", SIGGRAPH 2002; gradients and amplitudes as in the reference implementation
// (src/include/OSL/oslnoise.h), so values agree to rounding. The three values of a triple take their gradients from
// bits 0, 8 and 16 of one hash.
#ifndef OSLCL_OSL_NOISE_PERLIN_H
#define OSLCL_OSL_NOISE_PERLIN_H

#include "osl/noise.h"

// Gradients times offsets for the hash h of each corner; only the low bits of h count.
static inline real perlin_gradient_1(uint h, real x) { return NOISE_FLIP((real)(1u + (h & 7u)) * x, h << 28); }

static inline real4 perlin_gradient_2(uint4 h, real4 x, real4 y) {
    int4 swap = (h & 4u) == 0u;
    real4 u = NOISE_PICK4(swap, x, y), v = NOISE_PICK4(swap, y, x);
    return NOISE_FLIP4(u, h << 31) + NOISE_FLIP4(v + v, h << 30);
}

static inline real8 perlin_gradient_3(uint8 h, real8 x, real8 y, real8 z) {
    real8 u = NOISE_PICK8((h & 8u) == 0u, x, y);
    real8 v = NOISE_PICK8((h & 12u) == 0u, y, NOISE_PICK8((h & 13u) == 12u, x, z));
    return NOISE_FLIP8(u, h << 31) + NOISE_FLIP8(v, h << 30);
}

static inline real8 perlin_gradient_4(uint8 h, real8 x, real8 y, real8 z, real8 w) {
    real8 u = NOISE_PICK8((h & 24u) != 24u, x, y);
    real8 v = NOISE_PICK8((h & 16u) == 0u, y, z);
    real8 s = NOISE_PICK8((h & 24u) == 0u, z, w);
    return NOISE_FLIP8(u, h << 31) + NOISE_FLIP8(v, h << 30) + NOISE_FLIP8(s, h << 29);
}

static inline real perlin_1(uint2 h, uint shift, NoiseCell x) {
    real a = perlin_gradient_1(h.x >> shift, x.fraction);
    real b = perlin_gradient_1(h.y >> shift, x.fraction - 1);
    return 0.25 * noise_lerp(a, b, noise_fade(x.fraction));
}

static inline real perlin_2(uint4 h, uint shift, NoiseCell x, NoiseCell y) {
    real4 gx = x.fraction - (real4)(0, 1, 0, 1), gy = y.fraction - (real4)(0, 0, 1, 1);
    real4 g = perlin_gradient_2(h >> shift, gx, gy);
    return 0.6616 * noise_lerp4(g, noise_fade(x.fraction), noise_fade(y.fraction));
}

static inline real perlin_3(uint8 h, uint shift, NoiseCell x, NoiseCell y, NoiseCell z) {
    real8 gx = x.fraction - (real8)(0, 1, 0, 1, 0, 1, 0, 1);
    real8 gy = y.fraction - (real8)(0, 0, 1, 1, 0, 0, 1, 1);
    real8 gz = z.fraction - (real8)(0, 0, 0, 0, 1, 1, 1, 1);
    real8 g = perlin_gradient_3(h >> shift, gx, gy, gz);
    return 0.982 * noise_lerp8(g, noise_fade(x.fraction), noise_fade(y.fraction), noise_fade(z.fraction));
}

// h: corners of the lower cell along w, k: of the upper one.
static inline real perlin_4(uint8 h, uint8 k, uint shift, NoiseCell x, NoiseCell y, NoiseCell z, NoiseCell w) {
    real8 gx = x.fraction - (real8)(0, 1, 0, 1, 0, 1, 0, 1);
    real8 gy = y.fraction - (real8)(0, 0, 1, 1, 0, 0, 1, 1);
    real8 gz = z.fraction - (real8)(0, 0, 0, 0, 1, 1, 1, 1);
    real8 a = perlin_gradient_4(h >> shift, gx, gy, gz, (real8)(w.fraction));
    real8 b = perlin_gradient_4(k >> shift, gx, gy, gz, (real8)(w.fraction - 1));
    real t = noise_fade(w.fraction);
    a = (1 - t) * a + t * b;
    return 0.8344 * noise_lerp8(a, noise_fade(x.fraction), noise_fade(y.fraction), noise_fade(z.fraction));
}

static inline uint2 perlin_hash_1(NoiseCell x) { return (uint2)(hash_1(x.lower), hash_1(x.upper)); }

static inline uint4 perlin_hash_2(NoiseCell x, NoiseCell y) {
    uint4 a = HASH_SEED(2) + x.lower + ((uint4)(0, ~0u, 0, ~0u) & (x.upper - x.lower));
    uint4 b = HASH_SEED(2) + y.lower + ((uint4)(0, 0, ~0u, ~0u) & (y.upper - y.lower));
    uint4 c = HASH_SEED(2);
    HASH_FINAL(a, b, c);
    return c;
}

// The words of the 8 corners, n of them in all.
#define PERLIN_CORNERS(n)                                                                                              \
    uint8 a = HASH_SEED(n) + x.lower + ((uint8)(0, ~0u, 0, ~0u, 0, ~0u, 0, ~0u) & (x.upper - x.lower));                \
    uint8 b = HASH_SEED(n) + y.lower + ((uint8)(0, 0, ~0u, ~0u, 0, 0, ~0u, ~0u) & (y.upper - y.lower));                \
    uint8 c = HASH_SEED(n) + z.lower + ((uint8)(0, 0, 0, 0, ~0u, ~0u, ~0u, ~0u) & (z.upper - z.lower))

static inline uint8 perlin_hash_3(NoiseCell x, NoiseCell y, NoiseCell z) {
    PERLIN_CORNERS(3);
    HASH_FINAL(a, b, c);
    return c;
}

static inline uint8 perlin_hash_4(NoiseCell x, NoiseCell y, NoiseCell z, NoiseCell w, uint8 *upper) {
    PERLIN_CORNERS(4);
    HASH_MIX(a, b, c);
    uint8 d = a + w.upper, e = b, f = c;
    a += w.lower;
    HASH_FINAL(a, b, c);
    HASH_FINAL(d, e, f);
    *upper = f;
    return c;
}

static inline real perlin_unsigned_f(real x) { return 0.5 * (x + 1); }
static inline real3 perlin_unsigned_v(real3 x) { return 0.5 * (x + 1); }

// One and three values, from the cells of 1 to 4 coordinates.
static inline real perlin_f_1(NoiseCell x) { return perlin_1(perlin_hash_1(x), 0, x); }

static inline real3 perlin_v_1(NoiseCell x) {
    uint2 h = perlin_hash_1(x);
    return (real3)(perlin_1(h, 0, x), perlin_1(h, 8, x), perlin_1(h, 16, x));
}

static inline real perlin_f_2(NoiseCell x, NoiseCell y) { return perlin_2(perlin_hash_2(x, y), 0, x, y); }

static inline real3 perlin_v_2(NoiseCell x, NoiseCell y) {
    uint4 h = perlin_hash_2(x, y);
    return (real3)(perlin_2(h, 0, x, y), perlin_2(h, 8, x, y), perlin_2(h, 16, x, y));
}

static inline real perlin_f_3(NoiseCell x, NoiseCell y, NoiseCell z) {
    return perlin_3(perlin_hash_3(x, y, z), 0, x, y, z);
}

static inline real3 perlin_v_3(NoiseCell x, NoiseCell y, NoiseCell z) {
    uint8 h = perlin_hash_3(x, y, z);
    return (real3)(perlin_3(h, 0, x, y, z), perlin_3(h, 8, x, y, z), perlin_3(h, 16, x, y, z));
}

static inline real perlin_f_4(NoiseCell x, NoiseCell y, NoiseCell z, NoiseCell w) {
    uint8 k, h = perlin_hash_4(x, y, z, w, &k);
    return perlin_4(h, k, 0, x, y, z, w);
}

static inline real3 perlin_v_4(NoiseCell x, NoiseCell y, NoiseCell z, NoiseCell w) {
    uint8 k, h = perlin_hash_4(x, y, z, w, &k);
    return (real3)(perlin_4(h, k, 0, x, y, z, w), perlin_4(h, k, 8, x, y, z, w), perlin_4(h, k, 16, x, y, z, w));
}

// osl_noise_perlin_*, osl_noise_uperlin_*, osl_pnoise_perlin_*, osl_pnoise_uperlin_* with result R of type TYPE.
#define PERLIN_FORMS(R, TYPE)                                                                                          \
    static inline TYPE osl_noise_perlin_##R##_f(real x) { return perlin_##R##_1(noise_cell(x)); }                      \
    static inline TYPE osl_noise_perlin_##R##_ff(real x, real y) {                                                     \
        return perlin_##R##_2(noise_cell(x), noise_cell(y));                                                           \
    }                                                                                                                  \
    static inline TYPE osl_noise_perlin_##R##_v(real3 p) {                                                             \
        return perlin_##R##_3(noise_cell(p.x), noise_cell(p.y), noise_cell(p.z));                                      \
    }                                                                                                                  \
    static inline TYPE osl_noise_perlin_##R##_vf(real3 p, real t) {                                                    \
        return perlin_##R##_4(noise_cell(p.x), noise_cell(p.y), noise_cell(p.z), noise_cell(t));                       \
    }                                                                                                                  \
    static inline TYPE osl_pnoise_perlin_##R##_ff(real x, real px) {                                                   \
        return perlin_##R##_1(noise_cell_periodic(x, px));                                                             \
    }                                                                                                                  \
    static inline TYPE osl_pnoise_perlin_##R##_ffff(real x, real y, real px, real py) {                                \
        return perlin_##R##_2(noise_cell_periodic(x, px), noise_cell_periodic(y, py));                                 \
    }                                                                                                                  \
    static inline TYPE osl_pnoise_perlin_##R##_vv(real3 p, real3 pp) {                                                 \
        return perlin_##R##_3(noise_cell_periodic(p.x, pp.x), noise_cell_periodic(p.y, pp.y),                          \
                              noise_cell_periodic(p.z, pp.z));                                                         \
    }                                                                                                                  \
    static inline TYPE osl_pnoise_perlin_##R##_vfvf(real3 p, real t, real3 pp, real pt) {                              \
        return perlin_##R##_4(noise_cell_periodic(p.x, pp.x), noise_cell_periodic(p.y, pp.y),                          \
                              noise_cell_periodic(p.z, pp.z), noise_cell_periodic(t, pt));                             \
    }                                                                                                                  \
    static inline TYPE osl_noise_uperlin_##R##_f(real x) {                                                             \
        return perlin_unsigned_##R(osl_noise_perlin_##R##_f(x));                                                       \
    }                                                                                                                  \
    static inline TYPE osl_noise_uperlin_##R##_ff(real x, real y) {                                                    \
        return perlin_unsigned_##R(osl_noise_perlin_##R##_ff(x, y));                                                   \
    }                                                                                                                  \
    static inline TYPE osl_noise_uperlin_##R##_v(real3 p) {                                                            \
        return perlin_unsigned_##R(osl_noise_perlin_##R##_v(p));                                                       \
    }                                                                                                                  \
    static inline TYPE osl_noise_uperlin_##R##_vf(real3 p, real t) {                                                   \
        return perlin_unsigned_##R(osl_noise_perlin_##R##_vf(p, t));                                                   \
    }                                                                                                                  \
    static inline TYPE osl_pnoise_uperlin_##R##_ff(real x, real px) {                                                  \
        return perlin_unsigned_##R(osl_pnoise_perlin_##R##_ff(x, px));                                                 \
    }                                                                                                                  \
    static inline TYPE osl_pnoise_uperlin_##R##_ffff(real x, real y, real px, real py) {                               \
        return perlin_unsigned_##R(osl_pnoise_perlin_##R##_ffff(x, y, px, py));                                        \
    }                                                                                                                  \
    static inline TYPE osl_pnoise_uperlin_##R##_vv(real3 p, real3 pp) {                                                \
        return perlin_unsigned_##R(osl_pnoise_perlin_##R##_vv(p, pp));                                                 \
    }                                                                                                                  \
    static inline TYPE osl_pnoise_uperlin_##R##_vfvf(real3 p, real t, real3 pp, real pt) {                             \
        return perlin_unsigned_##R(osl_pnoise_perlin_##R##_vfvf(p, t, pp, pt));                                        \
    }

PERLIN_FORMS(f, real)
PERLIN_FORMS(v, real3)

#endif
