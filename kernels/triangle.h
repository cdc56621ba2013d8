// A ray against a triangle, by the test that is chosen (docs/accuracy.md, `intersection`).
//
// In: triangles, a ray. Out: hits. It must not know trees or buffers.
//
// A triangle is three real4, so that each takes one load: its corners; the w of all three are its unit normal.
//   INTERSECTION_FAST  Moeller and Trumbore's test; what passes between two triangles may meet neither
//   INTERSECTION_F64   the watertight test in double, whatever real is
//   else               the watertight test
#ifndef OSLCL_TRIANGLE_H
#define OSLCL_TRIANGLE_H

#include "real.h"

typedef struct {
    real t, u, v;   // distance in units of the ray's direction; barycentric weights of corners 1 and 2
    uint triangle;  // index into the bottom levels' triangles
    uint instance;  // index of the instance; 0 is what needs no transform
#ifdef HAS_TRACE_SETS
    uint set;       // in: the number of the set of objects that count; 0: all do
#endif
} Hit;

// Corner 0, 1 or 2 of a triangle.
static inline real3 triangle_corner(__global const real4 *triangles, uint index, int corner)
{
    return triangles[3 * (size_t)index + corner].xyz;
}

#ifdef INTERSECTION_FAST

typedef struct {
    real3 d;
} TriangleRay;

static inline TriangleRay triangle_ray(real3 direction)
{
    const TriangleRay ray = {direction};
    return ray;
}

// Moeller and Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", J. Graphics Tools 2(1), 1997. Two triangles round the same
// edge in different ways, so that a ray at it may pass between them. Shortens *hit when the triangle is nearer.
static inline int meet_triangle(__global const real4 *triangles, uint index, real3 o, const TriangleRay *ray, Hit *hit)
{
    const real3 a = triangle_corner(triangles, index, 0);
    const real3 e1 = triangle_corner(triangles, index, 1) - a, e2 = triangle_corner(triangles, index, 2) - a;
    const real3 p = cross(ray->d, e2), s = o - a, q = cross(s, e1);
    const real det = dot(e1, p), size = fabs(det), sign = copysign((real)1, det);
    // As below: numbers times |det|.
    const real u = dot(s, p) * sign, v = dot(ray->d, q) * sign, t = dot(e2, q) * sign;
    if (!(u >= 0 && v >= 0 && u + v <= size && size > 0 && t > 0 && t < hit->t * size)) return 0;
    const real inverse = 1 / size;
    hit->t = t * inverse;
    hit->u = u * inverse;
    hit->v = v * inverse;
    hit->triangle = index;
    return 1;
}

#else

#if defined(INTERSECTION_F64) && !defined(OSLCL_F64)
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double exact;
typedef double3 exact3;
#define convert_exact3(v) convert_double3(v)
#else
typedef real exact;
typedef real3 exact3;
#define convert_exact3(v) (v)
#endif

// The map that turns a ray's direction to (0, 0, 1), as columns: it shears along the axis in which the direction is longest and
// leaves the others' numbers alone.
typedef struct {
    exact3 x, y, z;
} TriangleRay;

static inline TriangleRay triangle_ray(real3 direction)
{
    const exact3 d = convert_exact3(direction), a = fabs(d);
    TriangleRay s;
    if (a.z >= a.x && a.z >= a.y) {
        s.x = (exact3)(1, 0, 0);
        s.y = (exact3)(0, 1, 0);
        s.z = (exact3)(-d.x, -d.y, 1) / d.z;
    } else if (a.x >= a.y) {
        s.x = (exact3)(-d.y, -d.z, 1) / d.x;
        s.y = (exact3)(1, 0, 0);
        s.z = (exact3)(0, 1, 0);
    } else {
        s.x = (exact3)(0, 1, 0);
        s.y = (exact3)(-d.z, -d.x, 1) / d.y;
        s.z = (exact3)(1, 0, 0);
    }
    return s;
}

// By fma throughout: two triangles that share a corner have to find it in the same place, whatever the compiler contracts.
static inline exact3 shear(const TriangleRay *s, exact3 v)
{
    return fma((exact3)(v.x), s->x, fma((exact3)(v.y), s->y, v.z * s->z));
}

// a b - c d, of the right sign always, and 0 only if it is. Kahan's way; Jeannerod, Louvet and Muller, "Further Analysis of Kahan's
// Algorithm for the Accurate Computation of 2x2 Determinants", Math. Comp. 82, 2013: the error is below two units in the last place.
static inline exact3 difference_of_products(exact3 a, exact3 b, exact3 c, exact3 d)
{
    const exact3 cd = c * d;
    const exact3 lost = fma(-c, d, cd);
    return fma(a, b, -cd) + lost;
}

// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, with exact signs in the place of their second
// pass in double. A ray that passes an edge is on one side of it for both triangles; on it, it meets both. Shortens *hit when the
// triangle is nearer.
static inline int meet_triangle(__global const real4 *triangles, uint index, real3 o, const TriangleRay *ray, Hit *hit)
{
    const exact3 from = convert_exact3(o);
    const exact3 a = shear(ray, convert_exact3(triangle_corner(triangles, index, 0)) - from);
    const exact3 b = shear(ray, convert_exact3(triangle_corner(triangles, index, 1)) - from);
    const exact3 c = shear(ray, convert_exact3(triangle_corner(triangles, index, 2)) - from);
    // Twice the areas that the ray cuts off: the weights of the corners.
    exact3 w = difference_of_products((exact3)(c.x, a.x, b.x), (exact3)(b.y, c.y, a.y), (exact3)(c.y, a.y, b.y),
                                      (exact3)(b.x, c.x, a.x));
    if (min(w.x, min(w.y, w.z)) < 0 && fmax(w.x, fmax(w.y, w.z)) > 0) return 0;
    const exact det = w.x + w.y + w.z;
    // All comparisons are of numbers times |det|: most rays miss, and are spared the division.
    const exact size = fabs(det);
    w *= copysign((exact)1, det);
    const exact t = w.x * a.z + w.y * b.z + w.z * c.z;
    if (!(size > 0 && t > 0 && t < hit->t * size)) return 0;
    const exact inverse = 1 / size;
    hit->t = t * inverse;
    hit->u = w.y * inverse;
    hit->v = w.z * inverse;
    hit->triangle = index;
    return 1;
}

#endif

#endif
