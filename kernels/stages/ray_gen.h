// Starts the next sample of a slot, at the start of a batch its first: a ray of the camera.
#ifndef OSLCL_STAGE_RAY_GEN_H
#define OSLCL_STAGE_RAY_GEN_H

#include "bsdf/sampling.h"
#include "context.h"
#include "footprint.h"
#include "globals.h"
#include "path_random.h"

// Values of SETTING_filter; 0 is the box.
#define FILTER_TENT 1u
#define FILTER_MIDDLE 2u

#ifdef HAS_TENT_FILTER
// From uniform numbers to a tent from -1/2 to 3/2, which is one pixel wider on both sides than the pixel.
static inline real tent(real u)
{
    return u < (real)0.5 ? sqrt(2 * u) - (real)0.5 : (real)1.5 - sqrt(2 - 2 * u);
}
#endif

// sequence: path_sequence(c, slot, BLOCK_CAMERA).
static inline int stage_ray_gen(const Context *c, uint slot, int start, const PixelSequence *sequence)
{
    const uint per_pixel = setting(c, SETTING_slots_per_pixel);
    uint sample = start ? setting(c, SETTING_sample_first) + slot % per_pixel
                        : path_get_uint(c, PATHU_sample, slot) + per_pixel;
#ifdef PATHU_turn
    if (start) path_set_turn(c, slot, 0, 1);
    // The same sample once more.
    if (path_turn(c, slot) > 0) sample -= per_pixel;
#endif
    path_set_uint(c, PATHU_sample, slot, sample);
    if (sample >= setting(c, SETTING_sample_end)) return QUEUE_NONE;
    const uint width = setting(c, SETTING_width), height = setting(c, SETTING_height);
    const uint pixel = sequence->pixel;
    real4 u = random_reals(path_point(c, slot, sequence));
    // Film coordinates in [-1,1]: x to the right, y up. A box filter of one pixel, unless another is asked for.
#ifdef HAS_TENT_FILTER
    if (setting(c, SETTING_filter) == FILTER_TENT) {
        u.x = tent(u.x);
        u.y = tent(u.y);
    }
#endif
#ifdef HAS_MIDDLE_FILTER
    if (setting(c, SETTING_filter) == FILTER_MIDDLE) u.x = u.y = (real)0.5;
#endif
    real x = 2 * ((pixel % width) + u.x) / width - 1;
    real y = 1 - 2 * ((pixel / width) + u.y) / height;
    // camera_right and camera_up are scaled by the tangents of half the angles of view.
    real3 d = constant_real3(c, CONSTANT_camera_forward) + constant_real3(c, CONSTANT_camera_right) * x +
              constant_real3(c, CONSTANT_camera_up) * y;
    real3 o = (real3)(0);
#ifdef HAS_THIN_LENS
    // The plane in focus is where d, whose part along the view is 1, has the length of the focus distance.
    const real radius = constant_real(c, CONSTANT_lens_radius);
    if (radius > 0) {
        real3 lens = sample_disk(u.z, u.w) * radius;
        o = constant_real3(c, CONSTANT_lens_right) * lens.x + constant_real3(c, CONSTANT_lens_up) * lens.y;
        d = d * constant_real(c, CONSTANT_focus_distance) - o;
    }
#endif
    path_set3(c, PATH_ray_o, slot, o);
    path_set3(c, PATH_ray_d, slot, normalize(d));
    path_set3(c, PATH_beta, slot, (real3)(1));
    path_set3(c, PATH_radiance, slot, (real3)(0));
#ifdef HAS_DERIVATIVES
    path_set(c, PATH_cone_width, slot, 0);
    path_set(c, PATH_cone_spread, slot, footprint_of_pixel(c));
#endif
#ifdef PATH_pdf
    path_set(c, PATH_pdf, slot, 0);
#endif
#if defined(PATH_hole) && defined(PATHU_turn)
    if (path_turn(c, slot) == 0) path_set(c, PATH_hole, slot, 0);
#elif defined(PATH_hole)
    path_set(c, PATH_hole, slot, 0);
#endif
#ifdef PATHU_raytype
    path_set_uint(c, PATHU_raytype, slot, RAY_CAMERA);
#endif
    path_set_uint(c, PATHU_depth, slot, 1);
    return QUEUE_trace;
}

#endif
