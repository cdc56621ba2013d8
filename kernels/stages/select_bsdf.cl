// One program per material, its generated code in front. In: the material's queue. Out: QUEUE_scatter, or QUEUE_trace
// where no stage asks lights in between; or QUEUE_done.
#include "stages/select_bsdf.h"

LOBE_KERNEL void select_bsdf(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    uint slot = 0;
    int queue = QUEUE_NONE;
    if (queue_slot(&c, QUEUE_MATERIALS + launch, &slot)) queue = stage_select_bsdf(&c, slot);
    QUEUE_PUSH(&c, queue, slot);
}
