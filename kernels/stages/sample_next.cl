// In: QUEUE_scatter. Out: QUEUE_trace or QUEUE_done.
#include "stages/sample_next.h"

LOBE_KERNEL void sample_next(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    uint slot = 0;
    int queue = QUEUE_NONE;
    if (queue_slot(&c, QUEUE_scatter, &slot)) queue = stage_sample_next(&c, slot);
    QUEUE_PUSH(&c, queue, slot);
}
