// generalized_schlick_bsdf(N, U, reflection_tint, transmission_tint, roughness_x, roughness_y, f0, f90, exponent, distribution,
// "thinfilm_thickness", float, "thinfilm_ior", float): microfacets whose reflectance is f0 + (f90 - f0)(1 - cos)^exponent.
// Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994, eq. 15, with colours and exponent free as in the
// MaterialX specification. What is transmitted is bent by the index whose reflectance is the mean of f0. From inside the cosine is
// that of the refracted ray, and beyond the critical angle all is reflected.
// Under a film the surface is the dielectric that reflects f0: f90 and the exponent don't count then.
#ifndef OSLCL_BSDF_GENERALIZED_SCHLICK_H
#define OSLCL_BSDF_GENERALIZED_SCHLICK_H

#include "bsdf/dielectric.h"

static inline Lobe closure_generalized_schlick_bsdf_vvvvffvvfs(int backfacing, real3 N, real3 T, real3 reflection,
                                                               real3 transmission, real ax, real ay, real3 f0, real3 f90,
                                                               real exponent, int dist)
{
    f0 = clamp(f0, (real3)(0), (real3)(1));
    f90 = clamp(f90, (real3)(0), (real3)(1));
    real root = sqrt(fmin((f0.x + f0.y + f0.z) * (real)(1.0 / 3), (real)0.99));
    Lobe l = facets_lobe(LOBE_GENERALIZED_SCHLICK, backfacing, N, T, reflection, transmission, ax, ay,
                         (1 + root) / (1 - root), dist);
    l.c2 = f0;
    l.c3 = f90;
    l.exponent = clamp(exponent, (real)0, (real)1e3);
    return l;
}

static inline real3 generalized_schlick_fresnel(const Lobe *l, real c)
{
#ifdef HAS_LOBE_THIN_FILM
    if (l->film > 0) {
        real3 root = sqrt(fmin(l->c2, (real3)(0.99)));
        return facets_film(l, c, (1 + root) / (1 - root));
    }
#endif
    c = clamp(c, (real)0, (real)1);
    if (l->flags & LOBE_BACK) {
        real s2 = (1 - c) * (1 + c) / sqr(l->eta);
        if (!(s2 < 1)) return (real3)(1);
        c = sqrt(1 - s2);
    }
    return l->c2 + (l->c3 - l->c2) * pow_one_minus(c, l->exponent);
}

FACETS(generalized_schlick)

#endif
