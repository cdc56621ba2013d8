// One program per material, its generated code in front. In: the material's queue. Out: QUEUE_scatter, or QUEUE_trace
// where no stage asks lights in between; or QUEUE_done.
#include "stages/select_bsdf.h"

LOBE_KERNEL void select_bsdf(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    // trace is done with these, sample_next has not begun.
    if ((launch & LAUNCH_CLEARS) && get_global_id(0) == 0)
        for (uint q = 0; q < QUEUE_FIRST_LATE; q++) c.counters[q] = 0;
    const uint from = QUEUE_MATERIALS + LAUNCH_INDEX(launch);
    uint slot = 0;
    int queue = QUEUE_NONE;
    if (queue_slot(&c, from, &slot)) queue = stage_select_bsdf(&c, slot);
    QUEUE_PUSH(&c, queue, slot);
}
