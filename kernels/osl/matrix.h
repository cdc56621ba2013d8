// OSL's matrix: 4x4, row-major, for row vectors (p * M), so that translation stands in the last row.
#ifndef OSLCL_OSL_MATRIX_H
#define OSLCL_OSL_MATRIX_H

#include "real.h"

typedef struct {
    real m[16];
} mat4;

static inline mat4 make_mat4(real m00, real m01, real m02, real m03, real m10, real m11, real m12, real m13, real m20,
                             real m21, real m22, real m23, real m30, real m31, real m32, real m33)
{
    mat4 r = {{m00, m01, m02, m03, m10, m11, m12, m13, m20, m21, m22, m23, m30, m31, m32, m33}};
    return r;
}

// A float becomes the diagonal.
static inline mat4 op_matrix_f(real d)
{
    mat4 r = {{d, 0, 0, 0, 0, d, 0, 0, 0, 0, d, 0, 0, 0, 0, d}};
    return r;
}

// Matrix i of a table of reals.
static inline mat4 op_load_m(__constant const real *table, int i)
{
    mat4 r;
    for (int k = 0; k < 16; k++)
        r.m[k] = table[16 * i + k];
    return r;
}

// 16 slots of userdata, or of interactive parameters (ShaderGlobals).
static inline mat4 op_load_slots_m(const real *slots)
{
    mat4 r;
    for (int k = 0; k < 16; k++)
        r.m[k] = slots[k];
    return r;
}

static inline mat4 op_load_global_m(__global const real *slots)
{
    mat4 r;
    for (int k = 0; k < 16; k++)
        r.m[k] = slots[k];
    return r;
}

static inline mat4 op_neg_m(mat4 a)
{
    for (int k = 0; k < 16; k++)
        a.m[k] = -a.m[k];
    return a;
}

static inline int op_eq_m(mat4 a, mat4 b)
{
    int equal = 1;
    for (int k = 0; k < 16; k++)
        equal &= a.m[k] == b.m[k];
    return equal;
}

static inline mat4 op_select_m(int c, mat4 a, mat4 b)
{
    if (c)
        return a;
    return b;
}

// Element row, column, both clamped into 0..3.
static inline real op_get_m(mat4 a, int row, int column) { return a.m[4 * clamp(row, 0, 3) + clamp(column, 0, 3)]; }
static inline mat4 op_set_m(mat4 a, int row, int column, real x)
{
    a.m[4 * clamp(row, 0, 3) + clamp(column, 0, 3)] = x;
    return a;
}

static inline mat4 op_mul_m(mat4 a, mat4 b)
{
    mat4 r;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            r.m[4 * i + j] = a.m[4 * i] * b.m[j] + a.m[4 * i + 1] * b.m[4 + j] + a.m[4 * i + 2] * b.m[8 + j] +
                             a.m[4 * i + 3] * b.m[12 + j];
    return r;
}

// The 2x2 minors of rows 0, 1 (s) and rows 2, 3 (c): Laplace expansion along pairs of rows.
typedef struct {
    real s[6], c[6];
} Minors4;

static inline Minors4 minors_m(mat4 a)
{
    const real *m = a.m;
    Minors4 r = {{m[0] * m[5] - m[4] * m[1], m[0] * m[6] - m[4] * m[2], m[0] * m[7] - m[4] * m[3],
                  m[1] * m[6] - m[5] * m[2], m[1] * m[7] - m[5] * m[3], m[2] * m[7] - m[6] * m[3]},
                 {m[8] * m[13] - m[12] * m[9], m[8] * m[14] - m[12] * m[10], m[8] * m[15] - m[12] * m[11],
                  m[9] * m[14] - m[13] * m[10], m[9] * m[15] - m[13] * m[11], m[10] * m[15] - m[14] * m[11]}};
    return r;
}

static inline real det_of_minors(Minors4 n)
{
    return n.s[0] * n.c[5] - n.s[1] * n.c[4] + n.s[2] * n.c[3] + n.s[3] * n.c[2] - n.s[4] * n.c[1] + n.s[5] * n.c[0];
}

static inline real osl_determinant_f_m(mat4 a) { return det_of_minors(minors_m(a)); }

// The inverse; of a singular matrix the identity, as in the reference implementation.
static inline mat4 op_inverse_m(mat4 a)
{
    Minors4 n = minors_m(a);
    real det = det_of_minors(n);
    real d = 1 / det;
    if (det == 0 || !(fabs(d) <= FLT_MAX))
        return op_matrix_f(1);
    const real *m = a.m, *s = n.s, *c = n.c;
    return make_mat4((m[5] * c[5] - m[6] * c[4] + m[7] * c[3]) * d, (-m[1] * c[5] + m[2] * c[4] - m[3] * c[3]) * d,
                     (m[13] * s[5] - m[14] * s[4] + m[15] * s[3]) * d, (-m[9] * s[5] + m[10] * s[4] - m[11] * s[3]) * d,
                     (-m[4] * c[5] + m[6] * c[2] - m[7] * c[1]) * d, (m[0] * c[5] - m[2] * c[2] + m[3] * c[1]) * d,
                     (-m[12] * s[5] + m[14] * s[2] - m[15] * s[1]) * d, (m[8] * s[5] - m[10] * s[2] + m[11] * s[1]) * d,
                     (m[4] * c[4] - m[5] * c[2] + m[7] * c[0]) * d, (-m[0] * c[4] + m[1] * c[2] - m[3] * c[0]) * d,
                     (m[12] * s[4] - m[13] * s[2] + m[15] * s[0]) * d, (-m[8] * s[4] + m[9] * s[2] - m[11] * s[0]) * d,
                     (-m[4] * c[3] + m[5] * c[1] - m[6] * c[0]) * d, (m[0] * c[3] - m[1] * c[1] + m[2] * c[0]) * d,
                     (-m[12] * s[3] + m[13] * s[1] - m[14] * s[0]) * d, (m[8] * s[3] - m[9] * s[1] + m[10] * s[0]) * d);
}

static inline mat4 op_div_m(mat4 a, mat4 b) { return op_mul_m(a, op_inverse_m(b)); }

static inline mat4 osl_transpose_m_m(mat4 a)
{
    mat4 r;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            r.m[4 * i + j] = a.m[4 * j + i];
    return r;
}

// p * M without the translation.
static inline real3 osl_transform_vector_v_mv(mat4 a, real3 v)
{
    const real *m = a.m;
    return (real3)(v.x * m[0] + v.y * m[4] + v.z * m[8], v.x * m[1] + v.y * m[5] + v.z * m[9],
                   v.x * m[2] + v.y * m[6] + v.z * m[10]);
}

// p * M, divided by w; a point at infinity becomes zero.
static inline real3 osl_transform_point_v_mv(mat4 a, real3 p)
{
    const real *m = a.m;
    real w = p.x * m[3] + p.y * m[7] + p.z * m[11] + m[15];
    if (w == 0)
        return (real3)(0);
    return (osl_transform_vector_v_mv(a, p) + (real3)(m[12], m[13], m[14])) / w;
}

// Normals go through the transposed inverse.
static inline real3 osl_transform_normal_v_mv(mat4 a, real3 n)
{
    return osl_transform_vector_v_mv(osl_transpose_m_m(op_inverse_m(a)), n);
}

#endif
