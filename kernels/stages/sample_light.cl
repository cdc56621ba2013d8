// In: QUEUE_scatter. Out: QUEUE_shadow.
#include "stages/sample_light.h"

LOBE_KERNEL void sample_light(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    uint slot = 0;
    int queue = QUEUE_NONE;
    if (queue_slot(&c, QUEUE_scatter, &slot)) queue = stage_sample_light(&c, slot);
    QUEUE_PUSH(&c, queue, slot);
}
