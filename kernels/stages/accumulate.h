// A path is over: its radiance goes into the sums of its pixel. Each slot has sums of its own, so the order is fixed.
#ifndef OSLCL_STAGE_ACCUMULATE_H
#define OSLCL_STAGE_ACCUMULATE_H

#include "context.h"

// Kahan, "Pracniques: Further Remarks on Reducing Truncation Errors", 1965: what a sum loses is kept beside it.
static inline void add_compensated(__global real *sum, __global real *lost, real x)
{
    const real before = *sum;
    const real y = x - *lost;
    // Relaxed arithmetic would find that nothing can be lost; it may not look behind what is volatile.
    volatile real t = before + y;
    volatile real grown = t - before;
    *lost = grown - y;
    *sum = t;
}

static inline int stage_accumulate(const Context *c, uint slot)
{
    real3 L = path_get3(c, PATH_radiance, slot);
    // What is not finite would spoil the pixel for good. It is counted: it should not happen.
    if (!(is_finite_real(L.x) && is_finite_real(L.y) && is_finite_real(L.z))) {
        atomic_inc(&c->counters[COUNTER_repaired]);
        L = (real3)(0);
    }
    const size_t at = setting(c, SETTING_slots_per_pixel) * (size_t)setting(c, SETTING_pixel_first) + slot;
    __global real *film = c->film + 2 * FILM_CHANNELS * at;
    add_compensated(film, film + FILM_CHANNELS, L.x);
    add_compensated(film + 1, film + FILM_CHANNELS + 1, L.y);
    add_compensated(film + 2, film + FILM_CHANNELS + 2, L.z);
#ifdef PATH_hole
    add_compensated(film + 3, film + FILM_CHANNELS + 3, clamp(1 - path_get(c, PATH_hole, slot), (real)0, (real)1));
#endif
    uint next = path_get_uint(c, PATHU_sample, slot) + setting(c, SETTING_slots_per_pixel);
    return next < setting(c, SETTING_sample_end) ? QUEUE_gen : QUEUE_NONE;
}

#endif
