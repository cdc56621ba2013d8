// Radiance of this material's lights at their middles, seen head-on, once before rendering: what the choice among lights
// goes by. Out: the mean of the channels per light; others' lights are left alone.
#include "stages/shade_light.h"

__kernel void light_power(STAGE_ARGS, __global real *power)
{
    STAGE_CONTEXT(c);
    uint light = get_global_id(0);
    if (light >= setting(&c, SETTING_lights)) return;
    __global const uint *words = c.light_words + LIGHT_WORDS * light;
    if (words[LIGHT_QUEUE] != launch) return;
    __global const real *edges = c.lights + LIGHT_REALS * (size_t)light;
    real3 n = safe_normalize(cross(vload3(1, edges), vload3(2, edges)));
    real3 Le = emitted_radiance(&c, words[LIGHT_TRIANGLE], words[LIGHT_INSTANCE], (real)(1.0 / 3), (real)(1.0 / 3), -n);
    power[light] = dot(Le, (real3)(1.0 / 3));
}
