// Rays against triangles: two levels of binary trees in one buffer, indices only.
//
// In: rays relative to the camera (common space less the camera's position). Out: hits. It must not know materials.
//
// A node is 16 floats: for each axis the least of child 0 and of child 1, then the greatest of both, so that one operation
// serves both children; then as unsigned ints both children's indices and counts. count 0: the index is a node; else the
// index is the first of `count` triangles (bottom level) or one instance (top level). Boxes are rounded outward.
// A triangle is three real4, so that each takes one load: its corners; the w of all three are its unit normal.
#ifndef OSLCL_GEOMETRY_H
#define OSLCL_GEOMETRY_H

#include "context.h"

typedef struct {
    real t, u, v;   // distance in units of the ray's direction; barycentric weights of corners 1 and 2
    uint triangle;  // index into the bottom levels' triangles
    uint instance;  // index of the instance; 0 is what needs no transform
#ifdef HAS_TRACE_SETS
    uint set;       // in: the number of the set of objects that count; 0: all do
#endif
} Hit;

#define NO_TRIANGLE 0xffffffffu

// Depth 44 was the most that 6 million triangles reached; the host refuses deeper trees.
#define STACK_SIZE 96

// Affine transforms: 3 rows of 4, applied to column vectors.
static inline real3 transform_point(__global const real *m, real3 p)
{
    return (real3)(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                   m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
}
static inline real3 transform_direction(__global const real *m, real3 d)
{
    return (real3)(m[0] * d.x + m[1] * d.y + m[2] * d.z, m[4] * d.x + m[5] * d.y + m[6] * d.z,
                   m[8] * d.x + m[9] * d.y + m[10] * d.z);
}
// By the transpose of the inverse's rows: normals, when m is world to object.
static inline real3 transform_normal(__global const real *m, real3 n)
{
    return (real3)(m[0] * n.x + m[4] * n.y + m[8] * n.z, m[1] * n.x + m[5] * n.y + m[9] * n.z,
                   m[2] * n.x + m[6] * n.y + m[10] * n.z);
}

// 1/d, finite also for 0: then a slab test has no 0 * inf.
static inline real safe_inverse(real d) { return fabs(d) > (real)1e-30 ? 1 / d : copysign((real)1e30, d); }

// Where the ray enters the boxes of both children, and where it leaves them, at most at `far`.
static inline void enter_boxes(__global const float4 *n, real3 o, real3 inverse, real far, real2 *enter, real2 *leave)
{
    real4 x = (convert_real4(n[0]) - o.x) * inverse.x;
    real4 y = (convert_real4(n[1]) - o.y) * inverse.y;
    real4 z = (convert_real4(n[2]) - o.z) * inverse.z;
    *enter = max(max(min(x.xy, x.zw), min(y.xy, y.zw)), max(min(z.xy, z.zw), (real2)(0)));
    // Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013: a few ulps more for the exit keep the test watertight.
    *leave = min(min(max(x.xy, x.zw), max(y.xy, y.zw)), min(max(z.xy, z.zw), (real2)(far))) * (1 + 4 * REAL_EPSILON);
}

// Corner 0, 1 or 2 of a triangle.
static inline real3 triangle_corner(__global const real4 *triangles, uint index, int corner)
{
    return triangles[3 * (size_t)index + corner].xyz;
}

// The map that turns a ray's direction to (0, 0, 1), as columns: it shears along the axis in which the direction is longest and
// leaves the others' numbers alone.
typedef struct {
    real3 x, y, z;
} Shear;

static inline Shear shear_along(real3 d)
{
    const real3 a = fabs(d);
    Shear s;
    if (a.z >= a.x && a.z >= a.y) {
        s.x = (real3)(1, 0, 0);
        s.y = (real3)(0, 1, 0);
        s.z = (real3)(-d.x, -d.y, 1) / d.z;
    } else if (a.x >= a.y) {
        s.x = (real3)(-d.y, -d.z, 1) / d.x;
        s.y = (real3)(1, 0, 0);
        s.z = (real3)(0, 1, 0);
    } else {
        s.x = (real3)(0, 1, 0);
        s.y = (real3)(-d.z, -d.x, 1) / d.y;
        s.z = (real3)(1, 0, 0);
    }
    return s;
}

// By fma throughout: two triangles that share a corner have to find it in the same place, whatever the compiler contracts.
static inline real3 shear(const Shear *s, real3 v)
{
    return fma((real3)(v.x), s->x, fma((real3)(v.y), s->y, v.z * s->z));
}

// a b - c d, of the right sign always, and 0 only if it is. Kahan's way; Jeannerod, Louvet and Muller, "Further Analysis of Kahan's
// Algorithm for the Accurate Computation of 2x2 Determinants", Math. Comp. 82, 2013: the error is below two units in the last place.
static inline real3 difference_of_products(real3 a, real3 b, real3 c, real3 d)
{
    const real3 cd = c * d;
    const real3 lost = fma(-c, d, cd);
    return fma(a, b, -cd) + lost;
}

// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, with exact signs in the place of their second
// pass in double. A ray that passes an edge is on one side of it for both triangles; on it, it meets both. Shortens *hit when the
// triangle is nearer.
static inline int meet_triangle(__global const real4 *triangles, uint index, real3 o, const Shear *s, Hit *hit)
{
    const real3 a = shear(s, triangle_corner(triangles, index, 0) - o);
    const real3 b = shear(s, triangle_corner(triangles, index, 1) - o);
    const real3 c = shear(s, triangle_corner(triangles, index, 2) - o);
    // Twice the areas that the ray cuts off: the weights of the corners.
    real3 w = difference_of_products((real3)(c.x, a.x, b.x), (real3)(b.y, c.y, a.y), (real3)(c.y, a.y, b.y),
                                     (real3)(b.x, c.x, a.x));
    if (min(w.x, min(w.y, w.z)) < 0 && max_component(w) > 0) return 0;
    const real det = w.x + w.y + w.z;
    // All comparisons are of numbers times |det|: most rays miss, and are spared the division.
    const real size = fabs(det);
    w *= copysign((real)1, det);
    const real t = w.x * a.z + w.y * b.z + w.z * c.z;
    if (!(size > 0 && t > 0 && t < hit->t * size)) return 0;
    const real inverse = 1 / size;
    hit->t = t * inverse;
    hit->u = w.y * inverse;
    hit->v = w.z * inverse;
    hit->triangle = index;
    return 1;
}

#ifdef HAS_TRACE_SETS
static inline uint shape_of(const Context *c, uint triangle, uint instance);

// Whether a triangle's object is one of the set: a bit for each set behind the sets' ids.
static inline int is_in_set(const Context *c, uint triangle, uint instance, uint set)
{
    const uint count = c->trace_sets[0], bit = set - 1;
    if (set == 0) return 1;
    const uint words = (count + 31) / 32;
    return (c->trace_sets[1 + count + words * shape_of(c, triangle, instance) + bit / 32] >> (bit % 32)) & 1;
}
#endif

// The triangles of a leaf, in the space of an instance; with `any` the first that is met is enough.
static inline int meet_leaf(const Context *c, uint first, uint count, uint instance, real3 o, const Shear *s,
                            const int any, Hit *hit)
{
    int found = 0;
    for (uint i = 0; i < count && !(any && found); i++) {
#ifdef HAS_TRACE_SETS
        if (!is_in_set(c, first + i, instance, hit->set)) continue;
#endif
        found |= meet_triangle(c->triangles, first + i, o, s, hit);
    }
    if (found) hit->instance = instance;
    return found;
}

// Follows a ray from o along d up to hit->t. `any`: stops at the first triangle. Returns whether there is one.
static inline int follow_ray(const Context *c, real3 o, real3 d, const int any, Hit *hit)
{
    uint stack[STACK_SIZE];
    int top = 0;
    int found = 0;
    real3 inverse = (real3)(safe_inverse(d.x), safe_inverse(d.y), safe_inverse(d.z));
    Shear turn = shear_along(d);
    uint node = 0;
    uint instance = 0;
#ifdef HAS_INSTANCES
    const real3 world_o = o, world_d = d, world_inverse = inverse;
    const Shear world_turn = turn;
    int bottom = -1; // the stack's height at which the ray leaves the bottom level
#endif
    for (;;) {
        __global const float4 *n = c->nodes + 4 * (size_t)node;
        real2 enter, leave;
        enter_boxes(n, o, inverse, hit->t, &enter, &leave);
        uint4 links = as_uint4(n[3]);
        uint first = links.x, second = links.y;
        uint first_count = links.z, second_count = links.w;
        int go0 = enter.x <= leave.x, go1 = enter.y <= leave.y;
        uint next = 0;
        int have_next = 0;
#ifdef HAS_INSTANCES
        if (bottom < 0) {
            // Leaves of the top level are instances: both kinds of children go through the stack, marked by the highest bit.
            uint far_child = first | (first_count ? 0x80000000u : 0u), near_child = second | (second_count ? 0x80000000u : 0u);
            int go_far = go0, go_near = go1;
            if (enter.x < enter.y) {
                uint swap = far_child;
                far_child = near_child;
                near_child = swap;
                go_far = go1;
                go_near = go0;
            }
            if (go_far) stack[top++] = far_child;
            if (go_near) stack[top++] = near_child;
        } else
#endif
        {
            if (go0 && first_count) {
                found |= meet_leaf(c, first, first_count, instance, o, &turn, any, hit);
                go0 = 0;
            }
            if (go1 && second_count && !(any && found)) {
                found |= meet_leaf(c, second, second_count, instance, o, &turn, any, hit);
                go1 = 0;
            }
            if (any && found) return 1;
            if (go0 && go1) {
                int second_nearer = enter.y < enter.x;
                stack[top++] = second_nearer ? first : second;
                next = second_nearer ? second : first;
                have_next = 1;
            } else if (go0 || go1) {
                next = go0 ? first : second;
                have_next = 1;
            }
        }
        if (have_next) {
            node = next;
            continue;
        }
#ifdef HAS_INSTANCES
        if (bottom >= 0 && top == bottom) {
            bottom = -1;
            o = world_o;
            inverse = world_inverse;
            turn = world_turn;
        }
#endif
        if (top == 0) break;
        node = stack[--top];
#ifdef HAS_INSTANCES
        if (bottom < 0 && (node & 0x80000000u)) {
            instance = node & 0x7fffffffu;
            bottom = top;
            if (instance != 0) {
                __global const real *m = c->instances + 24 * (size_t)instance;
                o = transform_point(m, world_o);
                d = transform_direction(m, world_d);
                inverse = (real3)(safe_inverse(d.x), safe_inverse(d.y), safe_inverse(d.z));
                turn = shear_along(d);
            }
            node = c->instance_roots[2 * instance];
        }
#endif
    }
    return found;
}

// The nearest triangle within t_max.
static inline int nearest_hit(const Context *c, real3 o, real3 d, real t_max, Hit *hit)
{
    hit->t = t_max;
    hit->triangle = NO_TRIANGLE;
    hit->instance = 0;
#ifdef HAS_TRACE_SETS
    hit->set = 0;
#endif
    return follow_ray(c, o, d, 0, hit);
}

// Whether anything lies within t_max.
static inline int any_hit(const Context *c, real3 o, real3 d, real t_max)
{
    Hit hit;
    hit.t = t_max;
#ifdef HAS_TRACE_SETS
    hit.set = 0;
#endif
    return follow_ray(c, o, d, 1, &hit);
}

#endif
