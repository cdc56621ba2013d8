// Elementary functions and guards that the lobes share.
// In: numbers of any kind. Out: finite numbers, or NaN only where every caller compares in a way that rejects NaN.
// It knows nothing of lobes.
#ifndef OSLCL_BSDF_NUMERIC_H
#define OSLCL_BSDF_NUMERIC_H

#include "maths.h"

// The largest number below 1: random numbers in [0,1) are kept there after they are rescaled.
#ifdef OSLCL_F64
#define ONE_MINUS_EPSILON 0.99999999999999988898
#else
#define ONE_MINUS_EPSILON 0.99999994
#endif

// Below this a series of five terms has more digits than the function of 1 - x.
#ifdef OSLCL_F64
#define SERIES_BELOW 1e-3
#else
#define SERIES_BELOW 0.02
#endif

static inline real sqr(real x) { return x * x; }
static inline real safe_sqrt(real x) { return sqrt(fmax(x, (real)0)); }
static inline int is_finite_positive(real x) { return x > 0 && is_finite_real(x); }

// The unit vector along v; zero for zero. Scaled first, so that neither 1e-30 nor 1e30 leaves the range of f32.
static inline real3 safe_normalize(real3 v)
{
    real m = max_component(fabs(v));
    if (!is_finite_positive(m)) return (real3)(0);
    v /= m;
    return v / sqrt(dot(v, v));
}

// 1 - exp(-x) for x >= 0, to all digits where x is small.
static inline real one_minus_exp(real x)
{
    if (!(x < (real)SERIES_BELOW)) return 1 - m_exp(-x);
    return x * (1 - x * ((real)0.5 - x * ((real)(1.0 / 6.0) - x * ((real)(1.0 / 24.0) - x * (real)(1.0 / 120.0)))));
}

// (1 - d)^n for d in [0, 1], n >= 0. Near the peak of a sharp lobe d is known to more digits than 1 - d is.
static inline real pow_one_minus(real d, real n)
{
    if (d >= 1) return n > 0 ? 0 : 1;
    real log1 = d < (real)SERIES_BELOW ? -d * (1 + d * ((real)0.5 + d * ((real)(1.0 / 3.0) + d * ((real)0.25 + d * (real)0.2))))
                               : m_log(1 - d);
    return m_exp(n * log1);
}

#endif
