// Simplex noise with its partial derivatives: the forms of noise_simplex.h, named with `_d` at the end.
//
// In: coordinates as there; then a pointer per coordinate (x y z of a point, then t). Out: the same value to rounding, and
// the partial derivatives by the coordinates, each of the result's type.
//
// A corner contributes w^4 (g . d), d the offset from it and w = 1/2 - d . d (in one dimension 1 - d . d), so the partial
// derivatives are w^4 g - 8 w^3 (g . d) d (S. Gustavson, "Simplex noise demystified", 2005).
#ifndef OSLCL_OSL_NOISE_SIMPLEX_D_H
#define OSLCL_OSL_NOISE_SIMPLEX_D_H

#include "osl/noise_simplex.h"

// Each sets values and derivatives for the seeds 0 to n - 1.
static inline void simplex_1_d(real x, int n, real *out, real *dx) {
    NoiseCell cell = noise_cell(x);
    real2 d = cell.fraction - (real2)(0, 1);
    real2 w = 1 - d * d;
    real2 w2 = w * w;
    for (int seed = 0; seed < n; ++seed) {
        real2 g = (real2)(simplex_gradient(cell.lower, seed), simplex_gradient(cell.upper, seed));
        real2 value = w2 * w2 * g * d;
        real2 slope = w2 * g * (w2 - 8 * w * d * d);
        out[seed] = 0.36 * (value.x + value.y);
        dx[seed] = 0.36 * (slope.x + slope.y);
    }
}

static inline real simplex_sum_3(real4 v) { return v.x + v.y + v.z; }
static inline real simplex_sum_4(real4 v) { return v.x + v.y + v.z + v.w; }
static inline real simplex_sum_5(real8 v) { return v.s0 + v.s1 + v.s2 + v.s3 + v.s4; }

static inline void simplex_2_d(real x, real y, int n, real *out, real *px, real *py) {
    const real skew = 0.36602540378443864676, unskew = 0.21132486540518711775; // (sqrt 3 - 1) / 2, (3 - sqrt 3) / 6
    real s = (x + y) * skew;
    real i = floor(x + s), j = floor(y + s);
    real t = (i + j) * unskew;
    real x0 = (x - i) + t, y0 = (y - j) + t;
    uint first = x0 > y0;
    real f = (real)first;
    uint4 ci = (uint)(int)i + (uint4)(0, first, 1, 0), cj = (uint)(int)j + (uint4)(0, 1u - first, 1, 0);
    real4 dx = x0 + (real4)(0, unskew - f, 2 * unskew - 1, 0);
    real4 dy = y0 + (real4)(0, unskew - (1 - f), 2 * unskew - 1, 0);
    real4 w = fmax(0.5 - (dx * dx + dy * dy), 0) * (real4)(1, 1, 1, 0); // the fourth lane is no corner
    real4 w2 = w * w, w3 = w2 * w;
    real4 w4 = w2 * w2;
    for (int seed = 0; seed < n; ++seed) {
        uint4 h = simplex_hash_4(ci, cj, (uint4)(seed)) & 7u;
        real4 gx = simplex_sign_4(h, 0x8au, 0x15u), gy = simplex_sign_4(h, 0x58u, 0xa1u);
        real4 g = gx * dx + gy * dy;
        out[seed] = 64 * simplex_sum_3(w4 * g);
        g *= -8 * w3;
        px[seed] = 64 * simplex_sum_3(w4 * gx + g * dx);
        py[seed] = 64 * simplex_sum_3(w4 * gy + g * dy);
    }
}

static inline void simplex_3_d(real x, real y, real z, int n, real *out, real *px, real *py, real *pz) {
    real s = (x + y + z) * (1 / 3.0);
    real i = floor(x + s), j = floor(y + s), k = floor(z + s);
    real t = (i + j + k) * (1 / 6.0);
    real x0 = (x - i) + t, y0 = (y - j) + t, z0 = (z - k) + t;
    uint xy = x0 >= y0, yz = y0 >= z0, xz = x0 >= z0;
    uint rank_x = xy + xz, rank_y = 1u - xy + yz, rank_z = 2u - xz - yz;
    uint4 oi = (uint4)(0, rank_x == 2u, rank_x >= 1u, 1);
    uint4 oj = (uint4)(0, rank_y == 2u, rank_y >= 1u, 1);
    uint4 ok = (uint4)(0, rank_z == 2u, rank_z >= 1u, 1);
    uint4 ci = (uint)(int)i + oi, cj = (uint)(int)j + oj, ck = (uint)(int)k + ok;
    real4 back = (real4)(0, 1 / 6.0, 2 / 6.0, 3 / 6.0);
    real4 dx = x0 - NOISE_REAL4(oi) + back, dy = y0 - NOISE_REAL4(oj) + back, dz = z0 - NOISE_REAL4(ok) + back;
    real4 w = fmax(0.5 - (dx * dx + dy * dy + dz * dz), 0);
    real4 w2 = w * w, w3 = w2 * w;
    real4 w4 = w2 * w2;
    for (int seed = 0; seed < n; ++seed) {
        uint4 h = simplex_hash_4(ci, cj, simplex_hash_4(ck, (uint4)(seed), (uint4)(0))) & 15u;
        real4 gx = simplex_sign_4(h, 0x1311u, 0x2c44u), gy = simplex_sign_4(h, 0x4622u, 0x8988u);
        real4 gz = simplex_sign_4(h, 0x300fu, 0xc0f0u);
        real4 g = gx * dx + gy * dy + gz * dz;
        out[seed] = 68 * simplex_sum_4(w4 * g);
        g *= -8 * w3;
        px[seed] = 68 * simplex_sum_4(w4 * gx + g * dx);
        py[seed] = 68 * simplex_sum_4(w4 * gy + g * dy);
        pz[seed] = 68 * simplex_sum_4(w4 * gz + g * dz);
    }
}

static inline void simplex_4_d(real x, real y, real z, real w, int n, real *out, real *px, real *py, real *pz,
                               real *pw) {
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
    real8 r = fmax(0.5 - (dx * dx + dy * dy + dz * dz + dw * dw), 0) * (real8)(1, 1, 1, 1, 1, 0, 0, 0);
    real8 r2 = r * r, r3 = r2 * r;
    real8 r4 = r2 * r2;
    for (int seed = 0; seed < n; ++seed) {
        uint8 h = simplex_hash_8(ci, cj, simplex_hash_8(ck, cl, (uint8)(seed))) & 31u;
        real8 gx = simplex_sign_8(h, 0x0f0f0f00u, 0xf0f0f000u), gy = simplex_sign_8(h, 0x3333000fu, 0xcccc00f0u);
        real8 gz = simplex_sign_8(h, 0x55003333u, 0xaa00ccccu), gw = simplex_sign_8(h, 0x00555555u, 0x00aaaaaau);
        real8 g = gx * dx + gy * dy + gz * dz + gw * dw;
        out[seed] = 54 * simplex_sum_5(r4 * g);
        g *= -8 * r3;
        px[seed] = 54 * simplex_sum_5(r4 * gx + g * dx);
        py[seed] = 54 * simplex_sum_5(r4 * gy + g * dy);
        pz[seed] = 54 * simplex_sum_5(r4 * gz + g * dz);
        pw[seed] = 54 * simplex_sum_5(r4 * gw + g * dw);
    }
}

#define SIMPLEX_TRIPLE(a) ((real3)((a)[0], (a)[1], (a)[2]))

// osl_noise_simplex_R_ARGS_d and osl_noise_usimplex_R_ARGS_d; usimplex is half of simplex, moved. READ gives an array's
// values as the result's type.
#define SIMPLEX_FORMS_D(R, TYPE, N, READ)                                                                              \
    static inline TYPE osl_noise_simplex_##R##_f_d(real x, TYPE *dx) {                                                 \
        real out[N], px[N];                                                                                            \
        simplex_1_d(x, N, out, px);                                                                                    \
        *dx = READ(px);                                                                                                \
        return READ(out);                                                                                              \
    }                                                                                                                  \
    static inline TYPE osl_noise_simplex_##R##_ff_d(real x, real y, TYPE *dx, TYPE *dy) {                              \
        real out[N], px[N], py[N];                                                                                     \
        simplex_2_d(x, y, N, out, px, py);                                                                             \
        *dx = READ(px);                                                                                                \
        *dy = READ(py);                                                                                                \
        return READ(out);                                                                                              \
    }                                                                                                                  \
    static inline TYPE osl_noise_simplex_##R##_v_d(real3 p, TYPE *dx, TYPE *dy, TYPE *dz) {                            \
        real out[N], px[N], py[N], pz[N];                                                                              \
        simplex_3_d(p.x, p.y, p.z, N, out, px, py, pz);                                                                \
        *dx = READ(px);                                                                                                \
        *dy = READ(py);                                                                                                \
        *dz = READ(pz);                                                                                                \
        return READ(out);                                                                                              \
    }                                                                                                                  \
    static inline TYPE osl_noise_simplex_##R##_vf_d(real3 p, real t, TYPE *dx, TYPE *dy, TYPE *dz, TYPE *dt) {         \
        real out[N], px[N], py[N], pz[N], pt[N];                                                                       \
        simplex_4_d(p.x, p.y, p.z, t, N, out, px, py, pz, pt);                                                         \
        *dx = READ(px);                                                                                                \
        *dy = READ(py);                                                                                                \
        *dz = READ(pz);                                                                                                \
        *dt = READ(pt);                                                                                                \
        return READ(out);                                                                                              \
    }                                                                                                                  \
    static inline TYPE osl_noise_usimplex_##R##_f_d(real x, TYPE *dx) {                                                \
        TYPE r = osl_noise_simplex_##R##_f_d(x, dx);                                                                   \
        *dx *= 0.5;                                                                                                    \
        return 0.5 * (r + 1);                                                                                          \
    }                                                                                                                  \
    static inline TYPE osl_noise_usimplex_##R##_ff_d(real x, real y, TYPE *dx, TYPE *dy) {                             \
        TYPE r = osl_noise_simplex_##R##_ff_d(x, y, dx, dy);                                                           \
        *dx *= 0.5;                                                                                                    \
        *dy *= 0.5;                                                                                                    \
        return 0.5 * (r + 1);                                                                                          \
    }                                                                                                                  \
    static inline TYPE osl_noise_usimplex_##R##_v_d(real3 p, TYPE *dx, TYPE *dy, TYPE *dz) {                           \
        TYPE r = osl_noise_simplex_##R##_v_d(p, dx, dy, dz);                                                           \
        *dx *= 0.5;                                                                                                    \
        *dy *= 0.5;                                                                                                    \
        *dz *= 0.5;                                                                                                    \
        return 0.5 * (r + 1);                                                                                          \
    }                                                                                                                  \
    static inline TYPE osl_noise_usimplex_##R##_vf_d(real3 p, real t, TYPE *dx, TYPE *dy, TYPE *dz, TYPE *dt) {        \
        TYPE r = osl_noise_simplex_##R##_vf_d(p, t, dx, dy, dz, dt);                                                   \
        *dx *= 0.5;                                                                                                    \
        *dy *= 0.5;                                                                                                    \
        *dz *= 0.5;                                                                                                    \
        *dt *= 0.5;                                                                                                    \
        return 0.5 * (r + 1);                                                                                          \
    }

#define SIMPLEX_FLOAT(a) ((a)[0])

SIMPLEX_FORMS_D(f, real, 1, SIMPLEX_FLOAT)
SIMPLEX_FORMS_D(v, real3, 3, SIMPLEX_TRIPLE)

#endif
