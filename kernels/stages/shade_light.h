// Radiance of an emissive surface whose shader has to be asked: its radiance differs from point to point.
#ifndef OSLCL_STAGE_SHADE_LIGHT_H
#define OSLCL_STAGE_SHADE_LIGHT_H

#include "lights.h"
#include "lobe.h"
#include "surface.h"
#include "traces.h"

// Radiance of a triangle at barycentric u, v, seen along I.
static inline real3 emitted_radiance(const Context *c, uint triangle, uint instance, real u, real v, real3 I)
{
    ShaderGlobals sg;
    ShadeResult result;
    surface_point(c, triangle, instance, u, v, I, &sg);
#ifdef HAS_USERDATA
    real userdata[HAS_USERDATA];
    material_userdata(c, shape_of(c, triangle, instance), c->corners + 4 * (size_t)c->triangle_ids[triangle], u, v, userdata);
    sg.userdata = userdata;
#endif
    MATERIAL_ENTRY(&sg, 0, &result);
    return emitted(&result, dark_side(c, sg.backfacing));
}

// A ray to this light met nothing: its part of the light.
static inline void stage_shade_light(const Context *c, uint slot)
{
    const uint light = path_get_uint(c, PATHU_light, slot);
    __global const uint *words = c->light_words + LIGHT_WORDS * light;
    real3 Le = emitted_radiance(c, words[LIGHT_TRIANGLE], words[LIGHT_INSTANCE], path_get(c, PATH_light_u, slot),
                                path_get(c, PATH_light_v, slot), path_get3(c, PATH_shadow_d, slot));
    path_set3(c, PATH_radiance, slot,
              path_get3(c, PATH_radiance, slot) + path_get3(c, PATH_shadow_L, slot) * Le);
}

#endif
