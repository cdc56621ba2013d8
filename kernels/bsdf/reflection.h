// reflection(N), reflection(N, eta): the mirror. Weight 1, or with eta > 0 the dielectric's reflectance.
// eta is the index below the surface over the one above, as the shader gives it.
#ifndef OSLCL_BSDF_REFLECTION_H
#define OSLCL_BSDF_REFLECTION_H

#include "bsdf/albedo.h"
#include "bsdf/fresnel.h"
#include "bsdf/sampling.h"
#include "lobe.h"

static inline Lobe closure_reflection_vf(real3 N, real eta)
{
    Lobe l = {0};
    l.type = LOBE_REFLECTION;
    l.flags = LOBE_REFLECTS;
    l.N = safe_normalize(N);
    l.eta = eta;
    return l;
}

static inline Lobe closure_reflection_v(real3 N) { return closure_reflection_vf(N, 0); }

static inline real reflection_albedo(const Lobe *l, real3 wo)
{
    real co = dot(l->N, wo);
    return co > 0 ? fresnel_dielectric(co, l->eta) : 0;
}

static inline int reflection_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    real F = reflection_albedo(l, wo);
    if (!(F > 0)) return 0;
    *wi = reflect_direction(wo, l->N);
    *value = (real3)(F);
    *pdf = 0;
    return SAMPLE_REFLECT | SAMPLE_DELTA;
}

ALBEDO_IS_EXACT(reflection)

#endif
