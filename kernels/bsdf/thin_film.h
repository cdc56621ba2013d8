// Reflectance of a thin film on a dielectric or a metal: interference colours.
// Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence", 2017: Airy's sum over
// the bounces inside the film (eq. 3), integrated over the observer's sensitivities by Gaussians (eq. 10 and the supplement's
// fit), the direct term and two more orders per polarisation. Out: reflectance per channel in [0,1].
// The film lies on the side above the surface, in vacuum. Thickness in nanometres.
#ifndef OSLCL_BSDF_THIN_FILM_H
#define OSLCL_BSDF_THIN_FILM_H

#include "bsdf/fresnel.h"
#include "lobe.h"

#ifdef HAS_LOBE_THIN_FILM

static inline Lobe lobe_film(Lobe l, real thickness, real ior)
{
    l.film = thickness > 0 ? fmin(thickness, (real)1e5) : 0;
    l.film_ior = clamp(ior, (real)1, (real)100);
    return l;
}

// The observer's XYZ sensitivities in the frequency domain: heights times sqrt(2 pi variance), relative to the integral;
// positions and variances in micrometres. x has a second hump.
#define FILM_HEIGHTS (real3)(0.84659000, 1.00022188, 1.00112249)
#define FILM_POSITIONS (real3)(1.6810, 1.7953, 2.2084)
#define FILM_VARIANCES (real3)(0.0043278, 0.0093046, 0.0066121)
#define FILM_HUMP_HEIGHT (real)0.15386831
#define FILM_HUMP_POSITION (real)2.2399
#define FILM_HUMP_VARIANCE (real)0.0045282

// From a path difference in nm to 1/micrometres.
static inline real film_frequency(real opd) { return (real)(2e-3 * PI) * opd; }
static inline real3 film_cosines(real3 x) { return (real3)(m_cos(x.x), m_cos(x.y), m_cos(x.z)); }
static inline real3 film_decays(real frequency)
{
    const real3 x = FILM_VARIANCES * -(frequency * frequency);
    return (real3)(m_exp(x.x), m_exp(x.y), m_exp(x.z));
}
static inline real film_hump_decay(real frequency) { return m_exp(-FILM_HUMP_VARIANCE * (frequency * frequency)); }

// The XYZ response to a path difference (nm) and a phase per channel.
static inline real3 film_sensitivity(real opd, real3 shift)
{
    const real frequency = film_frequency(opd);
    real3 xyz = FILM_HEIGHTS * film_cosines(FILM_POSITIONS * frequency + shift) * film_decays(frequency);
    xyz.x += FILM_HUMP_HEIGHT * m_cos(FILM_HUMP_POSITION * frequency + shift.x) * film_hump_decay(frequency);
    return xyz;
}

// Amplitude reflection r = x + iy of a surface with complex index (n, k) seen from index 1 at cosine c, both polarisations.
// Born and Wolf, "Principles of Optics", ch. 14.2; a and b as in fresnel_conductor.
static inline void film_base(real c, real n, real k, real *Rs, real *Rp, real *phase_s, real *phase_p)
{
    real s2 = (1 - c) * (1 + c);
    real t = (n - k) * (n + k) - s2;
    real m = sqrt(t * t + 4 * n * n * k * k);
    real a = sqrt(fmax((real)0.5 * (m + t), (real)0));
    real b = sqrt(fmax((real)0.5 * (m - t), (real)0));
    // s: (c - a - ib) / (c + a + ib)
    real d = fmax(sqr(c + a) + b * b, (real)1e-20);
    real x = (c * c - a * a - b * b) / d, y = -2 * c * b / d;
    *Rs = fmin(x * x + y * y, (real)1);
    *phase_s = m_atan2(y, x);
    // p: (e c - q) / (e c + q), with e = (n + ik)^2 and q = a + ib
    real ex = (n - k) * (n + k) * c, ey = 2 * n * k * c;
    real ux = ex - a, uy = ey - b, vx = ex + a, vy = ey + b;
    d = fmax(vx * vx + vy * vy, (real)1e-20);
    x = (ux * vx + uy * vy) / d;
    y = (uy * vx - ux * vy) / d;
    *Rp = fmin(x * x + y * y, (real)1);
    *phase_p = m_atan2(y, x);
}

// Sum of the orders for one polarisation. R12, phase21: the film's upper surface; R23, phase23: its base.
static inline real3 film_orders(real R12, real phase21, real3 R23, real3 phase23, real opd)
{
    real T = 1 - R12;
    real3 r123 = sqrt(R12 * R23);
    real3 Rs = T * T * R23 / fmax((real)1 - R12 * R23, (real3)(1e-6));
    real3 sum = R12 + Rs;
    real3 C = Rs - T;
    for (int m = 1; m <= 2; m++) {
        C *= r123;
        sum += C * 2 * film_sensitivity(m * opd, (phase23 + phase21) * (real)m);
    }
    return sum;
}

// film_orders of both polarisations over a base that absorbs nothing and does not reflect totally: every phase is 0 or pi, so
// that they share the sensitivities, and the second order's follow from the first's. A fifth of the time.
// r12s, r12p: amplitudes of the film's upper surface; ct: cosine inside the film; n2: square of the base's index over the
// film's; a: that index times the cosine in the base.
static inline real3 film_orders_real(real r12s, real r12p, real ct, real3 a, real3 n2, real opd)
{
    const real frequency = film_frequency(opd);
    const real3 cosines = film_cosines(FILM_POSITIONS * frequency), decays = film_decays(frequency);
    const real hump_cosine = m_cos(FILM_HUMP_POSITION * frequency), hump_decay = film_hump_decay(frequency);
    // cos 2x = 2 cos^2 x - 1, and twice the path makes the exponent four times as large.
    const real3 decays2 = decays * decays;
    real3 first = FILM_HEIGHTS * cosines * decays;
    real3 second = FILM_HEIGHTS * (2 * cosines * cosines - 1) * (decays2 * decays2);
    first.x += FILM_HUMP_HEIGHT * hump_cosine * hump_decay;
    second.x += FILM_HUMP_HEIGHT * (2 * hump_cosine * hump_cosine - 1) * sqr(sqr(hump_decay));
    real3 sum = (real3)(0);
    for (int parallel = 0; parallel < 2; parallel++) {
        const real r12 = parallel ? r12p : r12s;
        const real3 r23 = parallel ? (n2 * ct - a) / (n2 * ct + a) : (ct - a) / (ct + a);
        const real R12 = r12 * r12, T = 1 - R12;
        const real3 R23 = r23 * r23;
        const real3 Rs = T * T * R23 / fmax((real)1 - R12 * R23, (real3)(1e-6));
        // From inside the film its upper surface reflects with the opposite sign.
        const real3 r123 = -r12 * r23;
        sum += R12 + Rs + (Rs - T) * 2 * r123 * (first + r123 * second);
    }
    return sum;
}

// In: cosine above, film, complex index of the base relative to vacuum.
static inline real3 film_reflectance(real c, real thickness, real film_ior, real3 n, real3 k)
{
    c = clamp(c, (real)1e-4, (real)1);
    n = clamp(n, (real3)(1e-3), (real3)(1e3));
    k = clamp(k, (real3)(0), (real3)(1e3));
    const real ct = sqrt(fmax(1 - (1 - c) * (1 + c) / sqr(film_ior), (real)0));
    // The upper surface is a dielectric: real amplitudes, whose sign from inside is the opposite.
    const real s = (c - film_ior * ct) / (c + film_ior * ct);
    const real p = (film_ior * c - ct) / (film_ior * c + ct);
    const real opd = 2 * film_ior * ct * thickness;
    const real3 below = n / film_ior, below2 = below * below;
    const real3 transmitted = below2 - (1 - ct) * (1 + ct);
    real3 xyz;
    if (max_component(k) == 0 && fmin(fmin(transmitted.x, transmitted.y), transmitted.z) > 0) {
        xyz = film_orders_real(s, p, ct, sqrt(transmitted), below2, opd);
    } else {
        const real3 extinction = k / film_ior;
        real x[12];
        film_base(ct, below.x, extinction.x, x + 8, x + 9, x + 10, x + 11);
        film_base(ct, below.y, extinction.y, x, x + 1, x + 2, x + 3);
        film_base(ct, below.z, extinction.z, x + 4, x + 5, x + 6, x + 7);
        const real3 Rs = (real3)(x[8], x[0], x[4]);
        const real3 Rp = (real3)(x[9], x[1], x[5]);
        const real3 phase_s = (real3)(x[10], x[2], x[6]);
        const real3 phase_p = (real3)(x[11], x[3], x[7]);
        xyz = film_orders(s * s, s > 0 ? (real)PI : (real)0, Rs, phase_s, opd) +
              film_orders(p * p, p > 0 ? (real)PI : (real)0, Rp, phase_p, opd);
    }
    xyz *= (real)0.5;
    // CIE 1931 RGB of the same authors: white of equal energy.
    real3 rgb = (real3)(dot(xyz, (real3)(2.3706743, -0.9000405, -0.4706338)),
                        dot(xyz, (real3)(-0.5138850, 1.4253036, 0.0885814)),
                        dot(xyz, (real3)(0.0052982, -0.0146949, 1.0093968)));
    return clamp(rgb, (real3)(0), (real3)(1));
}

#elif defined(WITHOUT_LOBE_THIN_FILM)

// The scene is rendered without the films that a shader has.
static inline Lobe lobe_film(Lobe l, real thickness, real ior) { return l; }

#endif
#endif
