// Next event estimation: a ray to a light, with the light that it would bring.
#ifndef OSLCL_STAGE_SAMPLE_LIGHT_H
#define OSLCL_STAGE_SAMPLE_LIGHT_H

#include "bsdf/bsdf.h"
#include "lights.h"
#include "lobe_state.h"
#include "path_random.h"

static inline int stage_sample_light(const Context *c, uint slot)
{
    Lobe lobe = load_lobe(c, slot);
    if (bsdf_is_delta(&lobe)) return QUEUE_NONE;
    const uint depth = path_get_uint(c, PATHU_depth, slot);
    uint4 bits = path_random_bits(c, slot, BLOCK_LIGHT(depth));
    real3 P = path_get3(c, PATH_point, slot);
    LightSample s;
    if (!sample_lights(c, P, bits, &s)) return QUEUE_NONE;
    real3 wo = -path_get3(c, PATH_ray_d, slot);
    real pdf;
    real3 f = bsdf_eval(&lobe, wo, s.wi, &pdf);
    if (is_zero3(f)) return QUEUE_NONE;
#ifdef HAS_SHARED_CUBES
    pdf *= path_get(c, PATH_survive, slot);
#endif
    // A lobe around a bent normal must not carry light through the surface.
    real3 offset = path_get3(c, PATH_offset, slot);
    int above = dot(s.wi, offset) > 0;
#ifndef HAS_TRUSTED_NORMALS
    if (above != (dot(s.wi, lobe.N) > 0)) return QUEUE_NONE;
#endif
    real3 L = path_get3(c, PATH_beta, slot) * f * s.radiance * (mis_weight(s.pdf, pdf) / s.pdf);
    if (!above) offset = -offset;
    // From where the ray starts: by the light's distance from P it would end behind a light that is near.
    if (s.distance < REAL_MAX) {
        s.wi = s.wi * s.distance - offset;
        s.distance = length(s.wi);
        s.wi /= s.distance;
    }
    path_set3(c, PATH_shadow_o, slot, P + offset);
    path_set3(c, PATH_shadow_d, slot, s.wi);
    path_set(c, PATH_shadow_t, slot, shadow_length(&s));
    path_set3(c, PATH_shadow_L, slot, L);
#ifdef HAS_SHADED_LIGHTS
    path_set_uint(c, PATHU_light, slot, s.light);
#endif
#ifdef HAS_VARYING_LIGHTS
    path_set(c, PATH_light_u, slot, s.u);
    path_set(c, PATH_light_v, slot, s.v);
#endif
    return QUEUE_shadow;
}

#endif
