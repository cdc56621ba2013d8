// What the kinds of noise share: lattice cells, periods, and lane-wise helpers for 4 and 8 lattice corners at a time.
//
// Conventions of all noise files: functions are named by coordinates (f, ff, v, vf: 1 to 4 dimensions) and result (f, or
// v: three values that do not depend on each other); periodic forms take the periods after the coordinates.
// The fraction of a coordinate is x - floor(x) for every x, so far away noise is bounded and constant; beyond the range
// of int the cell is whatever the device's conversion gives. A NaN or infinite coordinate gives NaN (cell and hash
// noise: some value in [0, 1]).
// No function branches: the corners of a cell are hashed and interpolated as one vector.
#ifndef OSLCL_OSL_NOISE_H
#define OSLCL_OSL_NOISE_H

#include "real.h"
#include "osl/hash.h"

#ifdef OSLCL_F64
// cond ? a : b per lane; cond is all ones or zero.
#define NOISE_PICK4(cond, a, b) select(b, a, convert_long4(cond))
#define NOISE_PICK8(cond, a, b) select(b, a, convert_long8(cond))
// x negated in the lanes where the top bit of s is set.
#define NOISE_FLIP(x, s) as_double(as_ulong(x) ^ ((ulong)((s) & 0x80000000u) << 32))
#define NOISE_FLIP4(x, s) as_double4(as_ulong4(x) ^ (convert_ulong4((s) & 0x80000000u) << 32))
#define NOISE_FLIP8(x, s) as_double8(as_ulong8(x) ^ (convert_ulong8((s) & 0x80000000u) << 32))
#define NOISE_REAL4(x) convert_double4(x)
#define NOISE_REAL8(x) convert_double8(x)
typedef double8 real8;
#else
#define NOISE_PICK4(cond, a, b) select(b, a, cond)
#define NOISE_PICK8(cond, a, b) select(b, a, cond)
#define NOISE_FLIP(x, s) as_float(as_uint(x) ^ ((s) & 0x80000000u))
#define NOISE_FLIP4(x, s) as_float4(as_uint4(x) ^ ((s) & 0x80000000u))
#define NOISE_FLIP8(x, s) as_float8(as_uint8(x) ^ ((s) & 0x80000000u))
#define NOISE_REAL4(x) convert_float4(x)
#define NOISE_REAL8(x) convert_float8(x)
typedef float8 real8;
#endif

// The lattice cell of x: its number and the next one's, and the fraction of x in it.
typedef struct {
    uint lower, upper;
    real fraction;
} NoiseCell;

static inline NoiseCell noise_cell(real x) {
    real f = floor(x);
    NoiseCell cell;
    cell.lower = (uint)(int)f;
    cell.upper = cell.lower + 1u;
    // Within the cell even where a compiler with relaxed rules subtracts f from x before it rounds x.
    cell.fraction = clamp(x - f, (real)0, (real)1);
    return cell;
}

// The same with cell numbers modulo the period, which is floor(period), at least 1.
static inline NoiseCell noise_cell_periodic(real x, real period) {
    NoiseCell cell = noise_cell(x);
    int p = period >= 1 ? (int)period : 1;
    int m = (int)cell.lower % p;
    m = m < 0 ? m + p : m;
    cell.lower = (uint)m;
    cell.upper = (uint)(m + 1 == p ? 0 : m + 1);
    return cell;
}

// 32 random bits to [0, 1].
static inline real noise_unit(uint bits) { return (real)bits * (1 / 4294967295.0); }

// Perlin's interpolation weight, 2002: zero first and second derivative at 0 and 1.
static inline real noise_fade(real t) { return t * t * t * (t * (t * 6 - 15) + 10); }

// Lanes of a cell's corners, x fastest, to the point (u, v, w).
static inline real noise_lerp(real a, real b, real t) { return (1 - t) * a + t * b; }

static inline real noise_lerp4(real4 g, real u, real v) {
    real2 x = (1 - v) * g.lo + v * g.hi;
    return noise_lerp(x.x, x.y, u);
}

static inline real noise_lerp8(real8 g, real u, real v, real w) { return noise_lerp4((1 - w) * g.lo + w * g.hi, u, v); }

#endif
