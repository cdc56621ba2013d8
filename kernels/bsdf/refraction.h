// refraction(N, eta): the bent ray of a smooth dielectric, weight 1 - F; black at total reflection and for eta <= 0.
// eta is the index below the surface over the one above: a shader writes backfacing() ? 1/ior : ior.
//
// Radiance that enters a medium of index n grows by n^2 (Veach 1997, sec. 5.2). A path of a closed object that starts and
// ends outside enters as often as it leaves, so the factors cancel, and they are left out here: then a weight is never
// above 1, and Russian roulette isn't led astray. A camera or a light inside a medium would see the difference.
#ifndef OSLCL_BSDF_REFRACTION_H
#define OSLCL_BSDF_REFRACTION_H

#include "bsdf/albedo.h"
#include "bsdf/fresnel.h"
#include "bsdf/sampling.h"
#include "lobe.h"

static inline Lobe closure_refraction_vf(real3 N, real eta)
{
    Lobe l = {0};
    l.type = LOBE_REFRACTION;
    l.flags = LOBE_TRANSMITS;
    l.N = safe_normalize(N);
    l.eta = eta;
    return l;
}

static inline real refraction_albedo(const Lobe *l, real3 wo)
{
    real co = dot(l->N, wo);
    return co > 0 ? 1 - fresnel_dielectric(co, l->eta) : 0;
}

static inline int refraction_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    real T = refraction_albedo(l, wo);
    if (!(T > 0)) return 0;
    if (!(refract_direction(wo, l->N, dot(l->N, wo), l->eta, wi) > 0)) return 0;
    *value = (real3)(T);
    *pdf = 0;
    return SAMPLE_TRANSMIT | SAMPLE_DELTA;
}

ALBEDO_IS_EXACT(refraction)

#endif
