// chiang_hair_bsdf(N, curve_direction, tint_R, tint_TT, tint_TRT, ior, longitudual_roughness_R, _TT, _TRT, azimuthal_roughness_R,
// _TT, _TRT, cuticle_angle, absorption_coefficient): a fibre that reflects (R), transmits (TT), reflects inside (TRT), and the rest.
// Chiang, Bitterli, Tappan and Burley, "A Practical and Controllable Hair and Fur Model for Production Path Tracing", 2016, after
// d'Eon et al., "An Energy-Conserving Hair Reflectance Model", 2011 (longitudinal, eq. 7); the form of Pharr, "The
// Implementation of a Hair Scattering Model", 2016. Longitudinal roughness is a variance, azimuthal roughness a logistic
// scale, as MaterialX's node chiang_hair_roughness makes them; cuticle_angle 0..1 stands for -pi/2..pi/2, 0.5 for none.
// The offset from the fibre's axis is that of N against the viewer. Light goes all around; the lobe is not reciprocal.
#ifndef OSLCL_BSDF_CHIANG_HAIR_H
#define OSLCL_BSDF_CHIANG_HAIR_H

#include "bsdf/albedo.h"
#include "bsdf/frame.h"
#include "bsdf/fresnel.h"
#include "bsdf/sampling.h"
#include "lobe.h"

static inline Lobe closure_chiang_hair_bsdf_vvvvvffffffffv(real3 N, real3 T, real3 tint_R, real3 tint_TT, real3 tint_TRT,
                                                           real ior, real v_R, real v_TT, real v_TRT, real s_R, real s_TT,
                                                           real s_TRT, real cuticle, real3 absorption)
{
    Lobe l = {0};
    l.type = LOBE_CHIANG_HAIR;
    l.flags = LOBE_REFLECTS | LOBE_TRANSMITS;
    l.N = safe_normalize(N);
    l.T = T;
    l.eta = clamp(ior, (real)1.0001, (real)100);
    l.ax = (clamp(cuticle, (real)0, (real)1) - (real)0.5) * (real)PI;
    l.c0 = clamp(tint_R, (real3)(0), (real3)(1));
    l.c1 = clamp(tint_TT, (real3)(0), (real3)(1));
    l.c2 = clamp(tint_TRT, (real3)(0), (real3)(1));
    l.c3 = clamp(absorption, (real3)(0), (real3)(1e6));
    l.c4 = clamp((real3)(v_R, v_TT, v_TRT), (real3)(1e-4), (real3)(10));
    l.c5 = clamp((real3)(s_R, s_TT, s_TRT), (real3)(1e-2), (real3)(10));
    return l;
}

// What the viewer's direction fixes.
typedef struct {
    Frame frame;        // s along the fibre, n across it towards the viewer
    real sin_o, cos_o;  // longitudinal angle of wo
    real gamma_o, gamma_t;
    real3 A[4];         // attenuation of R, TT, TRT and the rest, with the tints
    real share[4];      // how often each is taken
} HairPoint;

static inline int hair_point(const Lobe *l, real3 wo, HairPoint *h)
{
    if (!(dot(l->N, wo) > 0)) return 0;
    // n across the fibre: the part of wo that is perpendicular to it.
    real3 t = safe_normalize(l->T);
    real3 fibre = t - l->N * dot(l->N, t);
    real len2 = dot(fibre, fibre);
    Frame surface = frame_from_normal(l->N);
    fibre = len2 > (real)1e-6 ? fibre / sqrt(len2) : surface.s;
    h->sin_o = clamp(dot(wo, fibre), (real)-1, (real)1);
    h->cos_o = safe_sqrt((1 - h->sin_o) * (1 + h->sin_o));
    real3 across = wo - fibre * dot(wo, fibre);
    if (!(dot(across, across) > (real)1e-8)) return 0;
    h->frame.s = fibre;
    h->frame.n = normalize(across);
    h->frame.t = cross(h->frame.n, fibre);
    // The offset h = sin(gamma_o) is N's tilt against the viewer around the fibre.
    h->gamma_o = m_atan2(dot(l->N, h->frame.t), dot(l->N, h->frame.n));
    h->gamma_o = clamp(h->gamma_o, (real)(-0.5 * PI), (real)(0.5 * PI));
    real offset = m_sin(h->gamma_o);
    real eta = l->eta;
    real etap = sqrt(fmax(eta * eta - h->sin_o * h->sin_o, (real)1e-6)) / fmax(h->cos_o, (real)1e-4);
    real sin_gt = clamp(offset / etap, (real)-1, (real)1);
    h->gamma_t = m_asin(sin_gt);
    real cos_gt = safe_sqrt((1 - sin_gt) * (1 + sin_gt));
    real sin_t = h->sin_o / eta;
    real cos_t = safe_sqrt((1 - sin_t) * (1 + sin_t));
    real3 path = l->c3 * (2 * cos_gt / fmax(cos_t, (real)1e-4));
    real3 T = (real3)(m_exp(-path.x), m_exp(-path.y), m_exp(-path.z));
    real f = fresnel_dielectric(h->cos_o * safe_sqrt((1 - offset) * (1 + offset)), eta);
    h->A[0] = (real3)(f);
    h->A[1] = (1 - f) * (1 - f) * T;
    h->A[2] = h->A[1] * T * f;
    h->A[3] = h->A[2] * T * f / fmax((real)1 - T * f, (real3)(1e-4));
    h->A[0] *= l->c0;
    h->A[1] *= l->c1;
    h->A[2] *= l->c2;
    h->A[3] *= l->c2;
    real total = 0;
    for (int p = 0; p < 4; p++) total += max_component(h->A[p]);
    if (!(total > 0)) return 0;
    for (int p = 0; p < 4; p++) h->share[p] = max_component(h->A[p]) / total;
    return 1;
}

// ln(I0(x)), Abramowitz and Stegun, "Handbook of Mathematical Functions", 9.8.1 and 9.8.2.
static inline real log_bessel_0(real x)
{
    if (x < (real)3.75) {
        real t = sqr(x / (real)3.75);
        return m_log(1 + t * ((real)3.5156229 + t * ((real)3.0899424 + t * ((real)1.2067492 +
               t * ((real)0.2659732 + t * ((real)0.0360768 + t * (real)0.0045813))))));
    }
    real t = (real)3.75 / x;
    real p = (real)0.39894228 + t * ((real)0.01328592 + t * ((real)0.00225319 + t * ((real)-0.00157565 + t * ((real)0.00916281 +
             t * ((real)-0.02057706 + t * ((real)0.02635537 + t * ((real)-0.01647633 + t * (real)0.00392377)))))));
    return x + m_log(p) - (real)0.5 * m_log(x);
}

// Longitudinal density over the sine of wi's angle. d'Eon et al. 2011, eq. 7.
static inline real hair_M(real sin_i, real cos_i, real sin_o, real cos_o, real v)
{
    real a = cos_i * cos_o / v, b = sin_i * sin_o / v;
    // 1 / (2 v sinh(1/v)) = e^(-1/v) / (v (1 - e^(-2/v)))
    return m_exp(log_bessel_0(a) - b - 1 / v) / (v * one_minus_exp(2 / v));
}

// The logistic distribution of scale s, cut to -pi..pi.
static inline real logistic_cdf(real x, real s) { return 1 / (1 + m_exp(-x / s)); }

static inline real hair_logistic(real x, real s)
{
    real e = m_exp(-fabs(x) / s);
    real d = e / (s * (1 + e) * (1 + e));
    return d / (logistic_cdf((real)PI, s) - logistic_cdf((real)-PI, s));
}

// Azimuth of the p-th lobe: straight on for a smooth fibre.
static inline real hair_phi(int p, real gamma_o, real gamma_t)
{
    return 2 * p * gamma_t - 2 * gamma_o + p * (real)PI;
}

static inline real wrap_angle(real x)
{
    x -= floor((x + (real)PI) / (real)(2 * PI)) * (real)(2 * PI);
    return clamp(x, (real)-PI, (real)PI);
}

// The viewer's longitudinal angle as the tilted scales show it to the p-th lobe: 2, -1, -4 times the tilt.
static inline void hair_tilt(const Lobe *l, const HairPoint *h, int p, real *sin_o, real *cos_o)
{
    const real turns = p == 0 ? -2 : p == 1 ? 1 : 4;
    real s, c;
    m_sincos(p < 3 ? turns * l->ax : (real)0, &s, &c);
    *sin_o = h->sin_o * c + h->cos_o * s;
    *cos_o = fabs(h->cos_o * c - h->sin_o * s);
}

static inline real hair_component(real3 v, int p) { return p == 0 ? v.x : p == 1 ? v.y : v.z; }

// f |cos| and the density, both over solid angle.
static inline real3 hair_f(const Lobe *l, const HairPoint *h, real3 wi, real *pdf)
{
    real sin_i = clamp(dot(wi, h->frame.s), (real)-1, (real)1);
    real cos_i = safe_sqrt((1 - sin_i) * (1 + sin_i));
    real phi = m_atan2(dot(wi, h->frame.t), dot(wi, h->frame.n));
    real3 sum = (real3)(0);
    real density = 0;
    for (int p = 0; p < 4; p++) {
        real sin_o, cos_o;
        hair_tilt(l, h, p, &sin_o, &cos_o);
        real v = hair_component(l->c4, p), s = hair_component(l->c5, p);
        real N = p < 3 ? hair_logistic(wrap_angle(phi - hair_phi(p, h->gamma_o, h->gamma_t)), s) : (real)(0.5 * INV_PI);
        real both = hair_M(sin_i, cos_i, sin_o, cos_o, v) * N;
        sum += h->A[p] * both;
        density += h->share[p] * both;
    }
    *pdf = is_finite_positive(density) ? density : 0;
    return *pdf > 0 ? sum : (real3)(0);
}

static inline real3 chiang_hair_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)
{
    HairPoint h;
    *pdf = 0;
    if (!hair_point(l, wo, &h)) return (real3)(0);
    return hair_f(l, &h, wi, pdf);
}

static inline int chiang_hair_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    HairPoint h;
    *pdf = 0;
    if (!hair_point(l, wo, &h)) return 0;
    // The third number chooses the lobe, and what is left of it the azimuth of the rest.
    int p = 0;
    real w = u.z;
    while (p < 3 && !(w < h.share[p])) {
        w -= h.share[p];
        p++;
    }
    // Rounding may lead past the last one that is there.
    while (p > 0 && !(h.share[p] > 0)) p--;
    real sin_o, cos_o;
    hair_tilt(l, &h, p, &sin_o, &cos_o);
    real v = hair_component(l->c4, p), s = hair_component(l->c5, p);
    // d'Eon, Marschner and Hanika, "Importance Sampling for Physically-Based Hair Fiber Models", 2013, eq. 6 and 7.
    real x = fmax(u.x, (real)1e-6);
    real c = clamp(1 + v * m_log(x + (1 - x) * m_exp(-2 / v)), (real)-1, (real)1);
    real r = safe_sqrt((1 - c) * (1 + c));
    real sp, cp;
    m_sincos((real)(2 * PI) * u.y, &sp, &cp);
    real sin_i = clamp(-c * sin_o + r * cp * cos_o, (real)-1, (real)1);
    real cos_i = safe_sqrt((1 - sin_i) * (1 + sin_i));
    // A number of its own for the azimuth: the place of u.z within its lobe's share.
    real y = clamp(h.share[p] > 0 ? w / h.share[p] : (real)0.5, (real)1e-6, (real)(1 - 1e-6));
    real phi;
    if (p < 3) {
        real low = logistic_cdf((real)-PI, s), high = logistic_cdf((real)PI, s);
        real q = low + y * (high - low);
        phi = hair_phi(p, h.gamma_o, h.gamma_t) + clamp(-s * m_log(1 / q - 1), (real)-PI, (real)PI);
    } else {
        phi = (2 * y - 1) * (real)PI;
    }
    m_sincos(phi, &sp, &cp);
    *wi = normalize(h.frame.s * sin_i + h.frame.n * (cos_i * cp) + h.frame.t * (cos_i * sp));
    real3 f = hair_f(l, &h, *wi, pdf);
    if (!is_finite_positive(*pdf)) return 0;
    *value = f / *pdf;
    return (dot(l->N, *wi) > 0 ? SAMPLE_REFLECT : SAMPLE_TRANSMIT) | SAMPLE_GLOSSY;
}

static inline real chiang_hair_albedo(const Lobe *l, real3 wo)
{
    HairPoint h;
    if (!hair_point(l, wo, &h)) return 0;
    return clamp(max_component(h.A[0] + h.A[1] + h.A[2] + h.A[3]), (real)0, (real)1);
}

// The four lobes have densities of integral 1: their attenuations are the albedo.
static inline real3 chiang_hair_albedo3(Lobe l, real3 wo)
{
    HairPoint h;
    if (!hair_point(&l, wo, &h)) return (real3)(0);
    return clamp(h.A[0] + h.A[1] + h.A[2] + h.A[3], (real3)(0), (real3)(1));
}

#endif
