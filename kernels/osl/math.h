// OSL's mathematical functions (specification ch. 7.1): osl_NAME_RET_ARGS, triples component by component.
//
// In, out: values only. The elementary functions come from maths.h; this file adds OSL's results for bad arguments,
// so that no shader produces an infinity or a NaN from finite arguments:
//   x / 0 and any quotient that is not finite: 0        sqrt, inversesqrt of a negative or a NaN: 0; inversesqrt(0): 0
//   log family: argument clamped to [FLT_MIN, FLT_MAX], NaN to FLT_MIN (log(0) = -87.3365); logb of |x| likewise, but of
//   NaN 128
//   exp, exp2, expm1, pow: within [2^-126, 2^126], where its exponentials saturate; sinh, cosh within 2^125; NaN to the smallest
//   log(x, 1): 0, as x / 0      pow(0, y != 0): 0      pow(x, 0): 1      pow(x, 1): x      pow(x < 0, fraction): 0
//   pow: |x| clamped as for a logarithm, |y| from 2^24 on is even, 0 * inf and NaN in the exponent to 2^-126
//   asin, acos: argument clamped to [-1, 1]      fmod(a, 0): 0      mod(a, 0): a      sign(NaN): 1      hypot(NaN): 0
//   min(NaN, y), max(NaN, y): NaN; min(x, NaN), max(x, NaN): x
// OSL's float has 32 bits, so those limits are float's in f64 as well: an f64 run evaluates the same language.
//
// Decided differently from the reference implementation, whose values there are artefacts of fast approximations:
// - A NaN argument gives NaN but for the cases above; so do sin, cos, tan of infinities (it: +-1, inf). cbrt(inf) is inf.
// - Trigonometric functions stay exact beyond 1e5, fmod for any quotient (it returns a or NaN for fmod(a, inf)).
// - Denormal numbers are not flushed.
#ifndef OSLCL_OSL_MATH_H
#define OSLCL_OSL_MATH_H

#include "maths.h"

// Triple forms of a scalar function.
#define OSL_MAP1(NAME)                                                                                                 \
    static inline real3 osl_##NAME##_v_v(real3 a) {                                                                    \
        return (real3)(osl_##NAME##_f_f(a.x), osl_##NAME##_f_f(a.y), osl_##NAME##_f_f(a.z));                           \
    }
#define OSL_MAP2(NAME)                                                                                                 \
    static inline real3 osl_##NAME##_v_vv(real3 a, real3 b) {                                                          \
        return (real3)(osl_##NAME##_f_ff(a.x, b.x), osl_##NAME##_f_ff(a.y, b.y), osl_##NAME##_f_ff(a.z, b.z));         \
    }
#define OSL_MAP2F(NAME)                                                                                                \
    static inline real3 osl_##NAME##_v_vf(real3 a, real b) {                                                           \
        return (real3)(osl_##NAME##_f_ff(a.x, b), osl_##NAME##_f_ff(a.y, b), osl_##NAME##_f_ff(a.z, b));               \
    }
#define OSL_MAP3(NAME)                                                                                                 \
    static inline real3 osl_##NAME##_v_vvv(real3 a, real3 b, real3 c) {                                                \
        return (real3)(osl_##NAME##_f_fff(a.x, b.x, c.x), osl_##NAME##_f_fff(a.y, b.y, c.y),                           \
                       osl_##NAME##_f_fff(a.z, b.z, c.z));                                                             \
    }

// a / b as OSL defines it.
static inline real osl_quotient(real a, real b) {
    real q = a / b;
    return fabs(q) <= FLT_MAX ? q : 0;
}

// Where the exponentials of the reference implementation stop: 2^-126 (FLT_MIN) and 2^126.
#define OSL_POWER_MAX ((real)8.507059173023461e37)

// A power within those limits, NaN as the smallest; those of maths_fast.h are.
#ifdef OSLCL_MATHS_FAST_H
static inline real osl_power(real x) { return x; }
#else
static inline real osl_power(real x) { return x > FLT_MIN ? (x < OSL_POWER_MAX ? x : OSL_POWER_MAX) : FLT_MIN; }
#endif

// Within [-limit, limit]; NaN stays.
static inline real osl_within(real x, real limit) { return x > limit ? limit : (x < -limit ? -limit : x); }

// The argument of a logarithm.
static inline real osl_log_argument(real x) { return x > FLT_MIN ? (x < FLT_MAX ? x : FLT_MAX) : FLT_MIN; }

// ---- Angles ---------------------------------------------------------------------------------------------------------

static inline real osl_radians_f_f(real x) { return x * (PI / 180); }
static inline real osl_degrees_f_f(real x) { return x * (180 / PI); }
static inline real osl_sin_f_f(real x) { return m_sin(x); }
static inline real osl_cos_f_f(real x) { return m_cos(x); }
static inline real osl_tan_f_f(real x) { return m_tan(x); }
static inline real osl_asin_f_f(real x) { return m_asin(osl_within(x, 1)); }
static inline real osl_acos_f_f(real x) { return m_acos(osl_within(x, 1)); }
static inline real osl_atan_f_f(real x) { return m_atan(x); }
static inline real osl_atan2_f_ff(real y, real x) { return m_atan2(y, x); }
static inline real osl_sinh_f_f(real x) { return osl_within(m_sinh(x), OSL_POWER_MAX / 2); }
static inline real osl_cosh_f_f(real x) {
    real r = m_cosh(x);
    return r < OSL_POWER_MAX / 2 ? r : OSL_POWER_MAX / 2;
}
static inline real osl_tanh_f_f(real x) { return m_tanh(x); }

OSL_MAP1(radians)
OSL_MAP1(degrees)
OSL_MAP1(sin)
OSL_MAP1(cos)
OSL_MAP1(tan)
OSL_MAP1(asin)
OSL_MAP1(acos)
OSL_MAP1(atan)
OSL_MAP2(atan2)
OSL_MAP1(sinh)
OSL_MAP1(cosh)
OSL_MAP1(tanh)

static inline void osl_sincos_n_fofof(real x, real *s, real *c) { m_sincos(x, s, c); }

static inline void osl_sincos_n_vovov(real3 x, real3 *s, real3 *c) {
    real sx, sy, sz, cx, cy, cz;
    m_sincos(x.x, &sx, &cx);
    m_sincos(x.y, &sy, &cy);
    m_sincos(x.z, &sz, &cz);
    *s = (real3)(sx, sy, sz);
    *c = (real3)(cx, cy, cz);
}

// ---- Powers and logarithms ------------------------------------------------------------------------------------------

// Squares are exact but for the largest.
static inline real osl_pow_f_ff(real x, real y) {
    real size = osl_power(m_powr(osl_log_argument(fabs(x)), y));
    int fits = fabs(y) < 16777216, whole = fits ? (int)y : 0;
    real below = fits && (real)whole != y ? 0 : (whole & 1 ? -size : size);
    real r = y == 2 ? osl_within(x * x, FLT_MAX) : (x < 0 ? below : size);
    return y == 0 ? 1 : (x == 0 ? 0 : (y == 1 ? x : r));
}

static inline real osl_exp_f_f(real x) { return osl_power(m_exp(x)); }
static inline real osl_exp2_f_f(real x) { return osl_power(m_exp2(x)); }
static inline real osl_expm1_f_f(real x) { return x > -100 ? osl_within(m_expm1(x), OSL_POWER_MAX) : -1; }
static inline real osl_log_f_f(real x) { return m_log(osl_log_argument(x)); }
static inline real osl_log_f_ff(real x, real base) { return osl_quotient(osl_log_f_f(x), osl_log_f_f(base)); }
static inline real osl_log2_f_f(real x) { return m_log2(osl_log_argument(x)); }
static inline real osl_log10_f_f(real x) { return m_log10(osl_log_argument(x)); }

// The exponent of the argument's bits: exact, where floor(log2(x)) would round up just below a power of two.
static inline real osl_logb_f_f(real x) {
    real a = osl_log_argument(fabs(x));
    if (isnan(x)) return 128;
#ifdef OSLCL_F64
    return (real)(int)((as_long(a) >> 52) - 1023);
#else
    return (real)((as_int(a) >> 23) - 127);
#endif
}

static inline real osl_sqrt_f_f(real x) { return x >= 0 ? sqrt(x) : 0; }
static inline real osl_inversesqrt_f_f(real x) { return x > 0 ? rsqrt(x) : 0; }
static inline real osl_cbrt_f_f(real x) { return m_cbrt(x); }

OSL_MAP2(pow)
OSL_MAP2F(pow)
OSL_MAP1(exp)
OSL_MAP1(exp2)
OSL_MAP1(expm1)
OSL_MAP1(log)
OSL_MAP2F(log)
OSL_MAP1(log2)
OSL_MAP1(log10)
OSL_MAP1(logb)
OSL_MAP1(sqrt)
OSL_MAP1(inversesqrt)
OSL_MAP1(cbrt)

// The specification's formulas; they overflow where the sum of squares does.
static inline real osl_hypot_f_ff(real x, real y) { return osl_sqrt_f_f(x * x + y * y); }
static inline real osl_hypot_f_fff(real x, real y, real z) { return osl_sqrt_f_f(x * x + y * y + z * z); }

// ---- Rounding, signs, choices ---------------------------------------------------------------------------------------

static inline int osl_abs_i_i(int x) { return x < 0 ? (int)(0u - (uint)x) : x; }
static inline real osl_abs_f_f(real x) { return fabs(x); }
static inline real3 osl_abs_v_v(real3 x) { return fabs(x); }
static inline int osl_fabs_i_i(int x) { return osl_abs_i_i(x); }
static inline real osl_fabs_f_f(real x) { return fabs(x); }
static inline real3 osl_fabs_v_v(real3 x) { return fabs(x); }
static inline real osl_sign_f_f(real x) { return x < 0 ? -1 : (x == 0 ? 0 : 1); }
static inline real osl_floor_f_f(real x) { return floor(x); }
static inline real3 osl_floor_v_v(real3 x) { return floor(x); }
static inline real osl_ceil_f_f(real x) { return ceil(x); }
static inline real3 osl_ceil_v_v(real3 x) { return ceil(x); }
static inline real osl_round_f_f(real x) { return round(x); } // half away from zero
static inline real3 osl_round_v_v(real3 x) { return round(x); }
static inline real osl_trunc_f_f(real x) { return trunc(x); }
static inline real3 osl_trunc_v_v(real3 x) { return trunc(x); }

OSL_MAP1(sign)

// Exact: a - q * b is representable when q is the truncated quotient, and a quotient rounded up shows in the sign.
static inline real osl_fmod_f_ff(real a, real b) {
    real size = fabs(b);
    if (b == 0) return 0;
    if (fabs(a) < size) return a;
    real q = trunc(a / b);
    if (!(fabs(q) < 0.25 / REAL_EPSILON)) return fmod(a, b);
    real r = fma(-q, b, a);
    r = r != 0 && (r < 0) != (a < 0) ? r + copysign(size, a) : r;
    return r;
}

static inline int osl_mod_i_ii(int a, int b) { return b == 0 ? a : (b == -1 ? 0 : a % b); }

// a - b floor(a / b). Where the quotient has no digits left for that, fmod's exact remainder, with the sign of b.
static inline real osl_mod_f_ff(real a, real b) {
    real q = floor(osl_quotient(a, b));
    if (fabs(q) < 0.25 / REAL_EPSILON) return fma(-b, q, a);
    real r = fmod(a, b);
    return r != 0 && (r < 0) != (b < 0) ? r + b : r;
}

OSL_MAP2(fmod)
OSL_MAP2F(fmod)
OSL_MAP2(mod)
OSL_MAP2F(mod)

static inline int osl_min_i_ii(int a, int b) { return b < a ? b : a; }
static inline int osl_max_i_ii(int a, int b) { return a < b ? b : a; }
static inline real osl_min_f_ff(real a, real b) { return b < a ? b : a; }
static inline real osl_max_f_ff(real a, real b) { return a < b ? b : a; }

OSL_MAP2(min)
OSL_MAP2(max)

static inline int osl_clamp_i_iii(int x, int low, int high) { return osl_max_i_ii(osl_min_i_ii(x, high), low); }
static inline real osl_clamp_f_fff(real x, real low, real high) { return osl_max_f_ff(osl_min_f_ff(x, high), low); }

OSL_MAP3(clamp)

static inline real osl_mix_float_f_fff(real a, real b, real t) { return a * (1 - t) + b * t; }
static inline real3 osl_mix_float_v_vvv(real3 a, real3 b, real3 t) { return a * (1 - t) + b * t; }

// b where the condition is not zero.
static inline real osl_select_nonzero_f_fff(real a, real b, real condition) { return condition != 0 ? b : a; }

OSL_MAP3(select_nonzero)

// ---- Classification: by bits, so that relaxed maths cannot fold it away ---------------------------------------------

#ifdef OSLCL_F64
#define OSL_MAGNITUDE_BITS(x) (as_ulong(x) & 0x7fffffffffffffffUL)
#define OSL_INFINITY_BITS 0x7ff0000000000000UL
#else
#define OSL_MAGNITUDE_BITS(x) (as_uint(x) & 0x7fffffffu)
#define OSL_INFINITY_BITS 0x7f800000u
#endif

static inline int osl_isnan_i_f(real x) { return OSL_MAGNITUDE_BITS(x) > OSL_INFINITY_BITS; }
static inline int osl_isinf_i_f(real x) { return OSL_MAGNITUDE_BITS(x) == OSL_INFINITY_BITS; }
static inline int osl_isfinite_i_f(real x) { return OSL_MAGNITUDE_BITS(x) < OSL_INFINITY_BITS; }

static inline real osl_erf_f_f(real x) { return m_erf(x); }
static inline real osl_erfc_f_f(real x) { return m_erfc(x); }

#endif
