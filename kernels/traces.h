// Rays that shaders trace, through the scene's trees: what osl/trace.h asks of the renderer.
//
// In: the point being shaded, which knows its place in the scene (ShaderGlobals.scene), a ray in common space. Out: hits. It must
// not know path state or materials.
#ifndef OSLCL_TRACES_H
#define OSLCL_TRACES_H

#include "surface.h"

#ifdef HAS_TRACES
#include "osl/trace.h"

// So many roundings of its coordinates a point may be away from the one being shaded and still be it: it went to another space
// and back, say.
#define SAME_POINT ((real)4 * REAL_EPSILON)

#ifdef HAS_TRACE_SETS
// The number of a set, from 1 on; 0: all objects. The buffer: how many there are, their ids, then bits by shape.
static inline uint scene_set(const Context *c, int id)
{
    const uint count = c->trace_sets[0];
    for (uint k = 0; k < count && id != 0; k++)
        if (c->trace_sets[1 + k] == (uint)id) return k + 1;
    return 0;
}
#endif

// Follows the ray from `nearest` to `farthest`; *d is its unit direction, *start how far from `from` hit->t counts.
static inline int scene_follow(const ShaderGlobals *sg, real3 from, real3 direction, real nearest, real farthest, int set,
                               const int any, Hit *hit, real3 *d, real *start)
{
    const Context *c = (const Context *)sg->scene;
    *d = safe_normalize(direction);
    // Relative to the camera by way of the point being shaded, whose place is known there: far from the origin, common space is
    // too coarse for rays.
    const real3 away = from - sg->P;
    real3 o = sg->here + away;
    *start = fmax(nearest, (real)0);
    if (max_component(fabs(away)) <= SAME_POINT * max_component(fabs(sg->P))) {
        // From the surface itself a ray starts as the renderer's own do.
        const real3 clearance = dot(*d, sg->Ng) < 0 ? -sg->clearance : sg->clearance;
        o = sg->here + clearance + *d * *start;
        *start += dot(clearance, *d);
    } else {
        o += *d * *start;
    }
    hit->t = fmin(farthest, REAL_MAX) - *start;
    hit->triangle = NO_TRIANGLE;
    hit->instance = 0;
#ifdef HAS_TRACE_SETS
    hit->set = scene_set(c, set);
#endif
    if (is_zero3(*d) || !(hit->t > 0) || !is_finite_real(dot(o, (real3)(1)))) return 0;
    return follow_ray(c, o, *d, any, hit);
}

static int scene_meets(const ShaderGlobals *sg, real3 from, real3 direction, real nearest, real farthest, int set)
{
    Hit hit;
    real3 d;
    real start;
    return scene_follow(sg, from, direction, nearest, farthest, set, 1, &hit, &d, &start);
}

static int scene_nearest(const ShaderGlobals *sg, real3 from, real3 direction, real nearest, real farthest, int set,
                         TraceFacts *facts)
{
    const Context *c = (const Context *)sg->scene;
    Hit hit;
    real3 d;
    real start;
    if (!scene_follow(sg, from, direction, nearest, farthest, set, 0, &hit, &d, &start)) return 0;
    ShaderGlobals there;
    const SurfacePoint point = surface_point(c, hit.triangle, hit.instance, hit.u, hit.v, d, &there);
    facts->distance = start + hit.t;
    facts->P = there.P;
    facts->N = there.N;
    facts->Ng = there.Ng;
    facts->I = d;
    facts->dPdu = there.dPdu;
    facts->dPdv = there.dPdv;
    facts->u = there.u;
    facts->v = there.v;
#ifdef HAS_TRACE_NAMES
    facts->name = (int)c->trace_names[point.shape];
#endif
    return 1;
}

#endif

#endif
