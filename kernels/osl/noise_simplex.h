// Simplex noise: `simplex` in [-1, 1], `usimplex` in [0, 1]; 1 to 4 dimensions.
//
// K. Perlin 2001, in S. Gustavson's form ("Simplex noise demystified", 2005); gradients, hash and amplitudes as in the
// reference implementation (src/include/OSL/sfm_simplex.h). The offsets from a cell are (x - cell) + skew here, which
// keeps the digits that x - (cell - skew) loses far from the origin: near it values agree to rounding, at a distance
// of 1,000 the reference is off by about 1e-4, and from 1e6 on it is 0.
// There is no periodic form. A triple uses the seeds 0, 1 and 2.
#ifndef OSLCL_OSL_NOISE_SIMPLEX_H
#define OSLCL_OSL_NOISE_SIMPLEX_H

#include "osl/noise.h"

static inline uint simplex_hash_1(uint a, uint b, uint c) {
    c ^= 0xdeadbeefu;
    HASH_FINAL(a, b, c);
    return c;
}

static inline uint4 simplex_hash_4(uint4 a, uint4 b, uint4 c) {
    c ^= 0xdeadbeefu;
    HASH_FINAL(a, b, c);
    return c;
}

static inline uint8 simplex_hash_8(uint8 a, uint8 b, uint8 c) {
    c ^= 0xdeadbeefu;
    HASH_FINAL(a, b, c);
    return c;
}

// A gradient's component: +1 in the lanes whose bit h of `plus` is set, -1 for `minus`, else 0.
static inline real4 simplex_sign_4(uint4 h, uint plus, uint minus) {
    return NOISE_REAL4(as_int4(((uint4)(plus) >> h) & 1u) - as_int4(((uint4)(minus) >> h) & 1u));
}

static inline real8 simplex_sign_8(uint8 h, uint plus, uint minus) {
    return NOISE_REAL8(as_int8(((uint8)(plus) >> h) & 1u) - as_int8(((uint8)(minus) >> h) & 1u));
}

static inline real simplex_gradient(uint i, uint seed) {
    uint h = simplex_hash_1(i, seed, 0u);
    return NOISE_FLIP((real)(1u + (h & 7u)), h << 28);
}

// Sets the values for seeds 0 to n - 1.
static inline void simplex_1(real x, int n, real *out) {
    NoiseCell cell = noise_cell(x);
    real x0 = cell.fraction, x1 = x0 - 1;
    real t0 = 1 - x0 * x0, t1 = 1 - x1 * x1;
    t0 *= t0;
    t1 *= t1;
    for (int seed = 0; seed < n; ++seed) {
        real a = t0 * t0 * simplex_gradient(cell.lower, seed) * x0;
        out[seed] = 0.36 * (a + t1 * t1 * simplex_gradient(cell.upper, seed) * x1);
    }
}

// (1/2 - r^2)^4, 0 beyond.
static inline real4 simplex_weight_4(real4 r2) {
    real4 t = fmax(0.5 - r2, 0);
    t *= t;
    return t * t;
}

static inline real8 simplex_weight_8(real8 r2) {
    real8 t = fmax(0.5 - r2, 0);
    t *= t;
    return t * t;
}

// Three corners; the fourth lane is masked out.
static inline void simplex_2(real x, real y, int n, real *out) {
    const real skew = 0.36602540378443864676, unskew = 0.21132486540518711775; // (sqrt 3 - 1) / 2, (3 - sqrt 3) / 6
    real s = (x + y) * skew;
    real i = floor(x + s), j = floor(y + s);
    real t = (i + j) * unskew;
    real x0 = (x - i) + t, y0 = (y - j) + t;
    uint first = x0 > y0;
    uint4 ci = (uint)(int)i + (uint4)(0, first, 1, 0), cj = (uint)(int)j + (uint4)(0, 1u - first, 1, 0);
    real f = first;
    real4 dx = x0 + (real4)(0, unskew - f, 2 * unskew - 1, 0);
    real4 dy = y0 + (real4)(0, unskew - (1 - f), 2 * unskew - 1, 0);
    real4 w = simplex_weight_4(dx * dx + dy * dy) * (real4)(1, 1, 1, 0);
    for (int seed = 0; seed < n; ++seed) {
        uint4 h = simplex_hash_4(ci, cj, (uint4)(seed)) & 7u;
        real4 g = w * (simplex_sign_4(h, 0x8au, 0x15u) * dx + simplex_sign_4(h, 0x58u, 0xa1u) * dy);
        out[seed] = 64 * (g.x + g.y + g.z);
    }
}

// Four corners: the origin of the cell, then a step along the largest offset, one along the next, the far corner.
static inline void simplex_3(real x, real y, real z, int n, real *out) {
    real s = (x + y + z) * (1 / 3.0);
    real i = floor(x + s), j = floor(y + s), k = floor(z + s);
    real t = (i + j + k) * (1 / 6.0);
    real x0 = (x - i) + t, y0 = (y - j) + t, z0 = (z - k) + t;
    uint xy = x0 >= y0, yz = y0 >= z0, xz = x0 >= z0;
    uint rank_x = xy + xz, rank_y = 1u - xy + yz, rank_z = 2u - xz - yz; // how many coordinates each one exceeds
    uint4 oi = (uint4)(0, rank_x == 2u, rank_x >= 1u, 1);
    uint4 oj = (uint4)(0, rank_y == 2u, rank_y >= 1u, 1);
    uint4 ok = (uint4)(0, rank_z == 2u, rank_z >= 1u, 1);
    uint4 ci = (uint)(int)i + oi, cj = (uint)(int)j + oj, ck = (uint)(int)k + ok;
    real4 back = (real4)(0, 1 / 6.0, 2 / 6.0, 3 / 6.0);
    real4 dx = x0 - NOISE_REAL4(oi) + back, dy = y0 - NOISE_REAL4(oj) + back, dz = z0 - NOISE_REAL4(ok) + back;
    real4 w = simplex_weight_4(dx * dx + dy * dy + dz * dz);
    for (int seed = 0; seed < n; ++seed) {
        uint4 h = simplex_hash_4(ci, cj, simplex_hash_4(ck, (uint4)(seed), (uint4)(0))) & 15u;
        real4 g = simplex_sign_4(h, 0x1311u, 0x2c44u) * dx + simplex_sign_4(h, 0x4622u, 0x8988u) * dy;
        g = w * (g + simplex_sign_4(h, 0x300fu, 0xc0f0u) * dz);
        out[seed] = 68 * (g.x + g.y + g.z + g.w);
    }
}

// Five corners; three lanes are masked out.
static inline void simplex_4(real x, real y, real z, real w, int n, real *out) {
    const real skew = 0.30901699437494742410, unskew = 0.13819660112501051518; // (sqrt 5 - 1) / 4, (5 - sqrt 5) / 20
    real s = (x + y + z + w) * skew;
    real i = floor(x + s), j = floor(y + s), k = floor(z + s), l = floor(w + s);
    real t = (i + j + k + l) * unskew;
    real x0 = (x - i) + t, y0 = (y - j) + t, z0 = (z - k) + t, w0 = (w - l) + t;
    uint xy = x0 > y0, xz = x0 > z0, yz = y0 > z0, xw = x0 > w0, yw = y0 > w0, zw = z0 > w0;
    uint rank_x = xy + xz + xw, rank_y = 1u - xy + yz + yw, rank_z = 2u - xz - yz + zw, rank_w = 3u - xw - yw - zw;
    uint8 oi = (uint8)(0, rank_x == 3u, rank_x >= 2u, rank_x >= 1u, 1, 0, 0, 0);
    uint8 oj = (uint8)(0, rank_y == 3u, rank_y >= 2u, rank_y >= 1u, 1, 0, 0, 0);
    uint8 ok = (uint8)(0, rank_z == 3u, rank_z >= 2u, rank_z >= 1u, 1, 0, 0, 0);
    uint8 ol = (uint8)(0, rank_w == 3u, rank_w >= 2u, rank_w >= 1u, 1, 0, 0, 0);
    uint8 ci = (uint)(int)i + oi, cj = (uint)(int)j + oj, ck = (uint)(int)k + ok, cl = (uint)(int)l + ol;
    real8 back = unskew * (real8)(0, 1, 2, 3, 4, 0, 0, 0);
    real8 dx = x0 - NOISE_REAL8(oi) + back, dy = y0 - NOISE_REAL8(oj) + back;
    real8 dz = z0 - NOISE_REAL8(ok) + back, dw = w0 - NOISE_REAL8(ol) + back;
    real8 weight = simplex_weight_8(dx * dx + dy * dy + dz * dz + dw * dw) * (real8)(1, 1, 1, 1, 1, 0, 0, 0);
    for (int seed = 0; seed < n; ++seed) {
        uint8 h = simplex_hash_8(ci, cj, simplex_hash_8(ck, cl, (uint8)(seed))) & 31u;
        real8 g = simplex_sign_8(h, 0x0f0f0f00u, 0xf0f0f000u) * dx + simplex_sign_8(h, 0x3333000fu, 0xcccc00f0u) * dy;
        g += simplex_sign_8(h, 0x55003333u, 0xaa00ccccu) * dz + simplex_sign_8(h, 0x00555555u, 0x00aaaaaau) * dw;
        g *= weight;
        out[seed] = 54 * (g.s0 + g.s1 + g.s2 + g.s3 + g.s4);
    }
}

// osl_noise_simplex_R_ARGS and osl_noise_usimplex_R_ARGS from CALL.
#define SIMPLEX_FORM(ARGS, PARAMS, CALL)                                                                               \
    static inline real osl_noise_simplex_f_##ARGS PARAMS {                                                             \
        const int n = 1;                                                                                               \
        real out[1];                                                                                                   \
        CALL;                                                                                                          \
        return out[0];                                                                                                 \
    }                                                                                                                  \
    static inline real3 osl_noise_simplex_v_##ARGS PARAMS {                                                            \
        const int n = 3;                                                                                               \
        real out[3];                                                                                                   \
        CALL;                                                                                                          \
        return (real3)(out[0], out[1], out[2]);                                                                        \
    }                                                                                                                  \
    static inline real osl_noise_usimplex_f_##ARGS PARAMS {                                                            \
        const int n = 1;                                                                                               \
        real out[1];                                                                                                   \
        CALL;                                                                                                          \
        return 0.5 * (out[0] + 1);                                                                                     \
    }                                                                                                                  \
    static inline real3 osl_noise_usimplex_v_##ARGS PARAMS {                                                           \
        const int n = 3;                                                                                               \
        real out[3];                                                                                                   \
        CALL;                                                                                                          \
        return 0.5 * ((real3)(out[0], out[1], out[2]) + 1);                                                            \
    }

SIMPLEX_FORM(f, (real x), simplex_1(x, n, out))
SIMPLEX_FORM(ff, (real x, real y), simplex_2(x, y, n, out))
SIMPLEX_FORM(v, (real3 p), simplex_3(p.x, p.y, p.z, n, out))
SIMPLEX_FORM(vf, (real3 p, real t), simplex_4(p.x, p.y, p.z, t, n, out))

#endif
