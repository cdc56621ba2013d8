// In: QUEUE_environment. Out: QUEUE_done.
#include "stages/environment.h"

__kernel void environment(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    uint slot = 0;
    int queue = QUEUE_NONE;
    if (queue_slot(&c, QUEUE_environment, &slot)) queue = stage_environment(&c, slot);
    QUEUE_PUSH(&c, queue, slot);
}
