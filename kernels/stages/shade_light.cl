// One program per material that emits what isn't constant. In: its light queue, filled by trace_shadow.
#include "stages/shade_light.h"

__kernel void shade_light(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    uint slot;
    if (queue_slot(&c, launch, &slot)) stage_shade_light(&c, slot);
}
