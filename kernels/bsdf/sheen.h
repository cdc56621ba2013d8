// sheen_bsdf(N, albedo, roughness, "mode", int): light scattered back by fibres that stand up from the surface.
// Mode 0: Conty and Kulla, "Production Friendly Microfacet Sheen BRDF", 2017: D = (2 + 1/a) sin^(1/a) / (2 pi), with the
// visibility term 1 / (4 (co + ci - co ci)) of the Enterprise PBR shading model (Dassault Systemes, 2022, "sheen"), which
// MaterialX takes; roughness within 0.07..1. Where that returns more light than it gets it is scaled as burley_diffuse.h does.
// Mode 1: Zeltner, Burley and Chiang, "Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines", 2022, with the
// rational fits of the MaterialX library for their table (aInv, bInv, albedo), at the root of the roughness, as the reference
// implementation has it; the root within 0.02..1. Not reciprocal.
// The albedo is a factor of the weight: see ClosureRow::tint.
#ifndef OSLCL_BSDF_SHEEN_H
#define OSLCL_BSDF_SHEEN_H

#include "bsdf/albedo.h"
#include "bsdf/frame.h"
#include "bsdf/sampling.h"
#include "lobe.h"

static inline Lobe closure_sheen_bsdf_vfi(real3 N, real roughness, int mode)
{
    Lobe l = {0};
    l.type = LOBE_SHEEN;
    l.flags = LOBE_REFLECTS | (mode == 1 ? LOBE_ZELTNER : 0);
    l.N = safe_normalize(N);
    l.ax = mode == 1 ? fmin(fmax(safe_sqrt(roughness), (real)0.02), (real)1) : fmin(fmax(roughness, (real)0.07), (real)1);
    return l;
}

// Albedo of mode 0 before it is scaled: the rational fit of the MaterialX library. Error below 0.09, at grazing incidence; where
// the albedo is above 1 the fit is above it.
static inline real conty_kulla_albedo(real a, real c)
{
    real x = (real)13.67300 + (real)-68.78018 * c + (real)799.08825 * a + (real)-905.00061 * c * a +
             (real)60.28956 * c * c + (real)1086.96473 * a * a;
    real y = 1 + (real)61.57746 * c + (real)442.78211 * a + (real)2597.49308 * c * a + (real)121.81241 * c * c +
             (real)3045.55075 * a * a;
    return clamp(x / y, (real)0, (real)2);
}

static inline real zeltner_albedo(real c, real r)
{
    real s = r * ((real)0.0206607 + (real)1.58491 * r) / ((real)0.0379424 + r * ((real)1.32227 + r));
    real m = r * ((real)-0.193854 + r * ((real)-1.14885 + r * ((real)1.7932 - (real)0.95943 * r * r))) / ((real)0.046391 + r);
    real o = r * ((real)0.000654023 + ((real)-0.0207818 + (real)0.119681 * r) * r) / ((real)1.26264 + r * ((real)-1.92021 + r));
    real d = (c - m) / s;
    return clamp(m_exp((real)-0.5 * d * d) / (s * (real)2.50662827463) + o, (real)0, (real)1);
}

// The two coefficients of the transform that turns the lobe into a cosine.
static inline void zeltner_transform(real c, real r, real *a, real *b)
{
    *a = fmax(((real)2.58126 * c + (real)0.813703 * r) * r / (1 + (real)0.310327 * c * c + (real)2.60994 * c * r), (real)1e-4);
    *b = safe_sqrt(1 - c) * (r - 1) * r * r * r /
         ((real)0.0000254053 + (real)1.71228 * c - (real)1.71506 * c * r + (real)1.34174 * r * r);
}

static inline real sheen_albedo(const Lobe *l, real3 wo)
{
    real c = fmin(dot(l->N, wo), (real)1);
    if (!(c > 0)) return 0;
    real albedo = l->flags & LOBE_ZELTNER ? zeltner_albedo(c, l->ax) : conty_kulla_albedo(l->ax, c);
    return clamp(albedo, (real)1e-6, (real)1);
}

// The shading space: x along the part of wo in the surface, since the transform leans towards the viewer.
static inline Frame sheen_frame(const Lobe *l, real3 wo) { return frame_from_tangent(l->N, wo); }

// f cos of mode 0.
static inline real conty_kulla_f(const Lobe *l, real3 wo, real3 wi)
{
    real co = fmin(wo.z, (real)1), ci = fmin(wi.z, (real)1);
    real3 h = normalize(wo + wi);
    real sine = safe_sqrt(h.x * h.x + h.y * h.y);
    real k = 1 / l->ax;
    real D = sine > 0 ? (2 + k) * m_exp(k * m_log(sine)) * (real)(0.5 * INV_PI) : 0;
    real most = fmax(conty_kulla_albedo(l->ax, co), conty_kulla_albedo(l->ax, ci));
    return D * ci / (4 * (co + ci - co * ci) * fmax(most, (real)1));
}

// Density and, times the albedo, f cos of mode 1.
static inline real zeltner_density(real a, real b, real3 wi)
{
    real3 w = (real3)(a * wi.x + b * wi.z, a * wi.y, wi.z);
    real len2 = dot(w, w);
    return len2 > 0 ? wi.z * (real)INV_PI * sqr(a / len2) : 0;
}

static inline real3 sheen_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)
{
    *pdf = 0;
    Frame frame = sheen_frame(l, wo);
    wo = to_local(&frame, wo);
    wi = to_local(&frame, wi);
    if (!(wo.z > 0 && wi.z > 0)) return (real3)(0);
    if (l->flags & LOBE_ZELTNER) {
        real c = fmin(wo.z, (real)1), a, b;
        zeltner_transform(c, l->ax, &a, &b);
        *pdf = zeltner_density(a, b, wi);
        return (real3)(*pdf * clamp(zeltner_albedo(c, l->ax), (real)1e-6, (real)1));
    }
    *pdf = (real)(0.5 * INV_PI);
    return (real3)(conty_kulla_f(l, wo, wi));
}

static inline int sheen_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    Frame frame = sheen_frame(l, wo);
    wo = to_local(&frame, wo);
    if (!(wo.z > 0)) return 0;
    real3 w;
    if (l->flags & LOBE_ZELTNER) {
        real c = fmin(wo.z, (real)1), a, b;
        zeltner_transform(c, l->ax, &a, &b);
        w = sample_cosine(u.x, u.y);
        w = safe_normalize((real3)((w.x - b * w.z) / a, w.y / a, w.z));
        if (!(w.z > 0)) return 0;
        *pdf = zeltner_density(a, b, w);
        *value = (real3)(clamp(zeltner_albedo(c, l->ax), (real)1e-6, (real)1));
    } else {
        // The lobe is wide: every direction alike.
        real s, c;
        m_sincos((real)(2 * PI) * u.x, &s, &c);
        real r = safe_sqrt(u.y * (2 - u.y));
        w = (real3)(r * c, r * s, 1 - u.y);
        if (!(w.z > 0)) return 0;
        *pdf = (real)(0.5 * INV_PI);
        *value = (real3)(conty_kulla_f(l, wo, w) * (real)(2 * PI));
    }
    if (!is_finite_positive(*pdf)) return 0;
    *wi = to_world(&frame, w);
    return SAMPLE_REFLECT | SAMPLE_DIFFUSE;
}

ALBEDO_IS_EXACT(sheen)

#endif
