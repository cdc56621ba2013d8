// Follows the path's ray to the nearest surface. What leaves the scene meets the environment.
#ifndef OSLCL_STAGE_TRACE_H
#define OSLCL_STAGE_TRACE_H

#include "surface.h"

static inline int stage_trace(const Context *c, uint slot)
{
#ifdef HAS_SURFACES
    Hit hit;
    real3 o = path_get3(c, PATH_ray_o, slot), d = path_get3(c, PATH_ray_d, slot);
    if (nearest_hit(c, o, d, REAL_MAX, &hit)) {
        path_set_uint(c, PATHU_hit_triangle, slot, hit.triangle);
#ifdef PATHU_hit_instance
        path_set_uint(c, PATHU_hit_instance, slot, hit.instance);
#endif
        path_set(c, PATH_hit_u, slot, hit.u);
        path_set(c, PATH_hit_v, slot, hit.v);
#ifdef PATH_hit_t
        path_set(c, PATH_hit_t, slot, hit.t);
#endif
        return QUEUE_MATERIALS + (int)shape_word(c, shape_of(c, hit.triangle, hit.instance), SHAPE_QUEUE);
    }
#endif
#ifdef HAS_VARYING_ENVIRONMENT
    return QUEUE_environment;
#else
#ifdef HAS_ENVIRONMENT
    // In two steps, as where its shader is asked: with the same rounding.
    real3 L = path_get3(c, PATH_beta, slot) * constant_real3(c, CONSTANT_environment);
    path_set3(c, PATH_radiance, slot, path_get3(c, PATH_radiance, slot) + L);
#endif
    return QUEUE_done;
#endif
}

#endif
