// Runs the material where the ray met it: adds what it emits, keeps the lobe that it picked.
// MATERIAL_ENTRY is the generated function (see lobe.h).
#ifndef OSLCL_STAGE_SELECT_BSDF_H
#define OSLCL_STAGE_SELECT_BSDF_H

#include "bsdf/bsdf.h"
#include "lights.h"
#include "lobe_state.h"
#include "path_random.h"
#ifndef QUEUE_scatter
#include "stages/sample_next.h"
#endif
#include "surface.h"
#include "traces.h"

#ifdef HAS_SHARED_CUBES
// Russian roulette with the number that chose the lobe, which so stays one number of an even cube. The probability to go on is
// the part of the light that does.
static inline real path_survives(const Context *c, uint depth, real3 wo, real3 beta, const Lobe *lobe)
{
#ifdef HAS_ROULETTE
    if (depth >= setting(c, SETTING_roulette_from)) {
        const real q = dot(lobe->weight, beta) * bsdf_albedo(lobe, wo) / (beta.x + beta.y + beta.z);
        return clamp(q, (real)0.05, (real)1);
    }
#endif
    return 1;
}
#endif

static inline int stage_select_bsdf(const Context *c, uint slot)
{
    const uint triangle = path_get_uint(c, PATHU_hit_triangle, slot);
#ifdef PATHU_hit_instance
    const uint instance = path_get_uint(c, PATHU_hit_instance, slot);
#else
    const uint instance = 0;
#endif
    real3 I = path_get3(c, PATH_ray_d, slot);
    ShaderGlobals sg;
    SurfacePoint point = surface_point(c, triangle, instance, path_get(c, PATH_hit_u, slot),
                                       path_get(c, PATH_hit_v, slot), I, &sg);
#ifdef PATH_cone_width
    footprint_surface(c, slot, length(point.P - path_get3(c, PATH_ray_o, slot)), &sg);
#endif
#ifdef PATHU_raytype
    sg.raytype = path_get_uint(c, PATHU_raytype, slot);
#endif
#ifdef HAS_USERDATA
    real userdata[HAS_USERDATA];
    material_userdata(c, point.shape, c->corners + 4 * (size_t)c->triangle_ids[triangle], path_get(c, PATH_hit_u, slot),
                      path_get(c, PATH_hit_v, slot), userdata);
    sg.userdata = userdata;
#endif
    const uint depth = path_get_uint(c, PATHU_depth, slot);
    real4 u = path_random(c, slot, BLOCK_LIGHT(depth));
    ShadeResult result;
#ifdef HAS_SHARED_CUBES
    // Two lobes share the cube's first side from the left on, as in the reference's renderer; lobe_offer fills it from the right.
    u.w = fmin(1 - u.x, (real)ONE_MINUS_EPSILON);
    result.rest = u.w;
#endif
#ifdef PATHU_turn
    // The first hit's lobes take turns; behind it, one at random.
    const uint turn = path_turn(c, slot);
    if (depth == 1 && setting(c, SETTING_split)) u.w = LOBE_NUMBER(turn);
    result.offered = 0;
#endif
    MATERIAL_ENTRY(&sg, u.w, &result);
#ifdef PATHU_turn
    if (depth == 1 && result.offered > 1) path_set_turn(c, slot, turn, min(result.offered, 0xffffu));
    // What the first hit emits and leaves out counts once.
    const int first_turn = depth > 1 || turn == 0;
#else
    const int first_turn = 1;
#endif
    real3 beta = path_get3(c, PATH_beta, slot);
#ifdef MATERIAL_EMITS
    const real3 Le = emitted(&result, dark_side(c, sg.backfacing));
    if (first_turn && !is_zero3(Le)) {
        real weight = 1;
#ifdef HAS_LIGHTS
        real pdf = path_get(c, PATH_pdf, slot);
        real cosine = -dot(sg.Ng, I);
        if (pdf > 0 && (shape_word(c, point.shape, SHAPE_FLAGS) & SHAPE_EMITS) && cosine > 0) {
            uint light = shape_word(c, point.shape, SHAPE_LIGHT) + c->triangle_ids[triangle];
            weight = mis_weight(pdf, light_pdf(c, light, path_get(c, PATH_hit_t, slot), cosine));
        }
#endif
        path_set3(c, PATH_radiance, slot, path_get3(c, PATH_radiance, slot) + beta * Le * weight);
    }
#endif
#ifdef PATH_hole
    if (first_turn) path_set(c, PATH_hole, slot, path_get(c, PATH_hole, slot) + dot(beta * result.holdout, (real3)(1.0 / 3)));
#endif
    // The next event would be one edge longer than allowed.
    if (depth >= setting(c, SETTING_max_depth) || result.lobe.type == LOBE_NONE) return QUEUE_done;
#ifdef HAS_SHARED_CUBES
    const real3 before = beta;
#endif
    beta *= result.lobe.weight;
    if (is_zero3(beta)) return QUEUE_done;
    path_set3(c, PATH_beta, slot, beta);
    path_set3(c, PATH_point, slot, point.P);
    path_set3(c, PATH_offset, slot, point.offset);
    store_lobe(c, slot, &result.lobe);
#ifdef HAS_SHARED_CUBES
    const real survive = path_survives(c, depth, -I, before, &result.lobe);
    path_set(c, PATH_survive, slot, survive);
    // From 1 on: the path ends behind this event.
    path_set(c, PATH_rest, slot, (1 - result.rest) / survive);
#endif
#ifdef QUEUE_scatter
    return QUEUE_scatter;
#else
    // No light is asked: the next edge at once.
    between_stages();
    return stage_sample_next(c, slot);
#endif
}

#endif
