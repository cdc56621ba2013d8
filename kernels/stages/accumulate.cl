// In: QUEUE_done. Out: QUEUE_trace, with the slot's next sample, while it has some left.
#include "stages/accumulate.h"
#include "stages/ray_gen.h"

__kernel void accumulate(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    if (get_global_id(0) == 0) add_to_count(&c, COUNTER_samples, c.counters[QUEUE_done]);
    uint slot = 0;
    int queue = QUEUE_NONE;
    if (queue_slot(&c, QUEUE_done, &slot)) {
        stage_accumulate(&c, slot);
        const PixelSequence sequence = path_sequence(&c, slot, BLOCK_CAMERA);
        queue = stage_ray_gen(&c, slot, 0, &sequence);
    }
    QUEUE_PUSH(&c, queue, slot);
}
