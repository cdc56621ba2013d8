// Whether anything stands between a point and a light; if not, the light counts.
#ifndef OSLCL_STAGE_TRACE_SHADOW_H
#define OSLCL_STAGE_TRACE_SHADOW_H

#include "geometry.h"
#include "lights.h"

static inline int stage_trace_shadow(const Context *c, uint slot)
{
    if (any_hit(c, path_get3(c, PATH_shadow_o, slot), path_get3(c, PATH_shadow_d, slot),
                path_get(c, PATH_shadow_t, slot)))
        return QUEUE_NONE;
#ifdef HAS_SHADED_LIGHTS
    const uint light = path_get_uint(c, PATHU_light, slot);
#ifdef HAS_ENVIRONMENT_SAMPLING
    if (light == ENVIRONMENT_LIGHT) return QUEUE_environment_light;
#endif
#ifdef HAS_VARYING_LIGHTS
    const int queue = (int)c->light_words[LIGHT_WORDS * light + LIGHT_QUEUE];
    if (queue != QUEUE_NONE) return queue;
#endif
#endif
    path_set3(c, PATH_radiance, slot, path_get3(c, PATH_radiance, slot) + path_get3(c, PATH_shadow_L, slot));
    return QUEUE_NONE;
}

#endif
