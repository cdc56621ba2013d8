// Elementary functions over `real` for renderer and shaders: m_NAME behaves like OpenCL's NAME (IEEE results at the
// edges: log(0) = -inf, NaN in gives NaN out). OSL's own rules for bad arguments live in osl/math.h, on top of this.
//
// In f32 these are range reductions and polynomials of our own: without branches (but for one, |x| > 1e5 in the
// trigonometric ones), the same on each device, and several times faster than those of drivers that call a library
// per lane. In f64, on devices without a fast fma, and with OSLCL_DRIVER_MATH, they are the driver's; in f32 with
// OSLCL_NATIVE_MATH its native ones, where there are such, with errors that nobody bounds.
//
// Largest error in f32, in units in the last place, over all finite arguments (tests/tests/maths.rs):
//   sin cos 1.6 (2.7 beyond 1e5) . tan 2.7 (3.5 beyond) . asin 2.3 . acos atan 1.6 . exp exp2 1.1 . expm1 1.6
//   atan2 1.6 (2.3 where division is not rounded correctly: NVIDIA's devices)
//   log log2 log10 1 . powr 3.3 (1 while |y| < 16) . sinh cosh tanh 2.8 . cbrt 1 . erf 2.2 . erfc 4
// With OSLCL_FAST (`precision = fast`) the most used are shorter: maths_fast.h.
// Next to a multiple of pi the error of sin and cos stays below 2^-47, not below those ulp of the result.
//
// Methods: Cody and Waite, "Software Manual for the Elementary Functions", 1980 (reductions); Payne and Hanek, SIGNUM
// 18(1), 1983 (reduction of large angles); Muller, "Elementary Functions", ch. 11 (log in two floats for pow). The
// coefficients are minimax fits of ours: least squares reweighted after Lawson, leading coefficients rounded first.
#ifndef OSLCL_MATHS_H
#define OSLCL_MATHS_H

#include "real.h"

#if (defined(OSLCL_F64) || defined(OSLCL_NATIVE_MATH)) && !defined(OSLCL_DRIVER_MATH)
#define OSLCL_DRIVER_MATH
#endif
// Without a fused multiply-add in hardware the reductions below would be slow or wrong.
#if !defined(FP_FAST_FMAF) && !defined(__FMA__) && !defined(__NV_CL_C_VERSION) && !defined(OSLCL_DRIVER_MATH)
#define OSLCL_DRIVER_MATH
#endif

static inline real m_sqrt(real x) { return sqrt(x); }

#ifdef OSLCL_DRIVER_MATH

#if defined(OSLCL_NATIVE_MATH) && !defined(OSLCL_F64)
#define M_DRIVER(name) native_##name
#else
#define M_DRIVER(name) name
#endif

static inline real m_sin(real x) { return M_DRIVER(sin)(x); }
static inline real m_cos(real x) { return M_DRIVER(cos)(x); }
static inline real m_tan(real x) { return M_DRIVER(tan)(x); }
static inline real m_asin(real x) { return asin(x); }
static inline real m_acos(real x) { return acos(x); }
static inline real m_atan(real x) { return atan(x); }
static inline real m_atan2(real y, real x) { return atan2(y, x); }
static inline real m_sinh(real x) { return sinh(x); }
static inline real m_cosh(real x) { return cosh(x); }
static inline real m_tanh(real x) { return tanh(x); }
static inline real m_exp(real x) { return M_DRIVER(exp)(x); }
static inline real m_exp2(real x) { return M_DRIVER(exp2)(x); }
static inline real m_expm1(real x) { return expm1(x); }
static inline real m_log(real x) { return M_DRIVER(log)(x); }
static inline real m_log2(real x) { return M_DRIVER(log2)(x); }
static inline real m_log10(real x) { return M_DRIVER(log10)(x); }
static inline real m_powr(real x, real y) { return M_DRIVER(powr)(x, y); }
static inline real m_cbrt(real x) { return cbrt(x); }
static inline real m_erf(real x) { return erf(x); }
static inline real m_erfc(real x) { return erfc(x); }

static inline void m_sincos(real x, real *s, real *c) {
    *s = M_DRIVER(sin)(x);
    *c = M_DRIVER(cos)(x);
}

#else

// ---- Trigonometry ---------------------------------------------------------------------------------------------------

// 2/pi in binary after the point, a word of zeros first.
__constant uint M_TWO_OVER_PI[8] = {0u,          0xa2f9836eu, 0x4e441529u, 0xfc2757d1u,
                                    0xf534ddc0u, 0xdb629599u, 0x3c439041u, 0xfe5163abu};

// What is seldom called must not keep its callers from being inlined: that is a fifth of a procedural material's time on PoCL.
#if defined(OSLCL_FAST) && !defined(__NV_CL_C_VERSION)
#define M_SELDOM static __attribute__((noinline))
#else
#define M_SELDOM static inline
#endif

// x modulo pi/2 for |x| >= 2^16 (Payne and Hanek): the mantissa times those 96 bits of 2/pi whose products are neither
// multiples of 4 nor below the precision. Infinities and NaN give NaN.
M_SELDOM float m_reduce_large(float x, int *quadrant) {
    uint bits = as_uint(x);
    int exponent = (int)((bits >> 23) & 255u) - 150;
    ulong mantissa = (bits & 0x7fffffu) | 0x800000u;
    uint offset = (uint)clamp(exponent + 30, 0, 135);
    uint word = offset >> 5, shift = offset & 31u;
    ulong w01 = ((ulong)M_TWO_OVER_PI[word] << 32) | M_TWO_OVER_PI[word + 1];
    ulong w12 = ((ulong)M_TWO_OVER_PI[word + 1] << 32) | M_TWO_OVER_PI[word + 2];
    ulong w23 = ((ulong)M_TWO_OVER_PI[word + 2] << 32) | M_TWO_OVER_PI[word + 3];
    ulong low = mantissa * (uint)(w23 >> (32u - shift));
    ulong mid = mantissa * (uint)(w12 >> (32u - shift)) + (low >> 32);
    ulong high = mantissa * (uint)(w01 >> (32u - shift)) + (mid >> 32);
    ulong turns = (high << 32) | (mid & 0xffffffffu); // 2 bits of quadrant, then the fraction of pi/2
    long fraction = (long)(turns << 2);
    int q = (int)(turns >> 62) + (fraction < 0);
    float r = (float)fraction * 8.51530395021638637e-20; // pi/2 / 2^64
    int negative = as_int(x) < 0;
    *quadrant = negative ? -q : q;
    r = negative ? -r : r;
    return exponent == 105 ? x - x : r;
}

#ifdef OSLCL_FAST
#include "maths_fast.h"
#else
// x = quadrant * pi/2 + result, |result| <= pi/4.
static inline float m_reduce(float x, int *quadrant) {
    if (!(fabs(x) < 1e5)) return m_reduce_large(x, quadrant);
    float n = rint(x * 0.636619772);
    float r = fma(-n, 1.570796371, x); // pi/2 in three parts
    r = fma(-n, -4.371138829e-08, r);
    r = fma(-n, -1.715124510e-15, r);
    *quadrant = (int)n;
    return r;
}

// Sine and cosine of |r| <= pi/4, then turned by quadrants.
static inline void m_sincos_reduced(float r, int quadrant, float *s, float *c) {
    float z = r * r;
    float ps = fma(fma(2.832765631e-06, z, -1.985307463e-04), z, 8.333379403e-03);
    ps = fma(r * z, fma(ps, z, -1.666666716e-01), r);
    float pc = fma(fma(-2.888089341e-07, z, 2.482202035e-05), z, -1.388898003e-03);
    pc = fma(z * z, fma(pc, z, 4.166666791e-02), fma(z, -0.5, 1.0));
    float a = quadrant & 1 ? pc : ps;
    float b = quadrant & 1 ? ps : pc;
    *s = as_float(as_int(a) ^ ((quadrant & 2) << 30));
    *c = as_float(as_int(b) ^ (((quadrant + 1) & 2) << 30));
}

static inline void m_sincos(float x, float *s, float *c) {
    int quadrant;
    float r = m_reduce(x, &quadrant);
    m_sincos_reduced(r, quadrant, s, c);
}

static inline float m_sin(float x) {
    float s, c;
    m_sincos(x, &s, &c);
    return s;
}

static inline float m_cos(float x) {
    float s, c;
    m_sincos(x, &s, &c);
    return c;
}

static inline float m_tan(float x) {
    int quadrant;
    float r = m_reduce(x, &quadrant);
    float z = r * r;
    float p = fma(fma(4.372327123e-03, z, 9.885210602e-05), z, 1.082708780e-02);
    p = fma(fma(p, z, 2.128629573e-02), z, 5.405890569e-02);
    p = fma(fma(p, z, 1.333267540e-01), z, 3.333334923e-01);
    p = fma(r * z, p, r);
    return quadrant & 1 ? -1 / p : p;
}

// Arc tangent of 0 <= t <= 1.
static inline float m_atan_reduced(float t) {
    float z = t * t;
    float p = fma(fma(-1.787576475e-03, z, 1.088747941e-02), z, -3.112718835e-02);
    p = fma(fma(p, z, 5.790668726e-02), z, -8.400480449e-02);
    p = fma(fma(p, z, 1.095117554e-01), z, -1.426405162e-01);
    p = fma(fma(p, z, 1.999853104e-01), z, -3.333329856e-01);
    return fma(t * z, p, t);
}
#endif

static inline float m_atan(float x) {
    float a = fabs(x);
    float p = m_atan_reduced(a > 1 ? 1 / a : a);
    return copysign(a > 1 ? 1.570796371 - (p + 4.371138829e-08) : p, x);
}

static inline float m_atan2(float y, float x) {
    float ax = fabs(x), ay = fabs(y);
    float small = fmin(ax, ay), large = fmax(ax, ay);
    float p = m_atan_reduced(large == 0 ? 0 : (small == large ? 1 : small / large));
    p = ay > ax ? 1.570796371 - (p + 4.371138829e-08) : p;
    p = as_int(x) < 0 ? 3.141592741 - (p + 8.742277657e-08) : p;
    return x != x || y != y ? x + y : copysign(p, y);
}

// For 0 <= a <= 1: asin(a) for a <= 1/2, else asin(sqrt((1 - a) / 2)). NaN beyond 1.
static inline float m_asin_reduced(float a) {
    float z = a > 0.5 ? fma(a, -0.5, 0.5) : a * a;
    float s = a > 0.5 ? sqrt(z) : a;
    float p = fma(fma(fma(3.769236431e-02, z, 1.431668829e-02), z, 3.183886781e-02), z, 4.451338202e-02);
    p = fma(fma(p, z, 7.500521839e-02), z, 1.666665971e-01);
    return fma(s * z, p, s);
}

static inline float m_asin(float x) {
    float a = fabs(x);
    float p = m_asin_reduced(a);
    return copysign(a > 0.5 ? 1.570796371 - fma(p, 2.0, 4.371138829e-08) : p, x);
}

static inline float m_acos(float x) {
    float a = fabs(x);
    float p = m_asin_reduced(a);
    float far = x < 0 ? 3.141592741 - fma(p, 2.0, 8.742277657e-08) : 2 * p;
    float near = 1.570796371 - (copysign(p, x) + 4.371138829e-08);
    return a > 0.5 ? far : near;
}

// ---- Exponentials ---------------------------------------------------------------------------------------------------

// x * 2^n for |n| <= 252, rounded once: overflow and denormal results come out right.
static inline float m_scale(float x, int n) {
    int half_n = n >> 1;
    return x * as_float((half_n + 127) << 23) * as_float((n - half_n + 127) << 23);
}

// exp(x) = 2^n * (1 + result).
static inline float m_exp_reduced(float x, int *n) {
    float k = rint(x * 1.442695022);
    float r = fma(-k, 6.931471825e-01, x); // ln 2 in two parts
    r = fma(-k, -1.904654212e-09, r);
    float p = fma(fma(fma(1.389957615e-03, r, 8.366126567e-03), r, 4.166683927e-02), r, 1.666654795e-01);
    *n = (int)k;
    return fma(r * r, fma(p, r, 0.5), r);
}

#ifndef OSLCL_FAST
static inline float m_exp(float x) {
    int n;
    x = x > 89 ? 89 : (x < -104.5 ? -104.5 : x);
    float p = m_exp_reduced(x, &n);
    return m_scale(p + 1, n);
}
#endif

static inline float m_expm1(float x) {
    int n;
    float c = x > 89 ? 89 : (x < -20 ? -20 : x);
    float p = m_exp_reduced(c, &n);
    float s = as_float((n + 126) << 23); // 2^(n-1): 2^n itself may overflow
    float r = 2 * fma(s, p, s - 0.5);
    return n == 0 ? p : r;
}

#ifndef OSLCL_FAST
// 2^(x + low).
static inline float m_exp2_sum(float x, float low) {
    x = x > 129 ? 129 : (x < -151 ? -151 : x);
    float k = rint(x);
    float r = (x - k) + low;
    float p = fma(fma(1.432618137e-05, r, 1.545218547e-04), r, 1.333795721e-03);
    p = fma(fma(fma(p, r, 9.618086740e-03), r, 5.550405011e-02), r, 2.402265072e-01);
    return m_scale(fma(fma(p, r, 6.931471825e-01), r, 1.0), (int)k);
}

static inline float m_exp2(float x) { return m_exp2_sum(x, 0); }
#endif

static inline float m_sinh(float x) {
    float a = fabs(x);
    float e = m_expm1(a), h = m_exp(0.5 * a);
    return copysign(a > 40 ? 0.5 * h * h : 0.5 * (e + e / (e + 1)), x);
}

static inline float m_cosh(float x) {
    float a = fabs(x);
    float e = m_exp(a), h = m_exp(0.5 * a);
    return a > 40 ? 0.5 * h * h : fma(0.5, e, 0.5 / e);
}

static inline float m_tanh(float x) {
    float a = fabs(x);
    float e = m_expm1(2 * (a > 10 ? 10 : a));
    return copysign(a > 0.5 ? 1 - 2 / (e + 2) : e / (e + 2), x);
}

// ---- Logarithms -----------------------------------------------------------------------------------------------------

#ifndef OSLCL_FAST

// x = 2^result * (1 + f), 1 + f in [sqrt(1/2), sqrt(2)); for positive finite x.
static inline float m_split_log(float x, float *f) {
    int tiny = x < 1.17549435e-38;
    int bits = as_int(tiny ? x * 8388608 : x);
    int k = (bits - 0x3f3504f3) >> 23;
    *f = as_float(bits - (k << 23)) - 1;
    return (float)(tiny ? k - 23 : k);
}

// log(1 + f) = f + result.
static inline float m_log1p_tail(float f) {
    float p = fma(fma(6.750237197e-02, f, -1.167135015e-01), f, 1.188380495e-01);
    p = fma(fma(p, f, -1.240608171e-01), f, 1.422031373e-01);
    p = fma(fma(p, f, -1.666799337e-01), f, 2.000207305e-01);
    p = fma(fma(p, f, -2.500000894e-01), f, 3.333331347e-01);
    float z = f * f;
    return fma(f * z, p, -0.5 * z);
}

// What any logarithm gives where the reduction has no meaning.
static inline float m_log_edges(float x, float r) {
    r = x == INFINITY || x != x ? x : r;
    return x > 0 || x != x ? r : (x == 0 ? -INFINITY : NAN);
}

static inline float m_log(float x) {
    float f;
    float k = m_split_log(x, &f);
    float t = m_log1p_tail(f);
    return m_log_edges(x, fma(k, 6.931471825e-01, fma(k, -1.904654212e-09, t) + f));
}

static inline float m_log2(float x) {
    float f;
    float k = m_split_log(x, &f);
    float t = m_log1p_tail(f);
    float r = f + t;
    float low = fma(r, 1.925963034e-08, (t - (r - f)) * 1.442695022);
    return m_log_edges(x, k + fma(r, 1.442695022, low));
}

static inline float m_log10(float x) {
    float f;
    float k = m_split_log(x, &f);
    float t = m_log1p_tail(f);
    float r = f + t;
    float low = fma(r, -1.010304995e-08, (t - (r - f)) * 4.342944920e-01);
    low = fma(k, -1.432098884e-08, low);
    return m_log_edges(x, fma(k, 3.010300100e-01, fma(r, 4.342944920e-01, low)));
}

// x to the y for positive, normal, finite x. log2 x is kept in two floats: an error in it is multiplied by up to 128.
static inline float m_powr(float x, float y) {
    float f;
    float k = m_split_log(x, &f);
    // f / (2 + f) in two floats: log2(1 + f) = 2/ln2 * atanh(f / (2 + f)).
    float d = f + 2;
    float d_low = f - (d - 2);
    float inverse = 1 / d;
    float s = f * inverse;
    float s_low = fma(-s, d_low, fma(-s, d, f)) * inverse;
    float z = s * s;
    float p = fma(fma(fma(3.366146088e-01, z, 4.119217098e-01), z, 5.770788789e-01), z, 9.617967010e-01);
    float h = s * 2.885390043;
    float h_low = fma(s, 2.885390043, -h) + fma(s_low, 2.885390043, fma(s, 3.851926067e-08, s * z * p));
    float g = k + h;
    float g_low = (h - (g - k)) + h_low;
    float l = g + g_low;
    float l_low = g_low - (l - g);
    float e = y * l;
    float e_low = fma(y, l, -e) + y * l_low;
    return m_exp2_sum(e, fabs(e) < 200 ? e_low : 0);
}
#endif

// ---- Others ---------------------------------------------------------------------------------------------------------

// A guess by dividing the exponent by three, a step of Halley's iteration and one of Newton's.
static inline float m_cbrt(float x) {
    float a = fabs(x);
    int tiny = a < 1e-30, huge = a > 1e30;
    float v = a * (tiny ? 16777216 : (huge ? 5.9604644775390625e-08 : 1)); // 2^24, 2^-24
    float y = as_float(as_int(v) / 3 + 0x2a5137a0);
    float c = y * y * y;
    y = y * ((c + 2 * v) / (2 * c + v));
    float q = y * y;
    float excess = fma(q, y, -v) + fma(y, y, -q) * y; // y^3 - v
    y = y - excess / (3 * q);
    y = y * (tiny ? 0.00390625 : (huge ? 256 : 1));
    return a == 0 || a == INFINITY || x != x ? x : copysign(y, x);
}

// erfc(a) for a >= 1/2: exp(-a^2) / (1 + 2a) * p((a - 2) / (a + 2)), a^2 in two floats.
static inline float m_erfc_tail(float a) {
    a = a > 11 ? 11 : a;
    float t = (a - 2) / (a + 2);
    float p = fma(fma(fma(-2.359452192e-04, t, -1.287069288e-03), t, 1.163656241e-03), t, 8.677117527e-03);
    p = fma(fma(fma(p, t, -8.013643324e-03), t, -5.421622097e-02), t, 1.640500575e-01);
    p = fma(fma(fma(p, t, -1.660303324e-01), t, -9.276382625e-02), t, 1.276978374);
    float q = a * a;
    float q_low = fma(a, a, -q);
    p = p / fma(2.0, a, 1.0);
    return m_exp(-q) * fma(p, -q_low, p);
}

// erf(a) for |a| <= 1/2.
static inline float m_erf_head(float a) {
    float z = a * a;
    float p = fma(fma(-6.766452570e-04, z, 5.123584997e-03), z, -2.684041113e-02);
    p = fma(fma(p, z, 1.128349304e-01), z, -3.761262596e-01);
    return fma(a, fma(p, z, 1.283791661e-01), a);
}

static inline float m_erf(float x) {
    float a = fabs(x);
    return a <= 0.5 ? m_erf_head(x) : copysign(1 - m_erfc_tail(a), x);
}

static inline float m_erfc(float x) {
    float a = fabs(x);
    float t = m_erfc_tail(a);
    return a <= 0.5 ? 1 - m_erf_head(x) : (x < 0 ? 2 - t : t);
}

#endif

// Sine and cosine of u turns (2 pi u): for angles drawn from random numbers, cheaper and closer than m_sincos.
static inline void m_sincos_turns(real u, real *s, real *c) {
#ifdef OSLCL_DRIVER_MATH
    m_sincos(2 * PI * u, s, c);
#else
    float n = rint(4 * u);
    m_sincos_reduced(fma(n, -0.25, u) * (2 * PI), (int)n, s, c);
#endif
}

#endif
