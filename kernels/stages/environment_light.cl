// In: QUEUE_environment_light: rays that trace_shadow found free.
#include "stages/environment.h"

__kernel void environment_light(STAGE_ARGS)
{
    STAGE_CONTEXT(c);
    uint slot;
    if (queue_slot(&c, QUEUE_environment_light, &slot)) stage_environment_light(&c, slot);
}
