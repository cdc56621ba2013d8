// oren_nayar_diffuse_bsdf(N, albedo, roughness, "energy_compensation", int): rough diffuse reflection; roughness 0 is Lambert.
// Without compensation it is oren_nayar with sigma = roughness: MaterialX takes the roughness as the slopes' deviation.
// With it, the energy-preserving form: Portsmouth, Kutz and Hill, "EON: A Practical Energy-Preserving Rough Diffuse BRDF",
// 2024, eq. 14 (FON), 17, 19 and 28 (the light of more than one bounce), with the colour of the extra bounces left to the albedo as
// the reference renderer does. Its albedo is 1 for every roughness and direction. roughness is taken within 0..1 then.
// The albedo is a factor of the weight: see ClosureRow::tint.
#ifndef OSLCL_BSDF_OREN_NAYAR_DIFFUSE_H
#define OSLCL_BSDF_OREN_NAYAR_DIFFUSE_H

#include "bsdf/albedo.h"
#include "bsdf/oren_nayar.h"

static inline Lobe closure_oren_nayar_diffuse_bsdf_vfi(real3 N, real roughness, int compensate)
{
    Lobe l = closure_oren_nayar_vf(N, roughness);
    l.type = LOBE_OREN_NAYAR_DIFFUSE;
    if (compensate) {
        l.flags |= LOBE_COMPENSATED;
        l.ax = fmin(l.ax, (real)1);
    }
    return l;
}

// 1/2 - 2/(3 pi) and 2/3 - 28/(15 pi).
#define FON_1 0.28779341
#define FON_2 0.07248821

// Albedo of the single bounce for a cosine.
static inline real fon_albedo(real r, real c)
{
    real A = 1 / (1 + (real)FON_1 * r);
    c = clamp(c, (real)1e-6, (real)1);
    real s = safe_sqrt((1 - c) * (1 + c));
    real G = s * (m_acos(c) - s * c) + (real)(2.0 / 3.0) * (s / c * (1 - s * s * s) - s);
    return A * (1 + r * (real)INV_PI * G);
}

// pi f.
static inline real eon_pi_f(real r, real co, real ci, real between)
{
    real A = 1 / (1 + (real)FON_1 * r);
    real s = between - co * ci;
    real single = A * (1 + r * (s > 0 ? s / fmax(co, ci) : s));
    real lost = fmax(1 - A * (1 + (real)FON_2 * r), (real)1e-6);
    real more = fmax(1 - fon_albedo(r, co), (real)0) * fmax(1 - fon_albedo(r, ci), (real)0) / lost;
    return fmax(single + (r > (real)1e-5 ? more : 0), (real)0);
}

static inline real oren_nayar_diffuse_pi_f(const Lobe *l, real co, real ci, real between)
{
    return l->flags & LOBE_COMPENSATED ? eon_pi_f(l->ax, co, ci, between) : oren_nayar_pi_f(l->ax, co, ci, between);
}

static inline real oren_nayar_diffuse_albedo(const Lobe *l, real3 wo) { return dot(l->N, wo) > 0 ? 1 : 0; }

static inline real3 oren_nayar_diffuse_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)
{
    real co = dot(l->N, wo), ci = dot(l->N, wi);
    *pdf = 0;
    if (!(co > 0 && ci > 0)) return (real3)(0);
    *pdf = ci * (real)INV_PI;
    return (real3)(*pdf * oren_nayar_diffuse_pi_f(l, co, ci, dot(wo, wi)));
}

static inline int oren_nayar_diffuse_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    real co = dot(l->N, wo);
    if (!(co > 0)) return 0;
    Frame frame = frame_from_normal(l->N);
    real3 local_wi = sample_cosine(u.x, u.y);
    if (!(local_wi.z > 0)) return 0;
    *wi = to_world(&frame, local_wi);
    *value = (real3)(oren_nayar_diffuse_pi_f(l, co, local_wi.z, dot(wo, *wi)));
    *pdf = local_wi.z * (real)INV_PI;
    return SAMPLE_REFLECT | SAMPLE_DIFFUSE;
}

ALBEDO_BY_SAMPLING(oren_nayar_diffuse)

#endif
