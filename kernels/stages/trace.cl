// In: QUEUE_trace. Out: the queue of the material that was hit, QUEUE_environment or QUEUE_done. On CPUs also film, see below.
#include "stages/trace.h"
#if defined(OSLCL_CPU) && !defined(HAS_VARYING_ENVIRONMENT)
// What a path that leaves the scene meets is known without a shader: the path ends here, and the slot's next sample starts at once, while
// its state is in the core's cache. At most so many a launch, so that the host keeps hearing how far it is. Not on GPUs, where lanes
// would wait for each other.
#define SAMPLES_IN_A_ROW 32
#include "stages/accumulate.h"
#include "stages/ray_gen.h"
#endif

__kernel void trace(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    if (get_global_id(0) == 0) add_to_count(&c, COUNTER_rays, c.counters[QUEUE_trace]);
    uint slot = 0;
    int queue = QUEUE_NONE;
#ifdef SAMPLES_IN_A_ROW
    // What the group did beyond its part of the queue.
    __local uint more_rays, more_samples;
    if (get_local_id(0) == 0) more_rays = more_samples = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (queue_slot(&c, QUEUE_trace, &slot)) {
        uint rays = 0, samples = 0;
        PixelSequence sequence;
        for (;;) {
            queue = stage_trace(&c, slot);
            if (queue != QUEUE_done || samples == SAMPLES_IN_A_ROW) break;
            stage_accumulate(&c, slot);
            if (samples++ == 0) sequence = path_sequence(&c, slot, BLOCK_CAMERA);
            queue = stage_ray_gen(&c, slot, 0, &sequence);
            if (queue == QUEUE_NONE) break;
            rays++;
        }
        if (samples > 0) {
            atomic_add(&more_rays, rays);
            atomic_add(&more_samples, samples);
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0 && more_samples > 0) {
        add_to_count(&c, COUNTER_rays, more_rays);
        add_to_count(&c, COUNTER_samples, more_samples);
    }
#else
    if (queue_slot(&c, QUEUE_trace, &slot)) queue = stage_trace(&c, slot);
#endif
    QUEUE_PUSH(&c, queue, slot);
}
