// Rays against triangles: two levels of binary trees in one buffer, indices only.
//
// In: rays relative to the camera (common space less the camera's position). Out: hits. It must not know materials.
//
// A node is 16 floats: for each axis the least of child 0 and of child 1, then the greatest of both, so that one operation
// serves both children; then as unsigned ints both children's indices and counts. count 0: the index is a node; else the
// index is the first of `count` triangles (bottom level) or one instance (top level). Boxes are rounded outward.
// Triangles and the test against them: triangle.h.
#ifndef OSLCL_GEOMETRY_H
#define OSLCL_GEOMETRY_H

#include "context.h"
#include "triangle.h"

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
static inline int meet_leaf(const Context *c, uint first, uint count, uint instance, real3 o, const TriangleRay *ray,
                            const int any, Hit *hit)
{
    int found = 0;
    for (uint i = 0; i < count && !(any && found); i++) {
#ifdef HAS_TRACE_SETS
        if (!is_in_set(c, first + i, instance, hit->set)) continue;
#endif
        found |= meet_triangle(c->triangles, first + i, o, ray, hit);
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
    TriangleRay turn = triangle_ray(d);
    uint node = 0;
    uint instance = 0;
#ifdef HAS_INSTANCES
    const real3 world_o = o, world_d = d, world_inverse = inverse;
    const TriangleRay world_turn = turn;
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
                turn = triangle_ray(d);
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
