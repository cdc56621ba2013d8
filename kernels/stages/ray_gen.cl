// Starts a batch. In: all its slots. Out: QUEUE_trace.
#include "stages/ray_gen.h"

__kernel void ray_gen(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    const uint slot = get_global_id(0);
    int queue = QUEUE_NONE;
    if (slot < setting(&c, SETTING_slots)) {
        const PixelSequence sequence = path_sequence(&c, slot, BLOCK_CAMERA);
        queue = stage_ray_gen(&c, slot, 1, &sequence);
    }
    QUEUE_PUSH(&c, queue, slot);
}
