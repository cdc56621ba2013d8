// What takes a path on from a surface to the next one within a kernel (ADR 0024): the stages one after the other, for one slot, whose state
// stays in the core's cache.
//
// In: a slot behind `select_bsdf`, or one whose path has ended. Out: the queue that it has to wait in.
#ifndef OSLCL_STAGE_FOLLOW_H
#define OSLCL_STAGE_FOLLOW_H

#include "stages/accumulate.h"
#include "stages/ray_gen.h"
#include "stages/trace.h"

// Most samples that end and begin in a row, so that the host keeps hearing how far it is, and, on a GPU, lanes don't wait for each
// other for long.
#ifdef OSLCL_CPU
#define SAMPLES_IN_A_ROW 32
#else
#define SAMPLES_IN_A_ROW 2
#endif

// What was done beyond what the stages' queues count.
typedef struct {
    PixelSequence camera; // of the slot's pixel, once a sample has begun
    uint rays, shadow_rays, samples;
} Followed;

// Traces the next edge. Paths that end, or have, make room for the slot's next sample.
static inline int follow_to_surface(const Context *c, uint slot, int queue, Followed *f)
{
    for (uint samples = 0;;) {
        if (queue == QUEUE_done) {
            if (samples++ == SAMPLES_IN_A_ROW) return QUEUE_done;
            between_stages();
            stage_accumulate(c, slot);
            if (f->samples++ == 0) f->camera = path_sequence(c, slot, BLOCK_CAMERA);
            queue = stage_ray_gen(c, slot, 0, &f->camera);
        }
        if (queue != QUEUE_trace) return queue;
        between_stages();
        queue = stage_trace(c, slot);
        f->rays++;
        if (queue != QUEUE_done) return queue;
    }
}

// Counts for a whole group, in its local memory. Every work-item calls all three, with barriers between them.
#define FOLLOW_COUNTS 3
static inline void follow_begin(__local uint *counts)
{
    if (get_local_id(0) == 0) counts[0] = counts[1] = counts[2] = 0;
}
static inline void follow_count(__local uint *counts, const Followed *f)
{
    if (f->rays > 0) atomic_add(&counts[0], f->rays);
    if (f->shadow_rays > 0) atomic_add(&counts[1], f->shadow_rays);
    if (f->samples > 0) atomic_add(&counts[2], f->samples);
}
static inline void follow_end(const Context *c, __local const uint *counts)
{
    if (get_local_id(0) != 0) return;
    if (counts[0] > 0) add_to_count(c, COUNTER_rays, counts[0]);
    if (counts[1] > 0) add_to_count(c, COUNTER_shadow_rays, counts[1]);
    if (counts[2] > 0) add_to_count(c, COUNTER_samples, counts[2]);
}

#endif
