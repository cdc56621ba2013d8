// OSL's operators where C's differ: ints wrap, bad divisions have a defined result, components are chosen by value.
// `op_NAME_T`, T the code of the operand's type (i f v m); the list stands in compiler/src/backend/opencl_c/mod.rs.
#ifndef OSLCL_OSL_OPS_H
#define OSLCL_OSL_OPS_H

#include "real.h"

// 32-bit two's complement (OSL specification ch. 5); signed overflow would be undefined in C.
static inline int op_add_i(int a, int b) { return as_int(as_uint(a) + as_uint(b)); }
static inline int op_sub_i(int a, int b) { return as_int(as_uint(a) - as_uint(b)); }
static inline int op_mul_i(int a, int b) { return as_int(as_uint(a) * as_uint(b)); }
static inline int op_neg_i(int a) { return as_int(0u - as_uint(a)); }
static inline int op_shl_i(int a, int b) { return as_int(as_uint(a) << (as_uint(b) & 31u)); }
static inline int op_shr_i(int a, int b) { return a >> (as_uint(b) & 31u); }

// x / 0 = 0 and x % 0 = 0; INT_MIN / -1 wraps, as negation does.
static inline int op_div_i(int a, int b)
{
    if (b == -1)
        return op_neg_i(a);
    return b == 0 ? 0 : a / b;
}
static inline int op_rem_i(int a, int b) { return b == 0 || b == -1 ? 0 : a % b; }

// A quotient that is no finite float is 0, as in the reference implementation; in f64 too, whose OSL has 32-bit floats as
// well. The test of b holds under relaxed maths, too.
static inline real op_div_f(real a, real b)
{
    real q = a / b;
    return b != 0 && fabs(q) <= FLT_MAX ? q : 0;
}
static inline real3 op_div_v(real3 a, real3 b)
{
    return (real3)(op_div_f(a.x, b.x), op_div_f(a.y, b.y), op_div_f(a.z, b.z));
}

// float -> int truncates; what no int holds, and NaN, is the smallest int, as on the processors that the reference implementation
// runs on.
static inline int op_int_f(real a) { return a >= -2147483648.0 && a < 2147483648.0 ? convert_int_rtz(a) : INT_MIN; }

static inline int op_eq_v(real3 a, real3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

// `c ? a : b` of vectors means something else in OpenCL C.
static inline real3 op_select_v(int c, real3 a, real3 b)
{
    if (c)
        return a;
    return b;
}

// Component i, clamped into 0..2.
static inline real op_get_v(real3 a, int i) { return i <= 0 ? a.x : i == 1 ? a.y : a.z; }
static inline real3 op_set_v(real3 a, int i, real x)
{
    if (i <= 0)
        a.x = x;
    else if (i == 1)
        a.y = x;
    else
        a.z = x;
    return a;
}

#endif
