// The working precision. Every kernel is written over `real`; the host picks it:
//   f32: -cl-single-precision-constant (literals carry no suffix)
//   f64: -D OSLCL_F64
// Buffers hold reals tightly packed: triples are read and written with vload3/vstore3 (load_real3, store_real3).
#ifndef OSLCL_REAL_H
#define OSLCL_REAL_H

// Products are rounded before they are added, but where fma says otherwise: whether a compiler contracts them depends on what else is
// in a kernel, and then an effect that a scene doesn't need would change its bits. On an H100 that costs r1 3 %, r2 and the gallery
// less than 1 %.
#ifndef OSLCL_FAST
#pragma OPENCL FP_CONTRACT OFF
#endif

#ifdef OSLCL_F64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
typedef double2 real2;
typedef double3 real3;
typedef double4 real4;
typedef long real_bits;
#define convert_real(x) convert_double(x)
#define convert_real3(x) convert_double3(x)
#define convert_real4(x) convert_double4(x)
#define as_real_bits(x) as_long(x)
#define REAL_MAX DBL_MAX
#define REAL_EPSILON DBL_EPSILON
#else
typedef float real;
typedef float2 real2;
typedef float3 real3;
typedef float4 real4;
typedef int real_bits;
#define convert_real(x) convert_float(x)
#define convert_real3(x) convert_float3(x)
#define convert_real4(x) convert_float4(x)
#define as_real_bits(x) as_int(x)
#define REAL_MAX FLT_MAX
#define REAL_EPSILON FLT_EPSILON
#endif

#define PI 3.14159265358979323846
#define INV_PI 0.31830988618379067154

// By its bits: relaxed arithmetic takes it for granted that a comparison with infinity holds. By their order, not by the exponent's
// alone, for which LLVM knows the question that is asked and answers it as relaxed arithmetic does.
#ifdef OSLCL_F64
static inline int is_finite_real(real x) { return (as_ulong(x) & 0x7fffffffffffffffUL) < 0x7ff0000000000000UL; }
#else
static inline int is_finite_real(real x) { return (as_uint(x) & 0x7fffffffu) < 0x7f800000u; }
#endif

static inline real3 load_real3(__global const real *p, size_t i) { return vload3(i, p); }
static inline void store_real3(real3 v, size_t i, __global real *p) { vstore3(v, i, p); }
static inline real3 make_real3(real x, real y, real z) { return (real3)(x, y, z); }
static inline real max_component(real3 v) { return fmax(v.x, fmax(v.y, v.z)); }
static inline int is_zero3(real3 v) { return v.x == 0 && v.y == 0 && v.z == 0; }

// Kernels that sample or evaluate lobes. Intel's compiler for CPUs spoils other lanes of its vectors where Beckmann's distribution
// stands in a branch (seen with 2026.22: values of 1e30 that differ from run to run): there they run lane by lane.
#ifdef OSLCL_LANE_BY_LANE
#define LOBE_KERNEL __attribute__((intel_vec_len_hint(1))) __kernel
#else
#define LOBE_KERNEL __kernel
#endif

#endif
