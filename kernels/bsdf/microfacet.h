// microfacet(distribution, N, T, ax, ay, eta, refract) and microfacet(distribution, N, alpha, eta, refract): a rough
// dielectric; refract 0 reflects (weight F), 1 refracts (1 - F), 2 does both.
// Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007. Light that hits a second facet is lost.
// eta is the index below the surface over the one above, as the shader gives it (backfacing() ? 1/ior : ior).
// eta <= 0: no Fresnel, reflectance 1; then refract = 1 is black and refract = 2 is a metal.
// Roughness below ALPHA_MIN is the smooth surface. Radiance is not scaled by eta^2: see refraction.h.
#ifndef OSLCL_BSDF_MICROFACET_H
#define OSLCL_BSDF_MICROFACET_H

#include "bsdf/albedo.h"
#include "bsdf/distribution.h"
#include "bsdf/fresnel.h"

static inline Lobe closure_microfacet_svvfffi(int dist, real3 N, real3 T, real ax, real ay, real eta, int refract)
{
    Lobe l = {0};
    l.type = LOBE_MICROFACET;
    l.flags = distribution_flag(dist) | (refract != 1 ? LOBE_REFLECTS : 0) | (refract != 0 ? LOBE_TRANSMITS : 0);
    l.N = safe_normalize(N);
    l.T = T;
    set_roughness(&l, ax, ay);
    l.eta = eta;
    return l;
}

static inline Lobe closure_microfacet_svffi(int dist, real3 N, real alpha, real eta, int refract)
{
    return closure_microfacet_svvfffi(dist, N, (real3)(0), alpha, alpha, eta, refract);
}

static inline int microfacet_does_both(const Lobe *l)
{
    return (l->flags & LOBE_REFLECTS) && (l->flags & LOBE_TRANSMITS);
}

// Fresnel's law at N stands for the mean over the facets. Of a rough lobe it is kept from 0: facets turned elsewhere
// may do what N doesn't.
static inline real microfacet_albedo(const Lobe *l, real3 wo)
{
    real co = dot(l->N, wo);
    if (!(co > 0)) return 0;
    if (microfacet_does_both(l)) return 1;
    real F = fresnel_dielectric(co, l->eta);
    real albedo = l->flags & LOBE_REFLECTS ? F : 1 - F;
    return l->ax > 0 && !(l->eta <= 0) ? fmax(albedo, (real)0.02) : albedo;
}

static inline real3 microfacet_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)
{
    *pdf = 0;
    if (l->ax <= 0) return (real3)(0);
    Frame frame = lobe_frame(l);
    wo = to_local(&frame, wo);
    wi = to_local(&frame, wi);
    int reflects = wi.z > 0;
    if (!(l->flags & (reflects ? LOBE_REFLECTS : LOBE_TRANSMITS)) || (!reflects && !(l->eta > 0))) return (real3)(0);
    real3 m;
    real f = reflects ? ndf_reflect(l, wo, wi, &m, pdf) : ndf_refract(l, wo, wi, l->eta, &m, pdf);
    if (!(*pdf > 0)) return (real3)(0);
    real F = fresnel_dielectric(dot(wo, m), l->eta);
    real share = reflects ? F : 1 - F;
    if (microfacet_does_both(l)) *pdf *= share;
    else if (!reflects && share <= 0) *pdf = 0;
    return (real3)(f * share);
}

static inline int microfacet_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    int rough = l->ax > 0;
    Frame frame = lobe_frame(l);
    wo = to_local(&frame, wo);
    *pdf = 0;
    if (!(wo.z > 0)) return 0;
    real3 m = rough ? ndf_sample(l, wo, u.x, u.y) : (real3)(0, 0, 1);
    real c = dot(wo, m);
    if (!(c > 0)) return 0;
    real F = fresnel_dielectric(c, l->eta);
    int both = microfacet_does_both(l);
    int reflects = both ? u.z < F : (l->flags & LOBE_REFLECTS) != 0;
    real share = reflects ? F : 1 - F;
    if (!(share > 0)) return 0;
    real weight = both ? 1 : share;
    real density = both ? share : 1;
    real3 local_wi;
    real jacobian; // d m / d wi, times c
    if (reflects) {
        local_wi = m * (2 * c) - wo;
        if (!(local_wi.z > 0)) return 0;
        jacobian = (real)0.25;
    } else {
        real eta = rough ? refraction_eta(l->eta) : l->eta;
        real cos_t = refract_direction(wo, m, c, eta, &local_wi);
        if (!(cos_t > 0 && local_wi.z < 0)) return 0;
        // |c - eta cos_t|, free of cancellation.
        real len = (eta - 1) * (eta + 1) / (c + eta * cos_t);
        jacobian = rough ? eta * eta * cos_t * c / (len * len) : 0;
    }
    *wi = to_world(&frame, local_wi);
    if (rough) {
        *pdf = ndf_D(l, m) / ndf_projected(l, wo) * jacobian * density;
        if (!is_finite_positive(*pdf)) return 0;
        real z = fabs(local_wi.z);
        weight *= z / ndf_projected(l, (real3)(local_wi.x, local_wi.y, z));
    }
    *value = (real3)(weight);
    return (reflects ? SAMPLE_REFLECT : SAMPLE_TRANSMIT) | (rough ? SAMPLE_GLOSSY : SAMPLE_DELTA);
}

// The mean of one kind of light over the rule of albedo.h.
static inline real microfacet_one_side(Lobe l, real3 wo, int side)
{
    l.flags = (l.flags & LOBE_BECKMANN) | (side & (LOBE_REFLECTS | LOBE_TRANSMITS));
    real sum = 0;
    for (int k = 0; k < ALBEDO_POINTS; k++) {
        real3 wi, value;
        real pdf;
        if (microfacet_sample(&l, wo, albedo_point(k), &wi, &value, &pdf)) sum += value.x;
    }
    return fmin(sum / ALBEDO_POINTS, (real)1);
}

static inline real3 microfacet_albedo3(Lobe l, real3 wo)
{
    real albedo = 0;
    if (l.flags & LOBE_REFLECTS) albedo += microfacet_one_side(l, wo, LOBE_REFLECTS);
    if (l.flags & LOBE_TRANSMITS) albedo += microfacet_one_side(l, wo, LOBE_TRANSMITS);
    return (real3)(fmin(albedo, (real)1));
}

#endif
