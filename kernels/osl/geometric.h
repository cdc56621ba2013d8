// OSL's geometric functions (specification ch. 7.2) but for transforms, which are in matrix.h.
//
// In, out: values only. Results for bad arguments: normalize(0) is 0, refract beyond the critical angle is 0, lengths
// that are NaN are 0. normalize rescales where the squares would leave the range, so that it is right for every finite
// vector; the reference returns 0 for large ones in single precision, which is an artefact.
#ifndef OSLCL_OSL_GEOMETRIC_H
#define OSLCL_OSL_GEOMETRIC_H

#include "osl/math.h"

static inline real osl_dot_f_vv(real3 a, real3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline real3 osl_cross_v_vv(real3 a, real3 b) {
    return (real3)(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline real osl_length_f_v(real3 a) { return osl_sqrt_f_f(osl_dot_f_vv(a, a)); }

static inline real3 osl_normalize_v_v(real3 a) {
    real size = max_component(fabs(a));
    real scale = size > 1e15 ? 1e-20 : (size < 1e-15 ? 1e20 : 1);
    a = a * scale;
    if (size < 1e-30) a = a * 1e20;
    real length = osl_length_f_v(a);
    return length == 0 ? (real3)(0, 0, 0) : a * (1 / length);
}

static inline real osl_distance_f_vv(real3 a, real3 b) { return osl_length_f_v(a - b); }

// From q to the segment from a to b.
static inline real osl_distance_f_vvv(real3 a, real3 b, real3 q) {
    real3 d = b - a;
    real t = osl_clamp_f_fff(osl_quotient(osl_dot_f_vv(q - a, d), osl_dot_f_vv(d, d)), 0, 1);
    return osl_distance_f_vv(q, a + t * d);
}

static inline real3 osl_faceforward_ref_v_vvv(real3 N, real3 I, real3 reference) {
    return osl_dot_f_vv(I, reference) > 0 ? -N : N;
}

static inline real3 osl_reflect_v_vv(real3 I, real3 N) { return I - 2 * osl_dot_f_vv(N, I) * N; }

static inline real3 osl_refract_v_vvf(real3 I, real3 N, real eta) {
    real cosine = osl_dot_f_vv(I, N);
    real k = 1 - eta * eta * (1 - cosine * cosine);
    return k < 0 ? (real3)(0, 0, 0) : eta * I - N * (eta * cosine + osl_sqrt_f_f(k));
}

// Unpolarised Fresnel reflectance of a dielectric (Cook and Torrance 1982, eq. 10 and after) for |cosine| = c and
// eta of the incident over that of the transmitted side; 1 beyond the critical angle.
static inline void osl_fresnel_n_vvfofofovov(real3 I, real3 N, real eta, real *Kr, real *Kt, real3 *R, real3 *T) {
    real c = fabs(osl_dot_f_vv(I, N));
    real g2 = osl_quotient(1, eta * eta) - 1 + c * c;
    *R = osl_reflect_v_vv(I, N);
    if (g2 < 0) {
        *Kr = 1;
        *Kt = 0;
        *T = (real3)(0, 0, 0);
        return;
    }
    real g = osl_sqrt_f_f(g2);
    real s = osl_quotient(g - c, g + c);
    real p = osl_quotient(c * (g + c) - 1, c * (g - c) + 1);
    *Kr = 0.5 * (1 + p * p) * s * s;
    *Kt = (1 - *Kr) * eta * eta;
    *T = osl_refract_v_vvf(I, N, eta);
}

static inline void osl_fresnel_n_vvfofof(real3 I, real3 N, real eta, real *Kr, real *Kt) {
    real3 R, T;
    osl_fresnel_n_vvfofofovov(I, N, eta, Kr, Kt, &R, &T);
}

// About the line from a to b, right-handed (Rodrigues' formula).
static inline real3 osl_rotate_v_vfvv(real3 p, real angle, real3 a, real3 b) {
    real s, c;
    m_sincos(angle, &s, &c);
    real3 axis = osl_normalize_v_v(b - a);
    real3 v = p - a;
    return v * c + osl_cross_v_vv(axis, v) * s + axis * (osl_dot_f_vv(axis, v) * (1 - c)) + a;
}

static inline real3 osl_rotate_v_vfv(real3 p, real angle, real3 axis) {
    return osl_rotate_v_vfvv(p, angle, (real3)(0, 0, 0), axis);
}

#endif
