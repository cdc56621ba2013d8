// Reflection and refraction by microfacets whose reflectance has a colour, and tints: what dielectric_bsdf and
// generalized_schlick_bsdf share. Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007.
// In: a Lobe with ax, ay, eta (below over above), c0 and c1 (tints of reflection and transmission), and a function
// NAME_fresnel(l, c): reflectance per channel of a facet at cosine c. Out, by FACETS(NAME): NAME_eval, NAME_sample, NAME_albedo,
// NAME_albedo3. Light that hits a second facet is lost (docs/adr/0017); radiance is not scaled by eta^2, see refraction.h.
#ifndef OSLCL_BSDF_FACETS_H
#define OSLCL_BSDF_FACETS_H

#include "bsdf/albedo.h"
#include "bsdf/distribution.h"
#include "bsdf/fresnel.h"

// The constructor's common part. ior is that of the inside over the outside; from inside it turns round.
static inline Lobe facets_lobe(int type, int backfacing, real3 N, real3 T, real3 reflection, real3 transmission, real ax,
                               real ay, real ior, int dist)
{
    Lobe l = {0};
    l.type = type;
    reflection = clamp(reflection, (real3)(0), (real3)(1e6));
    transmission = clamp(transmission, (real3)(0), (real3)(1e6));
    ior = clamp(ior, (real)1e-3, (real)1e3);
    l.flags = distribution_flag(dist) | (max_component(reflection) > 0 ? LOBE_REFLECTS : 0) |
              (max_component(transmission) > 0 ? LOBE_TRANSMITS : 0) | (backfacing ? LOBE_BACK : 0);
    l.N = safe_normalize(N);
    l.T = T;
    set_roughness(&l, ax, ay);
    l.eta = backfacing ? 1 / ior : ior;
    l.c0 = reflection;
    l.c1 = transmission;
    return l;
}

// How often a facet with reflectance F is taken to reflect.
static inline real facets_share(const Lobe *l, real3 F)
{
    real r = max_component(F * l->c0), t = max_component((1 - F) * l->c1);
    return r > 0 ? r / (r + t) : 0;
}

// The directions' part of facets_sample: 0, or SAMPLE_REFLECT or SAMPLE_TRANSMIT.
static inline int facets_direction(const Lobe *l, real3 wo, real3 m, int reflects, real3 *wi, real *jacobian)
{
    real c = dot(wo, m);
    if (reflects) {
        *wi = m * (2 * c) - wo;
        *jacobian = (real)0.25;
        return wi->z > 0 ? SAMPLE_REFLECT : 0;
    }
    int rough = l->ax > 0;
    real eta = rough ? refraction_eta(l->eta) : l->eta;
    real cos_t = refract_direction(wo, m, c, eta, wi);
    if (!(cos_t > 0 && wi->z < 0)) return 0;
    real len = (eta - 1) * (eta + 1) / (c + eta * cos_t);
    *jacobian = rough ? eta * eta * cos_t * c / (len * len) : 0;
    return SAMPLE_TRANSMIT;
}

// The shadowing of a direction: G1.
static inline real facets_G1(const Lobe *l, real3 w)
{
    real z = fabs(w.z);
    return z / ndf_projected(l, (real3)(w.x, w.y, z));
}

#define FACETS(NAME)                                                                                                    \
    static inline real3 NAME##_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)                                       \
    {                                                                                                                   \
        *pdf = 0;                                                                                                       \
        if (l->ax <= 0) return (real3)(0);                                                                              \
        Frame frame = lobe_frame(l);                                                                                    \
        wo = to_local(&frame, wo);                                                                                      \
        wi = to_local(&frame, wi);                                                                                      \
        int reflects = wi.z > 0;                                                                                        \
        if (!(l->flags & (reflects ? LOBE_REFLECTS : LOBE_TRANSMITS))) return (real3)(0);                               \
        real3 m;                                                                                                        \
        real f = reflects ? ndf_reflect(l, wo, wi, &m, pdf) : ndf_refract(l, wo, wi, l->eta, &m, pdf);                  \
        if (!(*pdf > 0)) return (real3)(0);                                                                             \
        real3 F = NAME##_fresnel(l, dot(wo, m));                                                                        \
        real share = facets_share(l, F);                                                                                \
        *pdf *= reflects ? share : 1 - share;                                                                           \
        return f * (reflects ? F * l->c0 : (1 - F) * l->c1);                                                            \
    }                                                                                                                   \
                                                                                                                        \
    static inline int NAME##_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)               \
    {                                                                                                                   \
        int rough = l->ax > 0;                                                                                          \
        Frame frame = lobe_frame(l);                                                                                    \
        wo = to_local(&frame, wo);                                                                                      \
        *pdf = 0;                                                                                                       \
        if (!(wo.z > 0)) return 0;                                                                                      \
        real3 m = rough ? ndf_sample(l, wo, u.x, u.y) : (real3)(0, 0, 1);                                               \
        real c = dot(wo, m);                                                                                            \
        if (!(c > 0)) return 0;                                                                                         \
        real3 F = NAME##_fresnel(l, c);                                                                                 \
        real share = facets_share(l, F);                                                                                \
        int reflects = u.z < share;                                                                                     \
        real density = reflects ? share : 1 - share;                                                                    \
        if (!(density > 0)) return 0;                                                                                   \
        real3 local_wi;                                                                                                 \
        real jacobian;                                                                                                  \
        int side = facets_direction(l, wo, m, reflects, &local_wi, &jacobian);                                          \
        if (!side) return 0;                                                                                            \
        *wi = to_world(&frame, local_wi);                                                                               \
        *value = (reflects ? F * l->c0 : (1 - F) * l->c1) / density;                                                    \
        if (!(max_component(*value) > 0)) return 0;                                                                     \
        if (!rough) return side | SAMPLE_DELTA;                                                                         \
        *pdf = ndf_D(l, m) / ndf_projected(l, wo) * jacobian * density;                                                 \
        if (!is_finite_positive(*pdf)) return 0;                                                                        \
        *value *= facets_G1(l, local_wi);                                                                               \
        return side | SAMPLE_GLOSSY;                                                                                    \
    }                                                                                                                   \
                                                                                                                        \
    static inline real3 NAME##_albedo3(Lobe l, real3 wo)                                                                \
    {                                                                                                                   \
        Frame frame = lobe_frame(&l);                                                                                   \
        wo = to_local(&frame, wo);                                                                                      \
        if (!(wo.z > 0)) return (real3)(0);                                                                             \
        const int points = l.ax > 0 ? ALBEDO_POINTS : 1;                                                                \
        real3 sum = (real3)(0);                                                                                         \
        for (int k = 0; k < points; k++) {                                                                              \
            const real3 u = albedo_point(k);                                                                            \
            real3 m = l.ax > 0 ? ndf_sample(&l, wo, u.x, u.y) : (real3)(0, 0, 1);                                       \
            real c = dot(wo, m), jacobian;                                                                              \
            if (!(c > 0)) continue;                                                                                     \
            real3 F = NAME##_fresnel(&l, c), wi;                                                                        \
            if ((l.flags & LOBE_REFLECTS) && facets_direction(&l, wo, m, 1, &wi, &jacobian))                            \
                sum += F * l.c0 * (l.ax > 0 ? facets_G1(&l, wi) : (real)1);                                             \
            if ((l.flags & LOBE_TRANSMITS) && facets_direction(&l, wo, m, 0, &wi, &jacobian))                           \
                sum += (1 - F) * l.c1 * (l.ax > 0 ? facets_G1(&l, wi) : (real)1);                                       \
        }                                                                                                               \
        return clamp(sum / points, (real3)(0), (real3)(1));                                                             \
    }                                                                                                                   \
                                                                                                                        \
    /* Fresnel's law at N stands for the mean over the facets; of a rough lobe it is kept from 0. */                    \
    static inline real NAME##_albedo(const Lobe *l, real3 wo)                                                           \
    {                                                                                                                   \
        real co = dot(l->N, wo);                                                                                        \
        if (!(co > 0)) return 0;                                                                                        \
        real3 F = NAME##_fresnel(l, co);                                                                                \
        real albedo = max_component(F * l->c0 + (1 - F) * l->c1);                                                       \
        real most = fmax(max_component(l->c0), max_component(l->c1));                                                   \
        return fmin(l->ax > 0 ? fmax(albedo, (real)0.02 * fmin(most, (real)1)) : albedo, (real)1);                      \
    }

#endif
