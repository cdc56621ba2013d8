// oren_nayar(N, sigma): diffuse reflection by V-grooves whose slopes have the standard deviation sigma (radians).
// Oren and Nayar, "Generalization of Lambert's Reflectance Model", 1994, eq. 30 (the qualitative model).
// For sigma below 0.35 that model returns up to 1.5 % more light than it gets, at grazing incidence; it is scaled by its
// largest albedo A + B/2 where that is above 1. sigma = 0 is diffuse(N).
#ifndef OSLCL_BSDF_OREN_NAYAR_H
#define OSLCL_BSDF_OREN_NAYAR_H

#include "bsdf/albedo.h"
#include "bsdf/frame.h"
#include "bsdf/sampling.h"
#include "lobe.h"

static inline Lobe closure_oren_nayar_vf(real3 N, real sigma)
{
    Lobe l = {0};
    l.type = LOBE_OREN_NAYAR;
    l.flags = LOBE_REFLECTS;
    l.N = safe_normalize(N);
    l.ax = fmin(fmax(sigma, (real)0), (real)100);
    return l;
}

// pi f for the cosines with the normal and the cosine between the directions.
static inline real oren_nayar_pi_f(real sigma, real co, real ci, real between)
{
    real s2 = sigma * sigma;
    real A = 1 - (real)0.5 * s2 / (s2 + (real)0.33);
    real B = (real)0.45 * s2 / (s2 + (real)0.09);
    // sin(alpha) tan(beta) cos(phi): the sines' product times cos(phi) is this difference, tan divides by the larger cosine.
    real s = between - co * ci;
    real f = A + (s > 0 ? B * s / fmax(co, ci) : 0);
    return f / fmax((real)1, A + (real)0.5 * B);
}

static inline real oren_nayar_albedo(const Lobe *l, real3 wo) { return dot(l->N, wo) > 0 ? 1 : 0; }

static inline real3 oren_nayar_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)
{
    real co = dot(l->N, wo), ci = dot(l->N, wi);
    *pdf = 0;
    if (!(co > 0 && ci > 0)) return (real3)(0);
    *pdf = ci * (real)INV_PI;
    return (real3)(*pdf * oren_nayar_pi_f(l->ax, co, ci, dot(wo, wi)));
}

static inline int oren_nayar_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    real co = dot(l->N, wo);
    if (!(co > 0)) return 0;
    Frame frame = frame_from_normal(l->N);
    real3 local_wi = sample_cosine(u.x, u.y);
    if (!(local_wi.z > 0)) return 0;
    *wi = to_world(&frame, local_wi);
    *value = (real3)(oren_nayar_pi_f(l->ax, co, local_wi.z, dot(wo, *wi)));
    *pdf = local_wi.z * (real)INV_PI;
    return SAMPLE_REFLECT | SAMPLE_DIFFUSE;
}

ALBEDO_BY_SAMPLING(oren_nayar)

#endif
