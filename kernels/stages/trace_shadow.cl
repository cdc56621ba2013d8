// In: QUEUE_shadow. Out: the light's queue where its shader has to be asked.
#include "stages/trace_shadow.h"

__kernel void trace_shadow(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    if (get_global_id(0) == 0) add_to_count(&c, COUNTER_shadow_rays, c.counters[QUEUE_shadow]);
    uint slot = 0;
    int queue = QUEUE_NONE;
    if (queue_slot(&c, QUEUE_shadow, &slot)) queue = stage_trace_shadow(&c, slot);
    QUEUE_PUSH(&c, queue, slot);
}
