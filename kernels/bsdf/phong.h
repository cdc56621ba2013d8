// phong(N, exponent): cos^exponent around the mirror direction, f = (n + 2)/(2 pi) cos^n.
// Lafortune and Willems, "Using the Modified Phong Reflectance Model for Physically Based Rendering", 1994, eq. 3 with
// ks = 1: reciprocal, albedo 1 at normal incidence and less elsewhere.
// The exponent is taken within 0..1e6; sharper lobes are finer than the directions of f32.
#ifndef OSLCL_BSDF_PHONG_H
#define OSLCL_BSDF_PHONG_H

#include "bsdf/albedo.h"
#include "bsdf/fresnel.h"
#include "bsdf/frame.h"
#include "bsdf/sampling.h"
#include "lobe.h"

static inline Lobe closure_phong_vf(real3 N, real exponent)
{
    Lobe l = {0};
    l.type = LOBE_PHONG;
    l.flags = LOBE_REFLECTS;
    l.N = safe_normalize(N);
    l.ax = fmin(fmax(exponent, (real)0), (real)1e6);
    return l;
}

static inline real phong_albedo(const Lobe *l, real3 wo) { return dot(l->N, wo) > 0 ? 1 : 0; }

// f |cos| / pdf for a direction with cosine ci.
static inline real phong_ratio(real n, real ci) { return ci * (n + 2) / (n + 1); }

static inline real3 phong_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)
{
    real co = dot(l->N, wo), ci = dot(l->N, wi);
    *pdf = 0;
    if (!(co > 0 && ci > 0)) return (real3)(0);
    // 1 - cos of the angle to the mirror direction, by the chord: it has to be exact where the lobe is sharp.
    real3 chord = wi - reflect_direction(wo, l->N);
    real d = (real)0.5 * dot(chord, chord);
    if (!(d < 1)) return (real3)(0);
    *pdf = (l->ax + 1) * (real)(0.5 * INV_PI) * pow_one_minus(d, l->ax);
    return (real3)(*pdf * phong_ratio(l->ax, ci));
}

static inline int phong_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    if (!(dot(l->N, wo) > 0)) return 0;
    real n = l->ax;
    real s, c;
    m_sincos((real)(2 * PI) * u.x, &s, &c);
    // 1 - cos of the angle to the mirror direction; cos^(n + 1) is uniform.
    real d = one_minus_exp(-m_log(fmax(u.y, (real)2.9802322387695312e-8)) / (n + 1));
    real sin_r = safe_sqrt(d * (2 - d));
    Frame frame = frame_from_normal(reflect_direction(wo, l->N));
    *wi = to_world(&frame, (real3)(sin_r * c, sin_r * s, 1 - d));
    real ci = dot(l->N, *wi);
    if (!(ci > 0)) return 0;
    *pdf = (n + 1) * (real)(0.5 * INV_PI) * pow_one_minus(d, n);
    if (!(*pdf > 0)) return 0;
    *value = (real3)(phong_ratio(n, ci));
    return SAMPLE_REFLECT | SAMPLE_GLOSSY;
}

ALBEDO_BY_SAMPLING(phong)

#endif
