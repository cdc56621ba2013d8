// In: QUEUE_trace. Out: the queue of the material that was hit, QUEUE_environment or QUEUE_done.
#include "stages/trace.h"

__kernel void trace(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    if (get_global_id(0) == 0) count_add(&c, COUNTER_rays, c.counters[QUEUE_trace]);
    uint slot = 0;
    int queue = QUEUE_NONE;
    if (queue_slot(&c, QUEUE_trace, &slot)) queue = stage_trace(&c, slot);
    QUEUE_PUSH(&c, queue, slot);
}
