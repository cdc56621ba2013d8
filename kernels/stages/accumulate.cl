// In: QUEUE_done. Out: QUEUE_gen while the slot has samples left.
#include "stages/accumulate.h"

__kernel void accumulate(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    if (get_global_id(0) == 0) count_add(&c, COUNTER_samples, c.counters[QUEUE_done]);
    uint slot = 0;
    int queue = QUEUE_NONE;
    if (queue_slot(&c, QUEUE_done, &slot)) queue = stage_accumulate(&c, slot);
    QUEUE_PUSH(&c, queue, slot);
}
