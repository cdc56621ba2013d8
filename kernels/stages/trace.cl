// In: QUEUE_trace. Out: the queue of the material that was hit, QUEUE_environment or QUEUE_done.
// On CPUs, where what a path that leaves the scene meets is known without a shader, the path ends here, and the slot's next samples start
// at once. Not on GPUs, where lanes would wait for each other.
#if defined(OSLCL_CPU) && !defined(HAS_VARYING_ENVIRONMENT)
#define ENDS_PATHS
#include "stages/follow.h"
#else
#include "stages/trace.h"
#endif

__kernel void trace(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    if (get_global_id(0) == 0) add_to_count(&c, COUNTER_rays, c.counters[QUEUE_trace]);
    uint slot = 0;
    int queue = QUEUE_NONE;
#ifdef ENDS_PATHS
    __local uint counts[FOLLOW_COUNTS];
    follow_begin(counts);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (queue_slot(&c, QUEUE_trace, &slot)) {
        Followed f;
        f.rays = f.shadow_rays = f.samples = 0;
        queue = stage_trace(&c, slot);
        if (queue == QUEUE_done) queue = follow_to_surface(&c, slot, queue, &f);
        follow_count(counts, &f);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    follow_end(&c, counts);
#else
    if (queue_slot(&c, QUEUE_trace, &slot)) queue = stage_trace(&c, slot);
#endif
    QUEUE_PUSH(&c, queue, slot);
}
