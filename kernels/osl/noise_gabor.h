// Gabor noise: sparse kernels, each a wave under a Gaussian, summed; in about [-1, 1]. Also its periodic form.
//
// A. Lagae et al., "Procedural Noise using Sparse Gabor Convolution", SIGGRAPH 2009, and "Filtering Solid Gabor Noise",
// SIGGRAPH 2011 (equations cited below are of 2011); sampling, constants and amplitude as in the reference implementation
// (src/liboslnoise/gabornoise.cpp), so values agree to rounding. Fewer than three coordinates are a slice at zero; a
// fourth one does nothing there, so `lower` drops it.
//
// In: p and its differences between neighbouring pixels (dpdx, dpdy; zero where they are not known: then nothing is
// filtered); under a period, cells are numbered modulo its whole part, at least 1; the options: anisotropic 0 (waves of
// any direction), 1 (along `direction`), else waves in the plane z = 0, as long as `direction`; bandwidth in
// octaves, 0.01 to 100; impulses per sphere, 1 to 32; do_filter. Out: the value, or three for the seeds 0, 1 and 2. The
// forms that end with `_d` set partial derivatives by p.x, p.y and p.z too; the filter counts as constant in them.
//
// Random numbers are floats in f64, too, so that both precisions place the same kernels.
#ifndef OSLCL_OSL_NOISE_GABOR_H
#define OSLCL_OSL_NOISE_GABOR_H

#include "maths.h"
#include "osl/noise.h"

#define GABOR_FREQUENCY 2
#define GABOR_WIDTH ((real)2.128934f)    // sqrt(pi / ln 2), as the reference rounds it
#define GABOR_SPHERE (1.33333 * PI)      // volume of the unit sphere, as the reference rounds it
#define GABOR_CUT 3.91202300542814605862 // -log 0.02: kernels end where their Gaussian falls to 0.02

// A symmetric 2x2 matrix.
typedef struct {
    real xx, xy, yy;
} Gabor22;

static inline real gabor_det(Gabor22 m) { return m.xx * m.yy - m.xy * m.xy; }
static inline real2 gabor_mul(Gabor22 m, real2 v) { return (real2)(v.x * m.xx + v.y * m.xy, v.x * m.xy + v.y * m.yy); }

static inline Gabor22 gabor_inverse(Gabor22 m) {
    real d = 1 / gabor_det(m);
    Gabor22 r = {m.yy * d, -m.xy * d, m.xx * d};
    return r;
}

// What all kernels of a call share.
typedef struct {
    int anisotropic, filtered, periodic;
    real3 direction, period;
    real a;               // inverse width of the Gaussian
    real radius;          // of a kernel, and the size of a cell
    float mean;           // kernels per cell
    real amplitude;
    real3 t, b, n;        // tangent space of the pixel's footprint
    real weight;          // eq. 10's factor that does not depend on the kernel,
    Gabor22 spread, turn; // the matrices that do its exponent and the wave's new frequency,
    real filtered_a;      // and the new Gaussian
} Gabor;

typedef struct {
    uint state;
} GaborRandom;

// In [0, 1]: a multiplicative generator (Borosh and Niederreiter, 1983).
static inline float gabor_random(GaborRandom *r) {
    r->state *= 3039177861u;
    return (float)r->state * 2.3283064365386963e-10;
}

static inline GaborRandom gabor_seed(uint x, uint y, uint z, uint seed) {
    GaborRandom r;
    uint h = hash_4(x, y, z, seed);
    r.state = h == 0u ? 1u : h;
    return r;
}

// A coordinate of a cell modulo the whole part of the period, at least 1.
static inline real gabor_wrap(real cell, real period) {
    real p = floor(period);
    p = p < 1 ? 1 : p;
    return cell - p * floor(cell / p);
}

static inline real3 gabor_unit(real3 v) {
    real length = sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return length == 0 ? v : v / length;
}

// Eq. 10 for the footprint of a pixel, a Gaussian of half a pixel's width. The matrix from the screen to tangent space is
// the reference's. Tiny footprints are not filtered: it would change nothing, and divide by about 0.
static inline void gabor_filter(Gabor *g, real3 dpdx, real3 dpdy) {
    real3 n = cross(dpdx, dpdy);
    g->filtered = n.x * n.x + n.y * n.y + n.z * n.z >= 1e-6;
    n = gabor_unit(n);
    real3 t = gabor_unit(fabs(n.x) < 0.9 ? (real3)(0, n.z, -n.y) : (real3)(-n.z, 0, n.x));
    real3 b = cross(n, t);
    real m00 = dpdx.x * t.x + dpdy.x * t.y, m01 = dpdx.x * b.x + dpdy.x * b.y;
    real m10 = dpdx.y * t.x + dpdy.y * t.y, m11 = dpdx.y * b.x + dpdy.y * b.y;
    Gabor22 footprint = {0.25 * (m00 * m00 + m10 * m10), 0.25 * (m00 * m01 + m10 * m11), 0.25 * (m01 * m01 + m11 * m11)};
    real det = gabor_det(footprint);
    g->filtered = g->filtered && det >= 1e-18;
    if (!g->filtered) return;
    g->n = n;
    g->t = t;
    g->b = b;
    real a2 = g->a * g->a;
    const real four_pi2 = 4 * PI * PI;
    Gabor22 spread = gabor_inverse(footprint);
    spread.xx = spread.xx / four_pi2 + a2 / (2 * PI);
    spread.xy = spread.xy / four_pi2;
    spread.yy = spread.yy / four_pi2 + a2 / (2 * PI);
    g->weight = 1 / (four_pi2 * sqrt(det) * sqrt(gabor_det(spread)));
    g->spread = gabor_inverse(spread);
    Gabor22 turn = {four_pi2 * footprint.xx + 2 * PI / a2, four_pi2 * footprint.xy, four_pi2 * footprint.yy + 2 * PI / a2};
    turn = gabor_inverse(turn);
    g->filtered_a = sqrt(2 * PI * sqrt(gabor_det(turn)));
    g->turn.xx = turn.xx * (2 * PI / a2);
    g->turn.xy = turn.xy * (2 * PI / a2);
    g->turn.yy = turn.yy * (2 * PI / a2);
}

static inline Gabor gabor_setup(real3 dpdx, real3 dpdy, int anisotropic, real3 direction, real bandwidth,
                                real impulses, int do_filter) {
    Gabor g;
    g.anisotropic = anisotropic;
    g.direction = direction;
    g.periodic = 0;
    g.period = (real3)(1, 1, 1);
    // The reference computes this in f64 and rounds at the end; an ulp less, and points at the edge of a kernel lose or gain it.
    const real octaves = m_exp2(clamp(bandwidth, (real)0.01, (real)100));
    const real below = octaves - 1, above = octaves + 1, ratio = below / above, lost = fma(-ratio, above, below) / above;
    g.a = GABOR_FREQUENCY * fma(ratio, GABOR_WIDTH, lost * GABOR_WIDTH);
    g.radius = sqrt((real)(GABOR_CUT / PI)) / g.a;
    const real many = clamp(impulses, (real)1, (real)32), density = many / (real)GABOR_SPHERE;
    // Rounded as in the reference: whether a cell has one kernel more is a matter of the last digit.
    const float radius = (float)g.radius, cube = radius * radius * radius;
    g.mean = (float)many / ((float)GABOR_SPHERE * cube) * cube;
    // One over the square root of the density, and of 9 times the variance; half of that fits into [-1, 1].
    real r3 = g.radius * g.radius * g.radius, a3 = g.a * g.a * g.a;
    g.amplitude = sqrt(r3 / density) * sqrt(a3 * 5.65685424949238019521) * (1 / 6.0);
    g.filtered = 0;
    g.n = g.t = g.b = (real3)(0, 0, 0);
    g.weight = 1;
    g.spread.xx = g.spread.xy = g.spread.yy = 0;
    g.turn = g.spread;
    g.filtered_a = g.a;
    if (do_filter) gabor_filter(&g, dpdx, dpdy);
    return g;
}

// The frequency of the next kernel.
static inline real3 gabor_frequency(const Gabor *g, GaborRandom *random) {
    if (g->anisotropic == 1) return g->direction;
    real s, c;
    m_sincos((real)(2 * PI) * gabor_random(random), &s, &c);
    if (g->anisotropic != 0) {
        real3 d = g->direction;
        return sqrt(d.x * d.x + d.y * d.y + d.z * d.z) * (real3)(c, s, 0);
    }
    real z = gabor_random(random);
    z = z - (1 - z);
    real r = sqrt(fmax(1 - z * z, (real)0));
    return gabor_unit((real3)(c * r, s * r, z));
}

// Adds to a sum, and to its derivatives, a wave under a Gaussian: weight exp(-pi a^2 x.x) cos(phase), d the derivative of
// the logarithm of weight and Gaussian, dphase that of the phase.
static inline real gabor_wave(real weight, real exponent, real phase, real3 d, real3 dphase, real3 *gradient) {
    real s, c;
    m_sincos(phase, &s, &c);
    real e = weight * m_exp(exponent);
    *gradient = e * (c * d - s * dphase);
    return e * c;
}

// The kernel around the origin at x (eq. 1).
static inline real gabor_kernel(const Gabor *g, real3 omega, real phi, real3 x, real3 *gradient) {
    real k = -PI * (g->a * g->a);
    real phase = 2 * PI * (omega.x * x.x + omega.y * x.y + omega.z * x.z) + phi;
    return gabor_wave(1, k * (x.x * x.x + x.y * x.y + x.z * x.z), phase, 2 * k * x, 2 * PI * omega, gradient);
}

// The same after slicing by the tangent plane (eq. 6) and filtering (eq. 10).
static inline real gabor_kernel_filtered(const Gabor *g, real3 omega, real phi, real3 x, real3 *gradient) {
    real2 plane = (real2)(dot(omega, g->t), dot(omega, g->b));
    real across = dot(omega, g->n);
    real depth = dot(g->n, x); // the slice lies at -depth
    real2 at = (real2)(dot(x, g->t), dot(x, g->b));
    real2 f = gabor_mul(g->turn, plane);
    real k = -PI * (g->a * g->a), kf = -PI * (g->filtered_a * g->filtered_a);
    real weight = g->weight * m_exp(-0.5 * dot(gabor_mul(g->spread, plane), plane));
    real phase = 2 * PI * dot(f, at) + (phi + 2 * PI * depth * across);
    real3 d = 2 * k * depth * g->n + 2 * kf * (at.x * g->t + at.y * g->b);
    real3 dphase = 2 * PI * (f.x * g->t + f.y * g->b + across * g->n);
    return gabor_wave(weight, k * depth * depth + kf * dot(at, at), phase, d, dphase, gradient);
}

// The kernels of one cell, x from the cell's corner in cells.
static inline real gabor_cell(const Gabor *g, real3 corner, real3 x, uint seed, real3 *gradient) {
    real3 c = corner;
    if (g->periodic)
        c = (real3)(gabor_wrap(c.x, g->period.x), gabor_wrap(c.y, g->period.y), gabor_wrap(c.z, g->period.z));
    GaborRandom random = gabor_seed((uint)(int)c.x, (uint)(int)c.y, (uint)(int)c.z, seed);
    // Poisson's distribution: uniform factors until their product falls below exp(-mean). At most 64, against NaN.
    int count = 0;
    float limit = exp(-g->mean), product = gabor_random(&random);
    while (product > limit && count < 64) {
        ++count;
        product *= gabor_random(&random);
    }
    real sum = 0;
    for (int i = 0; i < count; ++i) {
        real z = gabor_random(&random), y = gabor_random(&random);
        real3 at = g->radius * (x - (real3)((real)gabor_random(&random), y, z));
        real3 omega = gabor_frequency(g, &random);
        real phi = (real)(2 * PI) * gabor_random(&random);
        if (at.x * at.x + at.y * at.y + at.z * at.z < g->radius * g->radius) {
            real3 slope = (real3)(0, 0, 0);
            real value = g->filtered ? gabor_kernel_filtered(g, omega, phi, at, &slope) : 0;
            // Numbers that got out of hand: the kernel as it is.
            if (!g->filtered || !isfinite(value)) value = gabor_kernel(g, omega, phi, at, &slope);
            sum += value;
            *gradient += slope;
        }
    }
    return sum;
}

// The kernels of the cells around p. Those of cells that are all more than a radius away would be skipped one by one.
static inline real gabor_sum(const Gabor *g, real3 p, uint seed, real3 *gradient) {
    real3 x = p * (1 / g->radius);
    real3 cell = floor(x);
    x -= cell;
    real sum = 0;
    *gradient = (real3)(0, 0, 0);
    for (int k = 0; k < 27; ++k) {
        real3 step = (real3)((real)(k % 3 - 1), (real)(k / 3 % 3 - 1), (real)(k / 9 - 1));
        real3 offset = x - step;
        real3 away = fmax(fmax(-offset, offset - 1), (real3)(0, 0, 0));
        if (!(away.x * away.x + away.y * away.y + away.z * away.z > 1.0001))
            sum += gabor_cell(g, cell + step, offset, seed, gradient);
    }
    *gradient *= g->amplitude;
    return sum * g->amplitude;
}

static inline real3 gabor_sum_3(const Gabor *g, real3 p, real3 *gx, real3 *gy, real3 *gz) {
    real3 d0, d1, d2;
    real3 r = (real3)(gabor_sum(g, p, 0u, &d0), gabor_sum(g, p, 1u, &d1), gabor_sum(g, p, 2u, &d2));
    *gx = (real3)(d0.x, d1.x, d2.x);
    *gy = (real3)(d0.y, d1.y, d2.y);
    *gz = (real3)(d0.z, d1.z, d2.z);
    return r;
}

static inline Gabor gabor_setup_periodic(real3 dpdx, real3 dpdy, real3 period, int anisotropic, real3 direction,
                                         real bandwidth, real impulses, int do_filter) {
    Gabor g = gabor_setup(dpdx, dpdy, anisotropic, direction, bandwidth, impulses, do_filter);
    g.periodic = 1;
    g.period = period;
    return g;
}

// osl_noise_gabor_R_vvvivffi and osl_pnoise_gabor_R_vvvvivffi, and both with `_d`.
#define GABOR_FORMS(NAME, ARGS, PARAMS, SETUP)                                                                         \
    static inline real osl_##NAME##_gabor_f_##ARGS##_d(PARAMS, real *dx, real *dy, real *dz) {                         \
        real3 d;                                                                                                       \
        Gabor g = SETUP;                                                                                               \
        real r = gabor_sum(&g, p, 0u, &d);                                                                             \
        *dx = d.x;                                                                                                     \
        *dy = d.y;                                                                                                     \
        *dz = d.z;                                                                                                     \
        return r;                                                                                                      \
    }                                                                                                                  \
    static inline real osl_##NAME##_gabor_f_##ARGS(PARAMS) {                                                           \
        real3 d;                                                                                                       \
        Gabor g = SETUP;                                                                                               \
        return gabor_sum(&g, p, 0u, &d);                                                                               \
    }                                                                                                                  \
    static inline real3 osl_##NAME##_gabor_v_##ARGS##_d(PARAMS, real3 *dx, real3 *dy, real3 *dz) {                     \
        Gabor g = SETUP;                                                                                               \
        return gabor_sum_3(&g, p, dx, dy, dz);                                                                         \
    }                                                                                                                  \
    static inline real3 osl_##NAME##_gabor_v_##ARGS(PARAMS) {                                                          \
        real3 dx, dy, dz;                                                                                              \
        Gabor g = SETUP;                                                                                               \
        return gabor_sum_3(&g, p, &dx, &dy, &dz);                                                                      \
    }

#define GABOR_PARAMS real3 p, real3 dpdx, real3 dpdy, int anisotropic, real3 direction, real bandwidth, real impulses, \
                     int do_filter
#define GABOR_PERIODIC_PARAMS real3 p, real3 dpdx, real3 dpdy, real3 period, int anisotropic, real3 direction,         \
                              real bandwidth, real impulses, int do_filter

GABOR_FORMS(noise, vvvivffi, GABOR_PARAMS,
            gabor_setup(dpdx, dpdy, anisotropic, direction, bandwidth, impulses, do_filter))
GABOR_FORMS(pnoise, vvvvivffi, GABOR_PERIODIC_PARAMS,
            gabor_setup_periodic(dpdx, dpdy, period, anisotropic, direction, bandwidth, impulses, do_filter))

#endif
