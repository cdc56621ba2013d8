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

// The XYZ response to a path difference (nm) and a phase per channel.
static inline real3 film_sensitivity(real opd, real3 shift)
{
    const real phase = (real)(2e-3 * PI) * opd; // 1/micrometres
    const real p2 = phase * phase;
    // Heights times sqrt(2 pi variance), relative to the integral; positions and variances in micrometres.
    const real3 pos = (real3)(1.6810, 1.7953, 2.2084);
    const real3 var = (real3)(0.0043278, 0.0093046, 0.0066121);
    const real3 val = (real3)(0.84659000, 1.00022188, 1.00112249);
    real3 angle = pos * phase + shift;
    real3 xyz = val * (real3)(m_cos(angle.x), m_cos(angle.y), m_cos(angle.z)) *
                (real3)(m_exp(-var.x * p2), m_exp(-var.y * p2), m_exp(-var.z * p2));
    // The second hump of x.
    xyz.x += (real)0.15386831 * m_cos((real)2.2399 * phase + shift.x) * m_exp((real)-0.0045282 * p2);
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

// In: cosine above, film, complex index of the base relative to vacuum.
static inline real3 film_reflectance(real c, real thickness, real film_ior, real3 n, real3 k)
{
    c = clamp(c, (real)1e-4, (real)1);
    n = clamp(n, (real3)(1e-3), (real3)(1e3));
    k = clamp(k, (real3)(0), (real3)(1e3));
    const real ct = sqrt(fmax(1 - (1 - c) * (1 + c) / sqr(film_ior), (real)0));
    // The upper surface is a dielectric: real amplitudes, whose sign from inside is the opposite.
    real s = (c - film_ior * ct) / (c + film_ior * ct);
    real p = (film_ior * c - ct) / (film_ior * c + ct);
    real x[12];
    film_base(ct, n.x / film_ior, k.x / film_ior, x + 8, x + 9, x + 10, x + 11);
    film_base(ct, n.y / film_ior, k.y / film_ior, x, x + 1, x + 2, x + 3);
    film_base(ct, n.z / film_ior, k.z / film_ior, x + 4, x + 5, x + 6, x + 7);
    const real3 Rs = (real3)(x[8], x[0], x[4]);
    const real3 Rp = (real3)(x[9], x[1], x[5]);
    const real3 phase_s = (real3)(x[10], x[2], x[6]);
    const real3 phase_p = (real3)(x[11], x[3], x[7]);
    real opd = 2 * film_ior * ct * thickness;
    real3 xyz = film_orders(s * s, s > 0 ? (real)PI : (real)0, Rs, phase_s, opd) +
                film_orders(p * p, p > 0 ? (real)PI : (real)0, Rp, phase_p, opd);
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
