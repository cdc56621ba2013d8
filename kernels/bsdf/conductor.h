// conductor_bsdf(N, T, ax, ay, ior, extinction, distribution): a rough metal with a complex index per channel, relative
// to the medium above, with or without a thin film (thin_film.h). Roughness below ALPHA_MIN is the smooth mirror.
#ifndef OSLCL_BSDF_CONDUCTOR_H
#define OSLCL_BSDF_CONDUCTOR_H

#include "bsdf/albedo.h"
#include "bsdf/distribution.h"
#include "bsdf/fresnel.h"
#include "bsdf/thin_film.h"

static inline Lobe closure_conductor_bsdf_vvffvvs(real3 N, real3 T, real ax, real ay, real3 ior, real3 extinction,
                                                  int dist)
{
    Lobe l = {0};
    l.type = LOBE_CONDUCTOR;
    l.flags = distribution_flag(dist) | LOBE_REFLECTS;
    l.N = safe_normalize(N);
    l.T = T;
    set_roughness(&l, ax, ay);
    l.c0 = ior;
    l.c1 = extinction;
    return l;
}

static inline real3 conductor_fresnel(const Lobe *l, real c)
{
#ifdef HAS_LOBE_THIN_FILM
    if (l->film > 0) return film_reflectance(c, l->film, l->film_ior, l->c0, l->c1);
#endif
    return fresnel_conductor(c, l->c0, l->c1);
}

static inline real conductor_albedo(const Lobe *l, real3 wo)
{
    real co = dot(l->N, wo);
    if (!(co > 0)) return 0;
    real albedo = max_component(conductor_fresnel(l, co));
    return l->ax > 0 ? fmax(albedo, (real)0.02) : albedo;
}

static inline real3 conductor_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)
{
    *pdf = 0;
    if (l->ax <= 0) return (real3)(0);
    Frame frame = lobe_frame(l);
    wo = to_local(&frame, wo);
    wi = to_local(&frame, wi);
    real3 m;
    real f = ndf_reflect(l, wo, wi, &m, pdf);
    if (!(*pdf > 0)) return (real3)(0);
    return conductor_fresnel(l, dot(wo, m)) * f;
}

static inline int conductor_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    int rough = l->ax > 0;
    Frame frame = lobe_frame(l);
    wo = to_local(&frame, wo);
    *pdf = 0;
    if (!(wo.z > 0)) return 0;
    real3 m = rough ? ndf_sample(l, wo, u.x, u.y) : (real3)(0, 0, 1);
    real c = dot(wo, m);
    real3 local_wi = m * (2 * c) - wo;
    if (!(c > 0 && local_wi.z > 0)) return 0;
    *wi = to_world(&frame, local_wi);
    *value = conductor_fresnel(l, c);
    if (!rough) return SAMPLE_REFLECT | SAMPLE_DELTA;
    *pdf = ndf_D(l, m) / (4 * ndf_projected(l, wo));
    if (!is_finite_positive(*pdf)) return 0;
    *value *= local_wi.z / ndf_projected(l, local_wi);
    return SAMPLE_REFLECT | SAMPLE_GLOSSY;
}

ALBEDO_BY_SAMPLING(conductor)

#endif
