// The slopes of a noise as a matrix: row j holds the derivatives of the result's components by coordinate j (x y z of a point,
// then t), so that a point's differences times the matrix are the result's.
//
// In: coordinates, and periods, as of the noise itself. Out: column 0 for a float result, columns 0 to 2 for a triple. The
// derivatives come from noise_perlin_d.h and noise_simplex_d.h.
#ifndef OSLCL_OSL_NOISE_SLOPES_H
#define OSLCL_OSL_NOISE_SLOPES_H

#include "osl/matrix.h"

static inline mat4 noise_slopes_f(real x, real y, real z, real t)
{
    mat4 r = op_matrix_f(0);
    r.m[0] = x;
    r.m[4] = y;
    r.m[8] = z;
    r.m[12] = t;
    return r;
}

static inline mat4 noise_slopes_v(real3 x, real3 y, real3 z, real3 t)
{
    return make_mat4(x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, t.x, t.y, t.z, 0);
}

// osl_NAME_ROW_m_ARGS from osl_NAME_R_ARGS_d. COUNT coordinates; PARAMS and GIVE: the arguments with and without types.
#define NOISE_SLOPES(NAME, ROW, R, TYPE, ARGS, PARAMS, GIVE, COUNT)                                                    \
    static inline mat4 osl_##NAME##_##ROW##_m_##ARGS PARAMS                                                            \
    {                                                                                                                  \
        TYPE x = (TYPE)(0), y = x, z = x, t = x;                                                                       \
        osl_##NAME##_##R##_##ARGS##_d(NOISE_SLOPES_LIST GIVE, NOISE_SLOPES_OUT_##COUNT);                               \
        return noise_slopes_##R(x, y, z, t);                                                                           \
    }
#define NOISE_SLOPES_LIST(...) __VA_ARGS__
#define NOISE_SLOPES_OUT_1 &x
#define NOISE_SLOPES_OUT_2 &x, &y
#define NOISE_SLOPES_OUT_3 &x, &y, &z
#define NOISE_SLOPES_OUT_4 &x, &y, &z, &t

// Of all coordinates' shapes, for float and triple results.
#define NOISE_SLOPES_PLAIN(NAME, ROW, R, TYPE)                                                                         \
    NOISE_SLOPES(NAME, ROW, R, TYPE, f, (real a), (a), 1)                                                              \
    NOISE_SLOPES(NAME, ROW, R, TYPE, ff, (real a, real b), (a, b), 2)                                                  \
    NOISE_SLOPES(NAME, ROW, R, TYPE, v, (real3 p), (p), 3)                                                             \
    NOISE_SLOPES(NAME, ROW, R, TYPE, vf, (real3 p, real b), (p, b), 4)
#define NOISE_SLOPES_PERIODIC(NAME, ROW, R, TYPE)                                                                      \
    NOISE_SLOPES(NAME, ROW, R, TYPE, ff, (real a, real pa), (a, pa), 1)                                                \
    NOISE_SLOPES(NAME, ROW, R, TYPE, ffff, (real a, real b, real pa, real pb), (a, b, pa, pb), 2)                      \
    NOISE_SLOPES(NAME, ROW, R, TYPE, vv, (real3 p, real3 pp), (p, pp), 3)                                              \
    NOISE_SLOPES(NAME, ROW, R, TYPE, vfvf, (real3 p, real b, real3 pp, real pb), (p, b, pp, pb), 4)

#endif
