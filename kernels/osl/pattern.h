// OSL's step functions (specification ch. 7.6): osl_NAME_RET_ARGS, triples component by component.
//
// In, out: values only. Where the two edges coincide, linearstep, smoothstep and smooth_linearstep are step.
#ifndef OSLCL_OSL_PATTERN_H
#define OSLCL_OSL_PATTERN_H

#include "osl/math.h"

static inline real osl_step_f_ff(real edge, real x) { return x < edge ? 0 : 1; }

OSL_MAP2(step)

static inline real3 osl_step_v_fv(real edge, real3 x) {
    return (real3)(osl_step_f_ff(edge, x.x), osl_step_f_ff(edge, x.y), osl_step_f_ff(edge, x.z));
}

static inline real osl_linearstep_f_fff(real low, real high, real x) {
    real t = osl_clamp_f_fff((x - low) / (high - low), 0, 1);
    return low != high ? t : osl_step_f_ff(low, x);
}

static inline real osl_smoothstep_f_fff(real low, real high, real x) {
    real t = (x - low) / (high - low);
    real s = t * t * (3 - 2 * t);
    return x < low ? 0 : (x >= high ? 1 : s);
}

// linearstep with its two corners rounded by parabolas over eps on either side.
static inline real osl_smooth_linearstep_f_ffff(real low, real high, real x, real eps) {
    real scale = osl_quotient(1, high - low);
    real e = eps * scale;
    real t = (x - low) * scale;
    real rise = t + e, fall = 1 + e - t;
    real k = osl_quotient(0.25, e);
    real r = t < e ? k * rise * rise : 1 - k * fall * fall;
    r = t >= e && t <= 1 - e ? t : r;
    r = t >= 1 + e && !(t >= e && t <= 1 - e) ? 1 : r;
    r = t <= -e ? 0 : r;
    return low != high ? r : osl_step_f_ff(low, x);
}

OSL_MAP3(linearstep)
OSL_MAP3(smoothstep)

static inline real3 osl_linearstep_v_ffv(real low, real high, real3 x) {
    return osl_linearstep_v_vvv((real3)(low, low, low), (real3)(high, high, high), x);
}

static inline real3 osl_smoothstep_v_ffv(real low, real high, real3 x) {
    return osl_smoothstep_v_vvv((real3)(low, low, low), (real3)(high, high, high), x);
}

static inline real3 osl_smooth_linearstep_v_vvvv(real3 low, real3 high, real3 x, real3 eps) {
    return (real3)(osl_smooth_linearstep_f_ffff(low.x, high.x, x.x, eps.x),
                   osl_smooth_linearstep_f_ffff(low.y, high.y, x.y, eps.y),
                   osl_smooth_linearstep_f_ffff(low.z, high.z, x.z, eps.z));
}

static inline real3 osl_smooth_linearstep_v_ffvf(real low, real high, real3 x, real eps) {
    return osl_smooth_linearstep_v_vvvv((real3)(low, low, low), (real3)(high, high, high), x, (real3)(eps, eps, eps));
}

#endif
