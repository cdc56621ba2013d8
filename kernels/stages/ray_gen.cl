// In: QUEUE_gen, or with launch 1 every slot of the batch. Out: QUEUE_trace.
#include "globals.h"
#include "stages/ray_gen.h"

__kernel void ray_gen(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    // Nothing else runs between the last reader of these queues and their next writer.
    if (get_global_id(0) == 0)
        for (uint q = QUEUE_FIRST_LATE; q < QUEUE_COUNT; q++) c.counters[q] = 0;
    int queue = QUEUE_NONE;
    uint slot = get_global_id(0);
    if (launch == 1) {
        if (slot < setting(&c, SETTING_slots)) queue = stage_ray_gen(&c, slot, 1);
    } else if (queue_slot(&c, QUEUE_gen, &slot)) {
        queue = stage_ray_gen(&c, slot, 0);
    }
    QUEUE_PUSH(&c, queue, slot);
}
