// The path's next edge: a direction from the lobe in hand.
#ifndef OSLCL_STAGE_SAMPLE_NEXT_H
#define OSLCL_STAGE_SAMPLE_NEXT_H

#include "bsdf/bsdf.h"
#include "footprint.h"
#include "globals.h"
#include "lobe_state.h"
#include "path_random.h"

#ifdef PATHU_raytype
// OSL's names for rays (specification ch. 7, raytype). What passes straight on keeps its type.
static inline uint ray_type(int bits, uint before)
{
    if (bits & SAMPLE_STRAIGHT) return before;
    uint side = bits & SAMPLE_TRANSMIT ? RAY_REFRACTION : RAY_REFLECTION;
    return side | (bits & SAMPLE_DIFFUSE ? RAY_DIFFUSE : RAY_GLOSSY);
}
#endif

static inline int stage_sample_next(const Context *c, uint slot)
{
    Lobe lobe = load_lobe(c, slot);
    const uint depth = path_get_uint(c, PATHU_depth, slot);
    real4 u = path_random(c, slot, BLOCK_BSDF(depth));
#ifdef HAS_SHARED_CUBES
    u.x = path_get(c, PATH_rest, slot);
    if (!(u.x < 1)) return QUEUE_done;
    u.x = fmin(u.x, (real)ONE_MINUS_EPSILON);
    const real survive = path_get(c, PATH_survive, slot);
#endif
    real3 wo = -path_get3(c, PATH_ray_d, slot);
    real3 wi, value;
    real pdf;
    int bits = bsdf_sample(&lobe, wo, u.xyz, &wi, &value, &pdf);
    if (bits == 0) return QUEUE_done;
    real3 offset = path_get3(c, PATH_offset, slot);
    int above = dot(wi, offset) > 0;
    // As in sample_light: no light through the surface by a bent normal.
#ifndef HAS_TRUSTED_NORMALS
    if (above != ((bits & SAMPLE_REFLECT) != 0)) return QUEUE_done;
#endif
    real3 beta = path_get3(c, PATH_beta, slot) * value;
#ifdef HAS_SHARED_CUBES
    beta /= survive;
    pdf *= survive;
#elif defined(HAS_ROULETTE)
    if (depth >= setting(c, SETTING_roulette_from)) {
        real survive = min(max_component(beta), (real)0.95);
        if (!(u.w < survive)) return QUEUE_done;
        beta /= survive;
    }
#endif
    real3 P = path_get3(c, PATH_point, slot);
    path_set3(c, PATH_ray_o, slot, above ? P + offset : P - offset);
    path_set3(c, PATH_ray_d, slot, wi);
    path_set3(c, PATH_beta, slot, beta);
#ifdef HAS_DERIVATIVES
    footprint_bounce(c, slot, bits & SAMPLE_DELTA ? 0 : pdf);
#endif
#ifdef PATH_pdf
    path_set(c, PATH_pdf, slot, bits & SAMPLE_DELTA ? 0 : pdf);
#endif
#ifdef PATHU_raytype
    path_set_uint(c, PATHU_raytype, slot, ray_type(bits, path_get_uint(c, PATHU_raytype, slot)));
#endif
    path_set_uint(c, PATHU_depth, slot, depth + 1);
    return QUEUE_trace;
}

#endif
