// Rays that shaders trace: trace() (specification ch. 7, "Dictionary Lookups" and after).
//
// In: a ray in common space, the id of a set of objects ("": all). Out: whether it meets something, and what first. Distances are
// in common units, whatever the direction's length. With HAS_TRACES the renderer defines the functions scene_ (kernels/traces.h);
// without it there is nothing to meet. It must not know what a scene is made of.
#ifndef OSLCL_OSL_TRACE_H
#define OSLCL_OSL_TRACE_H

#include "globals.h"

// What is met, seen along the ray.
typedef struct {
    real distance;
    real3 P, N, Ng, I, dPdu, dPdv;
    real u, v;
    int name;
} TraceFacts;

#ifdef HAS_TRACES
static int scene_meets(const ShaderGlobals *sg, real3 from, real3 direction, real nearest, real farthest, int set);
static int scene_nearest(const ShaderGlobals *sg, real3 from, real3 direction, real nearest, real farthest, int set,
                         TraceFacts *facts);
#endif

static inline int osl_trace_any_i_vvffs(const ShaderGlobals *sg, real3 from, real3 direction, real nearest, real farthest,
                                        int set)
{
#ifdef HAS_TRACES
    return scene_meets(sg, from, direction, nearest, farthest, set);
#else
    return 0;
#endif
}

static inline int osl_trace_nearest_i_vvffsofovovovovovovofofos(const ShaderGlobals *sg, real3 from, real3 direction,
                                                                real nearest, real farthest, int set, real *distance,
                                                                real3 *P, real3 *N, real3 *Ng, real3 *I, real3 *dPdu,
                                                                real3 *dPdv, real *u, real *v, int *name)
{
    TraceFacts facts;
    int met = 0;
    facts.P = facts.N = facts.Ng = facts.I = facts.dPdu = facts.dPdv = (real3)(0);
    facts.distance = facts.u = facts.v = 0;
    facts.name = 0;
#ifdef HAS_TRACES
    met = scene_nearest(sg, from, direction, nearest, farthest, set, &facts);
#endif
    *distance = facts.distance;
    *P = facts.P;
    *N = facts.N;
    *Ng = facts.Ng;
    *I = facts.I;
    *dPdu = facts.dPdu;
    *dPdv = facts.dPdv;
    *u = facts.u;
    *v = facts.v;
    *name = facts.name;
    return met;
}

#endif
