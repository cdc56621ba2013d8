// From a point on a triangle to what a shader sees of it (ShaderGlobals).
//
// In: triangle, instance, barycentric weights, the direction of view. Out: ShaderGlobals, and the point relative to the
// camera with a vector that leads off the surface. It must not know path state or materials.
#ifndef OSLCL_SURFACE_H
#define OSLCL_SURFACE_H

#include "bsdf/numeric.h"
#include "context.h"
#include "footprint.h"
#include "globals.h"

// Where what the shader says goes (its number tells whose it is), and what is the same for all points.
static inline void surface_buffers(const Context *c, ShaderGlobals *sg)
{
#ifdef HAS_OTHER_SPACES
    sg->other_spaces = c->other_spaces;
#else
    sg->other_spaces = 0;
#endif
#ifdef MATERIAL_INTERACTIVE
    sg->interactive = c->interactive + MATERIAL_INTERACTIVE;
#endif
#ifdef WITHOUT_TEXTURES
    sg->textures = 0;
#elif defined(HAS_TEXTURES)
    sg->textures = c->textures;
#endif
#ifdef HAS_POINT_CLOUDS
    sg->clouds = c->clouds;
#endif
    sg->point = 0;
#ifdef HAS_MESSAGES
#ifdef MATERIAL_NUMBER
    sg->records = c->messages;
    sg->point = MATERIAL_NUMBER;
#else
    sg->records = 0;
#endif
#endif
}

#ifdef HAS_SURFACES
#include "geometry.h"

typedef struct {
    real3 P;       // relative to the camera
    real3 offset;  // along Ng on the viewer's side; P plus or minus it lies clear of the surface
    uint shape;    // index of the placed mesh
} SurfacePoint;

// Words of a shape.
#define SHAPE_WORDS 3
#define SHAPE_QUEUE 0 // of its material
#define SHAPE_FLAGS 1
#define SHAPE_LIGHT 2 // of what emits: index of the light of its first triangle, less that triangle's number
#define SHAPE_HAS_NORMALS 1u
#define SHAPE_HAS_UVS 2u
#define SHAPE_EMITS 4u

// The last word of a triangle's corners: the shape above a bit for each corner whose opposite edge is flat, see clear_of_edges.
#define FLAT_EDGES_BITS 3

static inline uint shape_of(const Context *c, uint triangle, uint instance)
{
#ifdef HAS_INSTANCES
    if (instance != 0) return c->instance_roots[2 * instance + 1];
#endif
    return c->corners[4 * (size_t)c->triangle_ids[triangle] + 3] >> FLAT_EDGES_BITS;
}

static inline uint shape_word(const Context *c, uint shape, uint word) { return c->shapes[SHAPE_WORDS * shape + word]; }

// The tangents of a triangle with edges e1, e2 and differences of texture coordinates d1, d2; without usable coordinates
// the edges' plane gives any.
static inline void tangents(real3 e1, real3 e2, real2 d1, real2 d2, real3 Ng, real3 *dPdu, real3 *dPdv)
{
    real det = d1.x * d2.y - d1.y * d2.x;
    *dPdu = (e1 * d2.y - e2 * d1.y) / det;
    *dPdv = (e2 * d1.x - e1 * d2.x) / det;
    real size = dot(*dPdu, *dPdu) + dot(*dPdv, *dPdv);
    if (!is_finite_positive(size)) {
        *dPdu = e1;
        *dPdv = cross(Ng, e1);
    }
}

// What rounding does along n to a sum of terms of these sizes, in epsilons: Pharr, Jakob and Humphreys, "Physically Based
// Rendering", 4th ed., 2023, sec. 6.8.
static inline real error_along(real3 n, real3 extent) { return 16 * dot(fabs(n), extent); }

// The error of meet_triangle along the normal: it knows a plane along an oblique ray no better than the triangle's longest side. Of a
// test in doubles floats see none.
#if defined(INTERSECTION_F64) && !defined(OSLCL_F64)
static inline real error_of_test(real3 extent) { return 0; }
#else
static inline real error_of_test(real3 extent) { return 4 * max_component(extent); }
#endif

#ifdef HAS_INSTANCES
// The sizes of the terms of transform_point.
static inline real3 transform_extent(__global const real *m, real3 p)
{
    return (real3)(fabs(m[0]) * p.x + fabs(m[1]) * p.y + fabs(m[2]) * p.z + fabs(m[3]),
                   fabs(m[4]) * p.x + fabs(m[5]) * p.y + fabs(m[6]) * p.z + fabs(m[7]),
                   fabs(m[8]) * p.x + fabs(m[9]) * p.y + fabs(m[10]) * p.z + fabs(m[11]));
}
#endif

// Moves a point along its triangle, so that it lies clear of the edges: rounded to beyond one, it would lie behind the next wall of
// a corner, and a ray from there would leave a closed room. extent: the sizes of the terms of its sum; u, v: its weights of
// corners 1 and 2. Across a flat edge the surface goes on in the same plane, so that no wall is there: the point stays. Within a
// needle, which holds no clear point, it moves no further than MOST_CLEARANCE of the needle's length.
#define MOST_CLEARANCE ((real)(1 / 256.0))
static inline real3 clear_of_edges(real3 P, real3 e1, real3 e2, real3 extent, real u, real v, uint flat)
{
    const real3 e3 = e2 - e1;
    const real longest = sqrt(max(dot(e1, e1), max(dot(e2, e2), dot(e3, e3))));
    const real height = length(cross(e1, e2)) / longest;
    const real margin = fmin(8 * REAL_EPSILON * max_component(extent) / height, MOST_CLEARANCE);
    const real3 margins = (real3)(flat & 1u ? 0 : margin, flat & 2u ? 0 : margin, flat & 4u ? 0 : margin);
    const real3 w = fmax((real3)(1 - u - v, u, v), margins);
    const real scale = 1 / (w.x + w.y + w.z);
    return P + e1 * (w.y * scale - u) + e2 * (w.z * scale - v);
}

// I: unit, towards the point.
static inline SurfacePoint surface_point(const Context *c, uint triangle, uint instance, real u, real v, real3 I,
                                         ShaderGlobals *sg)
{
    SurfacePoint s;
    __global const real4 *p = c->triangles + 3 * (size_t)triangle;
    real3 v0 = p[0].xyz, e1 = p[1].xyz - v0, e2 = p[2].xyz - v0;
    __global const uint *corner = c->corners + 4 * (size_t)c->triangle_ids[triangle];
    s.shape = shape_of(c, triangle, instance);
    s.P = v0 + e1 * u + e2 * v;
    real3 Ng = (real3)(p[0].w, p[1].w, p[2].w);
    real3 N = Ng;
    const uint flags = shape_word(c, s.shape, SHAPE_FLAGS);
#ifdef HAS_NORMALS
    if (flags & SHAPE_HAS_NORMALS) {
        real3 n = convert_real3(vload3(corner[0], c->normals)) * (1 - u - v) +
                  convert_real3(vload3(corner[1], c->normals)) * u + convert_real3(vload3(corner[2], c->normals)) * v;
        n = safe_normalize(n);
        // Zero or opposed normals: the flat one is right.
        N = is_zero3(n) ? Ng : n;
    }
#endif
    real3 extent = fabs(v0) + fabs(e1) + fabs(e2);
    real error = error_along(Ng, extent) + error_of_test(extent);
#ifdef HAS_INSTANCES
    if (instance != 0) {
        __global const real *to_object = c->instances + 24 * (size_t)instance;
        __global const real *to_world = to_object + 12;
        s.P = transform_point(to_world, s.P);
        const real3 normal = transform_normal(to_object, Ng);
        // Of the next ray on its way back.
        error = error_along(Ng, transform_extent(to_object, fabs(s.P))) + error_of_test(extent);
        Ng = safe_normalize(normal);
        N = safe_normalize(transform_normal(to_object, N));
        v0 = transform_point(to_world, v0);
        e1 = transform_direction(to_world, e1);
        e2 = transform_direction(to_world, e2);
        // And of the point on its way to world space.
        extent = transform_extent(to_world, extent);
        error = error / length(normal) + error_along(Ng, extent);
    }
#endif
    s.P = clear_of_edges(s.P, e1, e2, extent, u, v, corner[3]);
    sg->backfacing = dot(I, Ng) > 0;
#ifndef HAS_TRUSTED_NORMALS
    if (dot(N, Ng) < 0) N = -N;
#endif
    if (sg->backfacing) {
        Ng = -Ng;
        N = -N;
    }
#ifndef HAS_TRUSTED_NORMALS
    // An interpolated normal that the viewer would see from below is bent back to the horizon.
    real below = dot(N, I) + (real)1e-4;
    if (below > 0) N = safe_normalize(N - I * below);
#endif
    s.offset = Ng * (error * REAL_EPSILON);
    sg->P = s.P + constant_real3(c, CONSTANT_camera_position);
    sg->I = I;
    sg->N = N;
    sg->Ng = Ng;
    sg->u = u;
    sg->v = v;
    real2 d1 = (real2)(1, 0), d2 = (real2)(0, 1);
#ifdef HAS_UVS
    if (flags & SHAPE_HAS_UVS) {
        float2 t0 = vload2(corner[0], c->uvs), t1 = vload2(corner[1], c->uvs), t2 = vload2(corner[2], c->uvs);
        d1 = (real2)(t1.x - t0.x, t1.y - t0.y);
        d2 = (real2)(t2.x - t0.x, t2.y - t0.y);
        sg->u = t0.x + d1.x * u + d2.x * v;
        sg->v = t0.y + d1.y * u + d2.y * v;
    }
#endif
#if defined(HAS_TANGENTS) || defined(HAS_DERIVATIVES)
    tangents(e1, e2, d1, d2, Ng, &sg->dPdu, &sg->dPdv);
#else
    sg->dPdu = sg->dPdv = (real3)(0);
#endif
    sg->Ps = sg->dPdtime = (real3)(0);
    sg->time = sg->dtime = 0;
    sg->raytype = 0;
#ifdef HAS_SURFACE_AREA
    sg->surfacearea = c->areas[s.shape];
#else
    sg->surfacearea = 0;
#endif
#ifdef HAS_OBJECT_SPACE
    sg->object_space = sg->shader_space = c->object_spaces + 32 * (size_t)s.shape;
#else
    sg->object_space = sg->shader_space = 0;
#endif
#ifdef HAS_CAMERA_SPACE
    sg->camera_space = c->constants + CONSTANT_camera_space;
#else
    sg->camera_space = 0;
#endif
#ifdef HAS_DERIVATIVES
    footprint_none(sg);
#endif
    surface_buffers(c, sg);
#ifdef HAS_TRACES
    sg->scene = c;
    sg->here = s.P;
    sg->clearance = s.offset;
#endif
    return s;
}

#endif

// What an environment's shader sees: only the direction.
static inline void environment_point(const Context *c, real3 I, ShaderGlobals *sg)
{
    sg->P = sg->Ps = sg->dPdtime = sg->dPdu = sg->dPdv = (real3)(0);
    sg->I = I;
    sg->N = sg->Ng = -I;
    sg->u = sg->v = sg->time = sg->dtime = sg->surfacearea = 0;
    sg->backfacing = sg->raytype = 0;
    sg->object_space = sg->shader_space = 0;
#ifdef HAS_CAMERA_SPACE
    sg->camera_space = c->constants + CONSTANT_camera_space;
#else
    sg->camera_space = 0;
#endif
#ifdef HAS_DERIVATIVES
    footprint_none(sg);
#endif
    surface_buffers(c, sg);
#ifdef HAS_TRACES
    sg->scene = c;
    sg->here = -constant_real3(c, CONSTANT_camera_position);
    sg->clearance = (real3)(0);
#endif
}

#endif
