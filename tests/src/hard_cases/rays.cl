// Rays at the edges and vertices of closed meshes, and away from their surfaces. In: geometry as accel builds it. Out: counts.
#include "geometry.h"
#include "random.h"
#include "surface.h"

#ifdef HAS_INSTANCES
#define GEOMETRY_ARGS                                                                                                   \
    __global const float4 *nodes, __global const real4 *triangles, __global const uint *triangle_ids,                  \
        __global const uint *corners, __global const uint *shapes, __global const real *constants,                     \
        __global const real *instances, __global const uint *instance_roots
#else
#define GEOMETRY_ARGS                                                                                                   \
    __global const float4 *nodes, __global const real4 *triangles, __global const uint *triangle_ids,                  \
        __global const uint *corners, __global const uint *shapes, __global const real *constants
#endif

// No shader is asked anything: the buffers that are not passed are not read.
static Context geometry_context(GEOMETRY_ARGS)
{
    Context c;
    c.nodes = nodes;
    c.triangles = triangles;
    c.triangle_ids = triangle_ids;
    c.corners = corners;
    c.shapes = shapes;
    c.constants = constants;
#ifdef HAS_INSTANCES
    c.instances = instances;
    c.instance_roots = instance_roots;
#endif
    return c;
}

#ifdef HAS_INSTANCES
#define GEOMETRY geometry_context(nodes, triangles, triangle_ids, corners, shapes, constants, instances, instance_roots)
#else
#define GEOMETRY geometry_context(nodes, triangles, triangle_ids, corners, shapes, constants)
#endif

// A corner of a triangle relative to the camera.
static real3 triangle_place(const Context *c, uint triangle, uint instance, int corner)
{
    real3 p = triangle_corner(c->triangles, triangle, corner);
#ifdef HAS_INSTANCES
    if (instance != 0) p = transform_point(c->instances + 24 * (size_t)instance + 12, p);
#endif
    return p;
}

static void triangle_corners(const Context *c, uint triangle, uint instance, real3 *p)
{
    for (int k = 0; k < 3; k++) p[k] = triangle_place(c, triangle, instance, k);
}

// The place on a triangle that ray number i aims at: an edge anywhere, its middle, a corner, or inside.
static real3 aim(const real3 *p, uint i, real4 u)
{
    const uint k = (i >> 3) % 3;
    const real3 a = p[k], b = p[k == 2 ? 0 : k + 1];
    switch (i % 4) {
    case 0: return a + (b - a) * u.x;
    case 1: return a * (real)0.5 + b * (real)0.5;
    case 2: return a;
    default: return p[0] + ((p[1] - p[0]) * u.x + (p[2] - p[0]) * ((1 - u.x) * u.y));
    }
}

// Rays from within a closed mesh that is convex around `middle`: what they miss is a leak. reach: how far from the middle they start,
// as a part of the way to the surface. out: leaks, rays.
__kernel void shoot(GEOMETRY_ARGS, uint count, uint instance, real middle_x, real middle_y, real middle_z, real reach, uint axial,
                    uint turns, uint seed, volatile __global uint *out)
{
    const Context c = GEOMETRY;
    const real3 middle = (real3)(middle_x, middle_y, middle_z);
    uint leaks = 0, rays = 0;
    for (uint turn = 0; turn < turns; turn++) {
        const uint i = (uint)get_global_id(0) * turns + turn;
        const real4 u = random4(i, 0, 0, seed), w = random4(i, 1, 0, seed);
        real3 p[3];
        triangle_corners(&c, (uint)(u.w * count), instance, p);
        const real3 target = aim(p, i, u);
        // Between the middle and another corner: inside, whatever the scales.
        real3 o = middle + (triangle_place(&c, (uint)(w.y * count), instance, (i >> 5) % 3) - middle) * (w.z * reach);
        real3 d = target - o;
        if (axial) {
            // Along the axis in which the place is farthest out; only from places that are inside for sure.
            const real3 v = fabs(target - middle);
            const real most = max_component(v);
            real3 away = v.x == most ? (real3)(1, 0, 0) : v.y == most ? (real3)(0, 1, 0) : (real3)(0, 0, 1);
            o = target * (1 - away) + middle * away;
            d = (target - middle) * away;
            const real3 rest = v * (1 - away);
            if (max_component(rest) > (real)0.55 * most) continue;
        }
        d = safe_normalize(d);
        if (is_zero3(d)) continue;
        Hit hit;
        rays++;
        leaks += nearest_hit(&c, o, d, REAL_MAX, &hit) ? 0 : 1;
    }
    atomic_add(out, leaks);
    atomic_add(out + 1, rays);
}

// Rays from points of a convex mesh: outwards they must meet nothing, inwards something. The cosine goes down to `grazing`.
// out: hits outwards, misses inwards, rays, points off the mesh by more than their offset.
__kernel void leave(GEOMETRY_ARGS, uint count, uint instance, real middle_x, real middle_y, real middle_z, real grazing, uint seed,
                    volatile __global uint *out)
{
    const Context c = GEOMETRY;
    const uint i = (uint)get_global_id(0);
    const real4 u = random4(i, 0, 0, seed), w = random4(i, 1, 0, seed);
    const uint triangle = (uint)(u.w * count);
    const real root = sqrt(u.x);
    real3 p[3];
    triangle_corners(&c, triangle, instance, p);
    if (is_zero3(safe_normalize(cross(p[1] - p[0], p[2] - p[0])))) return; // no area, no points
    // Seen from outside.
    const real3 I = safe_normalize((real3)(middle_x, middle_y, middle_z) - (p[0] + p[1] + p[2]) * (real)(1.0 / 3));
    ShaderGlobals sg;
    const SurfacePoint s = surface_point(&c, triangle, instance, root * (1 - u.y), root * u.y, I, &sg);
    const Frame frame = frame_from_normal(sg.Ng);
    // Cosines evenly in the logarithm.
    const real z = exp(log(grazing) * w.x), r = sqrt((1 - z) * (1 + z));
    const real3 side = frame.s * (r * cos((real)(2 * PI) * w.y)) + frame.t * (r * sin((real)(2 * PI) * w.y));
    Hit hit;
    // Not as far as the copy.
    const real far = 100 * length(s.P - (real3)(middle_x, middle_y, middle_z));
    if (nearest_hit(&c, s.P + s.offset, side + sg.Ng * z, far, &hit)) atomic_inc(out);
    if (!nearest_hit(&c, s.P - s.offset, side - sg.Ng * z, REAL_MAX, &hit)) atomic_inc(out + 1);
    atomic_inc(out + 2);
    if (any(isnan(sg.N)) || any(isnan(s.offset)) || any(isnan(sg.dPdu)) || !(fabs(dot(sg.Ng, sg.Ng) - 1) < (real)1e-4))
        atomic_inc(out + 3);
}
