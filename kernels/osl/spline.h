// OSL's spline and splineinverse, a function per basis (specification ch. 7.6): osl_spline_BASIS_f_faf(x, knots, n).
//
// In: knots in private memory and their number; x in [0, 1] is clamped. Out: the value. With fewer knots than the basis
// needs the last one repeats, so that nothing is read out of bounds. The forms `_fiaf` and `_fiav` take the first so many
// knots, at least one and at most all.
// The bases are the textbook ones (Foley, van Dam et al. 1990, ch. 11.2): a cubic through four knots from every
// `STEP`th knot on; linear and constant keep the outer knots for the sake of exchanging the basis.
#ifndef OSLCL_OSL_SPLINE_H
#define OSLCL_OSL_SPLINE_H

#include "osl/math.h"

// Splits x over the segments: the first knot of its segment, and the fraction in it.
static inline real osl_spline_segment(real x, int n, int step, int *first) {
    int segments = max((n - 4) / step + 1, 1);
    real t = osl_clamp_f_fff(x, 0, 1) * segments;
    int segment = clamp((int)t, 0, segments - 1);
    *first = segment * step;
    return t - segment;
}

// The cubic's coefficients by descending power, for knots a b c d.
#define OSL_CUBIC_catmullrom(a, b, c, d)                                                                               \
    0.5 * (-a + 3 * b - 3 * c + d), a - 2.5 * b + 2 * c - 0.5 * d, 0.5 * (c - a), b
#define OSL_CUBIC_bezier(a, b, c, d) -a + 3 * b - 3 * c + d, 3 * a - 6 * b + 3 * c, 3 * (b - a), a
#define OSL_CUBIC_bspline(a, b, c, d)                                                                                  \
    (-a + 3 * b - 3 * c + d) / 6, 0.5 * a - b + 0.5 * c, 0.5 * (c - a), (a + 4 * b + c) / 6
// Knots: value, slope, value, slope.
#define OSL_CUBIC_hermite(a, b, c, d) 2 * a + b - 2 * c + d, -3 * a - 2 * b + 3 * c - d, b, a

static inline real osl_cubic_f(real t, real p3, real p2, real p1, real p0) { return ((p3 * t + p2) * t + p1) * t + p0; }
static inline real3 osl_cubic_v(real t, real3 p3, real3 p2, real3 p1, real3 p0) {
    return ((p3 * t + p2) * t + p1) * t + p0;
}

#define OSL_SPLINE_CUBIC(BASIS, STEP, RET, TYPE)                                                                       \
    static inline TYPE osl_spline_##BASIS##_##RET##_fa##RET(real x, const TYPE *knots, int n) {                        \
        int first;                                                                                                     \
        real t = osl_spline_segment(x, n, STEP, &first);                                                               \
        TYPE a = knots[min(first, n - 1)], b = knots[min(first + 1, n - 1)];                                           \
        TYPE c = knots[min(first + 2, n - 1)], d = knots[min(first + 3, n - 1)];                                       \
        return osl_cubic_##RET(t, OSL_CUBIC_##BASIS(a, b, c, d));                                                      \
    }

// The first `count` knots only.
#define OSL_SPLINE_COUNTED(BASIS)                                                                                      \
    static inline real osl_spline_##BASIS##_f_fiaf(real x, int count, const real *knots, int n) {                      \
        return osl_spline_##BASIS##_f_faf(x, knots, clamp(count, 1, n));                                               \
    }                                                                                                                  \
    static inline real3 osl_spline_##BASIS##_v_fiav(real x, int count, const real3 *knots, int n) {                    \
        return osl_spline_##BASIS##_v_fav(x, knots, clamp(count, 1, n));                                               \
    }

#define OSL_SPLINE_FLAT(RET, TYPE)                                                                                     \
    static inline TYPE osl_spline_linear_##RET##_fa##RET(real x, const TYPE *knots, int n) {                           \
        int first;                                                                                                     \
        real t = osl_spline_segment(x, n, 1, &first);                                                                  \
        TYPE a = knots[min(first + 1, n - 1)], b = knots[min(first + 2, n - 1)];                                       \
        return a + (b - a) * t;                                                                                        \
    }                                                                                                                  \
    static inline TYPE osl_spline_constant_##RET##_fa##RET(real x, const TYPE *knots, int n) {                         \
        int first;                                                                                                     \
        osl_spline_segment(x, n, 1, &first);                                                                           \
        return knots[min(first + 1, n - 1)];                                                                           \
    }

OSL_SPLINE_CUBIC(catmullrom, 1, f, real)
OSL_SPLINE_CUBIC(catmullrom, 1, v, real3)
OSL_SPLINE_CUBIC(bezier, 3, f, real)
OSL_SPLINE_CUBIC(bezier, 3, v, real3)
OSL_SPLINE_CUBIC(bspline, 1, f, real)
OSL_SPLINE_CUBIC(bspline, 1, v, real3)
OSL_SPLINE_CUBIC(hermite, 2, f, real)
OSL_SPLINE_CUBIC(hermite, 2, v, real3)
OSL_SPLINE_FLAT(f, real)
OSL_SPLINE_FLAT(v, real3)

OSL_SPLINE_COUNTED(catmullrom)
OSL_SPLINE_COUNTED(bezier)
OSL_SPLINE_COUNTED(bspline)
OSL_SPLINE_COUNTED(hermite)
OSL_SPLINE_COUNTED(linear)
OSL_SPLINE_COUNTED(constant)

// Solves spline(x) = y for monotonic knots: 0 or 1 beyond the ends; else in the first segment whose ends bracket y. Where
// no segment does (the curve overshoots), the last segment's nearer end. The steps are those of the reference's library
// (OpenImageIO's `invert`), so that values agree where the tolerance leaves a choice: false position 24 times, then
// halving 8 times, until x or y is within the tolerance.
#define OSL_SPLINE_INVERSE(BASIS, STEP)                                                                                \
    static inline real osl_splineinverse_##BASIS##_f_faf(real y, const real *knots, int n) {                           \
        int low = min(STEP == 1 ? 1 : 0, n - 1), high = max(STEP == 1 ? n - 2 : n - 1, 0);                             \
        real sign = knots[min(1, n - 1)] < knots[max(n - 2, 0)] ? 1 : -1;                                              \
        if (sign * y <= sign * knots[low]) return 0;                                                                   \
        if (sign * y >= sign * knots[high]) return 1;                                                                  \
        int segments = max((n - 4) / STEP + 1, 1);                                                                     \
        real width = (real)1 / segments;                                                                               \
        real x = 0, start = 0;                                                                                         \
        for (int s = 0; s < segments; ++s) {                                                                           \
            real x0 = start, x1 = width * (s + 1);                                                                     \
            real v0 = osl_spline_##BASIS##_f_faf(x0, knots, n), v1 = osl_spline_##BASIS##_f_faf(x1, knots, n);         \
            int rising = v0 < v1;                                                                                      \
            real least = rising ? v0 : v1, most = rising ? v1 : v0;                                                    \
            start = x1;                                                                                                \
            if (!(y >= least && y <= most)) {                                                                          \
                x = (y < least) == rising ? x0 : x1;                                                                   \
                continue;                                                                                              \
            }                                                                                                          \
            if (fabs(v0 - v1) < OSL_SPLINE_TOLERANCE) return x0;                                                       \
            for (int i = 0; i < 32; ++i) {                                                                             \
                real t = (y - v0) / (v1 - v0);                                                                         \
                t = i < 24 && t > 0 && t < 1 ? t : 0.5;                                                                \
                x = x0 * (1 - t) + x1 * t;                                                                             \
                real v = osl_spline_##BASIS##_f_faf(x, knots, n);                                                      \
                if ((v < y) == rising) x0 = x, v0 = v;                                                                 \
                else x1 = x, v1 = v;                                                                                   \
                if (fabs(x1 - x0) < OSL_SPLINE_TOLERANCE || fabs(v - y) < OSL_SPLINE_TOLERANCE) break;                 \
            }                                                                                                          \
            return x;                                                                                                  \
        }                                                                                                              \
        return x;                                                                                                      \
    }                                                                                                                  \
    static inline real osl_splineinverse_##BASIS##_f_fiaf(real y, int count, const real *knots, int n) {               \
        return osl_splineinverse_##BASIS##_f_faf(y, knots, clamp(count, 1, n));                                        \
    }

#define OSL_SPLINE_TOLERANCE 1e-6 // in x and in y

OSL_SPLINE_INVERSE(catmullrom, 1)
OSL_SPLINE_INVERSE(bezier, 3)
OSL_SPLINE_INVERSE(bspline, 1)
OSL_SPLINE_INVERSE(hermite, 2)
OSL_SPLINE_INVERSE(linear, 1)
OSL_SPLINE_INVERSE(constant, 1)

#endif
