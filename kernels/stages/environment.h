// What a path that leaves the scene sees, from the environment's material.
#ifndef OSLCL_STAGE_ENVIRONMENT_H
#define OSLCL_STAGE_ENVIRONMENT_H

#include "lights.h"
#include "lobe.h"
#include "surface.h"
#include "traces.h"

// Radiance from direction I away from the viewer.
static inline real3 environment_radiance(const Context *c, real3 I)
{
    ShaderGlobals sg;
    ShadeResult result;
    environment_point(c, I, &sg);
#ifdef HAS_USERDATA
    // Nothing is there. By bytes: some slots are ints, which a store of reals need not reach.
    real userdata[HAS_USERDATA];
    for (uint i = 0; i < sizeof(userdata); i++) ((uchar *)userdata)[i] = 0;
    sg.userdata = userdata;
#endif
    MATERIAL_ENTRY(&sg, 0, &result);
    return result.background;
}

static inline int stage_environment(const Context *c, uint slot)
{
    real3 d = path_get3(c, PATH_ray_d, slot);
    ShaderGlobals sg;
    ShadeResult result;
    environment_point(c, d, &sg);
#ifdef PATH_cone_spread
#ifdef HAS_ENVIRONMENT_SAMPLING
    // The two ways to the same light must see the same: what is blurred on one and sharp on the other counts twice.
    if (!(path_get(c, PATH_pdf, slot) > 0 && ENVIRONMENT_SHARE > 0))
#endif
        footprint_direction(c, slot, d, &sg);
#endif
#ifdef PATHU_raytype
#ifdef HAS_ENVIRONMENT_SAMPLING
    // As above; what sampling asks has no path.
    if (path_get_uint(c, PATHU_depth, slot) == 1 || ENVIRONMENT_SHARE == 0)
#endif
        sg.raytype = path_get_uint(c, PATHU_raytype, slot);
#endif
#ifdef HAS_USERDATA
    // Nothing is there. By bytes: some slots are ints, which a store of reals need not reach.
    real userdata[HAS_USERDATA];
    for (uint i = 0; i < sizeof(userdata); i++) ((uchar *)userdata)[i] = 0;
    sg.userdata = userdata;
#endif
    MATERIAL_ENTRY(&sg, 0, &result);
    real3 L = path_get3(c, PATH_beta, slot) * result.background;
#ifdef HAS_ENVIRONMENT_SAMPLING
    real pdf = path_get(c, PATH_pdf, slot);
    if (pdf > 0) L *= mis_weight(pdf, environment_pdf(c, d));
#endif
    path_set3(c, PATH_radiance, slot, path_get3(c, PATH_radiance, slot) + L);
    return QUEUE_done;
}

#ifdef HAS_ENVIRONMENT_SAMPLING
// A ray to the environment met nothing: its part of the light.
static inline void stage_environment_light(const Context *c, uint slot)
{
    real3 L = path_get3(c, PATH_shadow_L, slot) * environment_radiance(c, path_get3(c, PATH_shadow_d, slot));
    path_set3(c, PATH_radiance, slot, path_get3(c, PATH_radiance, slot) + L);
}
#endif

#endif
