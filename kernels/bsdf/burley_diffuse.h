// burley_diffuse_bsdf(N, albedo, roughness): the diffuse part of Disney's shading model, brighter towards grazing angles when rough.
// Burley, "Physically Based Shading at Disney", 2012, sec. 5.3. That formula returns up to 1.5 times the light that it gets
// (roughness 1, grazing incidence); it is divided by the albedo of either direction where that is above 1, by the fit below, so
// that it stays reciprocal and no light is made. Elsewhere it is Burley's.
// The albedo is a factor of the weight: see ClosureRow::tint.
#ifndef OSLCL_BSDF_BURLEY_DIFFUSE_H
#define OSLCL_BSDF_BURLEY_DIFFUSE_H

#include "bsdf/albedo.h"
#include "bsdf/frame.h"
#include "bsdf/sampling.h"
#include "lobe.h"

static inline Lobe closure_burley_diffuse_bsdf_vf(real3 N, real roughness)
{
    Lobe l = {0};
    l.type = LOBE_BURLEY_DIFFUSE;
    l.flags = LOBE_REFLECTS;
    l.N = safe_normalize(N);
    l.ax = fmin(fmax(roughness, (real)0), (real)1);
    return l;
}

// Albedo of Burley's formula: MaterialX specification, "Physically Based Shading Nodes" (Academy Software Foundation, 2023), the fit
// of the GLSL library; error below 0.02, and hardly ever too small.
static inline real burley_albedo_fit(real roughness, real c)
{
    real x = 1 - c, x2 = x * x;
    real smooth = (real)0.97619 - (real)0.488095 * x2 * x2 * x;
    real rough = (real)1.55754 + ((real)-2.02221 + ((real)2.56283 - (real)1.06244 * c) * c) * c;
    return smooth + (rough - smooth) * roughness;
}

// pi f.
static inline real burley_pi_f(real roughness, real co, real ci, real between)
{
    // cos^2 of half the angle between the directions.
    real f90 = (real)0.5 + roughness * fmax(1 + between, (real)0);
    real xo = 1 - co, xi = 1 - ci;
    real o = 1 + (f90 - 1) * (xo * xo) * (xo * xo) * xo;
    real i = 1 + (f90 - 1) * (xi * xi) * (xi * xi) * xi;
    real most = fmax(burley_albedo_fit(roughness, co), burley_albedo_fit(roughness, ci)) * (real)1.005;
    return o * i / fmax(most, (real)1);
}

static inline real burley_diffuse_albedo(const Lobe *l, real3 wo) { return dot(l->N, wo) > 0 ? 1 : 0; }

static inline real3 burley_diffuse_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)
{
    real co = dot(l->N, wo), ci = dot(l->N, wi);
    *pdf = 0;
    if (!(co > 0 && ci > 0)) return (real3)(0);
    *pdf = ci * (real)INV_PI;
    return (real3)(*pdf * burley_pi_f(l->ax, fmin(co, (real)1), fmin(ci, (real)1), dot(wo, wi)));
}

static inline int burley_diffuse_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    real co = dot(l->N, wo);
    if (!(co > 0)) return 0;
    Frame frame = frame_from_normal(l->N);
    real3 local_wi = sample_cosine(u.x, u.y);
    if (!(local_wi.z > 0)) return 0;
    *wi = to_world(&frame, local_wi);
    *value = (real3)(burley_pi_f(l->ax, fmin(co, (real)1), local_wi.z, dot(wo, *wi)));
    *pdf = local_wi.z * (real)INV_PI;
    return SAMPLE_REFLECT | SAMPLE_DIFFUSE;
}

ALBEDO_BY_SAMPLING(burley_diffuse)

#endif
