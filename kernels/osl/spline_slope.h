// The slope of OSL's spline by its position, a function per basis: osl_spline_BASIS_slope_f_faf(x, knots, n).
//
// In: as the splines of osl/spline.h. Out: the derivative by x; 0 beyond [0, 1], where the curve is constant. The slope by a
// knot needs no function: splines are linear in their knots.
#ifndef OSLCL_OSL_SPLINE_SLOPE_H
#define OSLCL_OSL_SPLINE_SLOPE_H

#include "osl/spline.h"

static inline real osl_cubic_slope_f(real t, real p3, real p2, real p1, real p0) { return (3 * p3 * t + 2 * p2) * t + p1; }
static inline real3 osl_cubic_slope_v(real t, real3 p3, real3 p2, real3 p1, real3 p0)
{
    return (3 * p3 * t + 2 * p2) * t + p1;
}

// Two zeros keep linear like the cubics.
#define OSL_CUBIC_linear(a, b, c, d) 0 * a, 0 * d, c - b, b

#define OSL_SPLINE_SLOPE(BASIS, STEP, RET, TYPE)                                                                       \
    static inline TYPE osl_spline_##BASIS##_slope_##RET##_fa##RET(real x, const TYPE *knots, int n)                    \
    {                                                                                                                  \
        int first;                                                                                                     \
        real t = osl_spline_segment(x, n, STEP, &first);                                                               \
        TYPE a = knots[min(first, n - 1)], b = knots[min(first + 1, n - 1)];                                           \
        TYPE c = knots[min(first + 2, n - 1)], d = knots[min(first + 3, n - 1)];                                       \
        real segments = x >= 0 && x <= 1 ? max((n - 4) / STEP + 1, 1) : 0;                                             \
        return segments * osl_cubic_slope_##RET(t, OSL_CUBIC_##BASIS(a, b, c, d));                                     \
    }

OSL_SPLINE_SLOPE(catmullrom, 1, f, real)
OSL_SPLINE_SLOPE(catmullrom, 1, v, real3)
OSL_SPLINE_SLOPE(bezier, 3, f, real)
OSL_SPLINE_SLOPE(bezier, 3, v, real3)
OSL_SPLINE_SLOPE(bspline, 1, f, real)
OSL_SPLINE_SLOPE(bspline, 1, v, real3)
OSL_SPLINE_SLOPE(hermite, 2, f, real)
OSL_SPLINE_SLOPE(hermite, 2, v, real3)
OSL_SPLINE_SLOPE(linear, 1, f, real)
OSL_SPLINE_SLOPE(linear, 1, v, real3)

#endif
