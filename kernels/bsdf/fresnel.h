// Fresnel reflectance of unpolarised light, and the refracted direction.
// In: cosines in [0,1], relative indices below/above the surface. Out: reflectance in [0,1], never NaN.
#ifndef OSLCL_BSDF_FRESNEL_H
#define OSLCL_BSDF_FRESNEL_H

#include "bsdf/numeric.h"

// Dielectric; c = cosine on the side of wo. eta <= 0 means "no Fresnel": reflectance 1, as OSL's testrender takes it.
// Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007, eq. 22, rearranged: g - c and
// c(g - c) + 1 cancel at eta near 1 and at grazing incidence, (eta^2 - 1)/(g + c) and cg + sin^2 do not.
static inline real fresnel_dielectric(real c, real eta)
{
    if (!(eta > 0)) return 1;
    c = clamp(c, (real)0, (real)1);
    real e = (eta - 1) * (eta + 1);
    real g2 = e + c * c;
    if (!(g2 > 0)) return e < 0 ? 1 : 0; // total reflection; eta = 1 at c = 0 has no surface
    real g = sqrt(g2);
    real s2 = (1 - c) * (1 + c);
    real a = e / sqr(g + c);
    real b = (c * g - s2) / (c * g + s2);
    return fmin((real)0.5 * a * a * (1 + b * b), (real)1);
}

// Conductor with index n and extinction k per channel, relative to the medium above; c = cosine.
// Born and Wolf, "Principles of Optics", ch. 14.2: n cos of the refracted ray is the complex number a + ib with
// a^2 - b^2 = n^2 - k^2 - sin^2 and ab = nk. The larger of a and b by the root, the other by the product: no cancellation.
static inline real3 fresnel_conductor(real c, real3 n, real3 k)
{
    c = clamp(c, (real)0, (real)1);
    real s2 = (1 - c) * (1 + c);
    // Beyond 1e6 reflectance is 1 in all digits; the squares of squares have to stay in the range of f32.
    n = fmin(fabs(n), (real3)(1e6));
    k = fmin(fabs(k), (real3)(1e6));
    real3 t = (n - k) * (n + k) - s2;
    real3 nk = n * k;
    real3 m = sqrt(t * t + 4 * nk * nk);
    real3 big = sqrt((real)0.5 * (m + fabs(t)));
    real3 small = nk / fmax(big, (real3)(1e-18));
    real3 a = fmax(t, (real3)(0)) > (real3)(0) ? big : small;
    real3 b = fmax(t, (real3)(0)) > (real3)(0) ? small : big;
    const real3 tiny = (real3)(1e-30);
    real3 b2 = b * b;
    real3 rs = ((a - c) * (a - c) + b2) / fmax((a + c) * (a + c) + b2, tiny);
    real3 ac = a * c;
    real3 b2c2 = b2 * c * c;
    real3 rp = rs * ((ac - s2) * (ac - s2) + b2c2) / fmax((ac + s2) * (ac + s2) + b2c2, tiny);
    return fmin((real)0.5 * (rs + rp), (real3)(1));
}

// The direction into which wo is bent at a surface with unit normal m and cosine c = dot(wo, m) >= 0.
// Returns the cosine below, or 0 at total reflection. By the tangential part, which keeps its digits when eta is far from 1.
// Its length gives the cosine, but at grazing incidence with eta near 1, where 1 - sin^2 / eta^2 cancels and
// (eta^2 - 1 + c^2) / eta^2 does not; that one in turn loses the rounding of c, by 1 / eta^2, when eta is small.
static inline real refract_direction(real3 wo, real3 m, real c, real eta, real3 *wi)
{
    const real3 tangential = (wo - m * c) / eta;
    const real cos2 = c > (real)0.5 ? 1 - dot(tangential, tangential)
                                    : ((eta - 1) / eta) * ((eta + 1) / eta) + sqr(c / eta);
    if (!(cos2 > 0)) return 0;
    const real cos_t = sqrt(cos2);
    *wi = normalize(-tangential - m * cos_t);
    return cos_t;
}

static inline real3 reflect_direction(real3 wo, real3 m) { return m * (2 * dot(wo, m)) - wo; }

#endif
