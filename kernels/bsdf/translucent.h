// translucent(N): Lambert's law on the other side, f = 1/pi for directions below the surface.
// translucent_bsdf(N, albedo) is the same; its albedo is a factor of the weight (ClosureRow::tint).
#ifndef OSLCL_BSDF_TRANSLUCENT_H
#define OSLCL_BSDF_TRANSLUCENT_H

#include "bsdf/albedo.h"
#include "bsdf/frame.h"
#include "bsdf/sampling.h"
#include "lobe.h"

static inline Lobe closure_translucent_v(real3 N)
{
    Lobe l = {0};
    l.type = LOBE_TRANSLUCENT;
    l.flags = LOBE_TRANSMITS;
    l.N = safe_normalize(N);
    return l;
}

static inline Lobe closure_translucent_bsdf_v(real3 N) { return closure_translucent_v(N); }

static inline real translucent_albedo(const Lobe *l, real3 wo) { return dot(l->N, wo) > 0 ? 1 : 0; }

static inline real3 translucent_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)
{
    real ci = -dot(l->N, wi);
    *pdf = dot(l->N, wo) > 0 && ci > 0 ? ci * (real)INV_PI : 0;
    return (real3)(*pdf);
}

static inline int translucent_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    if (!(dot(l->N, wo) > 0)) return 0;
    Frame frame = frame_from_normal(l->N);
    real3 local_wi = sample_cosine(u.x, u.y);
    if (!(local_wi.z > 0)) return 0;
    *wi = -to_world(&frame, local_wi);
    *value = (real3)(1);
    *pdf = local_wi.z * (real)INV_PI;
    return SAMPLE_TRANSMIT | SAMPLE_DIFFUSE;
}

ALBEDO_IS_EXACT(translucent)

#endif
