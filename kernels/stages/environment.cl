// In: QUEUE_environment. Out: QUEUE_done.
#include "stages/environment.h"

__kernel void environment(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    // As in select_bsdf, for a scene without surfaces.
    if ((launch & LAUNCH_CLEARS) && get_global_id(0) == 0)
        for (uint q = 0; q < QUEUE_FIRST_LATE; q++) c.counters[q] = 0;
    uint slot = 0;
    int queue = QUEUE_NONE;
    if (queue_slot(&c, QUEUE_environment, &slot)) queue = stage_environment(&c, slot);
    QUEUE_PUSH(&c, queue, slot);
}
