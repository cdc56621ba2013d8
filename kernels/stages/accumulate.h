// A path is over: its radiance goes into the sums of its pixel. Each slot has sums of its own, so the order is fixed.
#ifndef OSLCL_STAGE_ACCUMULATE_H
#define OSLCL_STAGE_ACCUMULATE_H

#include "compensated.h"
#include "context.h"

static inline void stage_accumulate(const Context *c, uint slot)
{
    real3 L = path_get3(c, PATH_radiance, slot);
    // What is not finite would spoil the pixel for good. It is counted: it should not happen.
    if (!(is_finite_real(L.x) && is_finite_real(L.y) && is_finite_real(L.z))) {
        atomic_inc(&c->counters[COUNTER_repaired]);
        L = (real3)(0);
    }
    const uint per_pixel = setting(c, SETTING_slots_per_pixel);
#ifdef HAS_ADAPTIVE
    const size_t at = per_pixel * (size_t)path_pixel(c, slot) + slot % per_pixel;
#else
    const size_t at = per_pixel * (size_t)setting(c, SETTING_pixel_first) + slot;
#endif
    real4 sample = (real4)(L, 0);
#ifdef PATHU_turn
    const uint turn = path_turn(c, slot) + 1, turns = path_turns(c, slot);
    const int is_last = turn >= turns;
#else
    const int is_last = 1;
#endif
#ifdef PATH_hole
    // What a sample's turns leave out adds up.
    if (is_last) sample.w = clamp(1 - path_get(c, PATH_hole, slot), (real)0, (real)1);
#endif
    __global real4 *film = (__global real4 *)c->film + 2 * at;
    real4 sum = film[0], lost = film[1];
    add_compensated(&sum, &lost, sample);
    film[0] = sum;
    film[1] = lost;
#ifdef PATHU_turn
    if (!is_last) {
        path_set_turn(c, slot, turn, turns);
        add_to_count(c, COUNTER_turns, 1);
        return;
    }
    path_set_turn(c, slot, 0, 1);
#endif
}

#endif
