// The picture: the mean over the samples of a pixel, its slots' sums added in order.
// Out: FILM_CHANNELS reals a pixel. `launch` is the number of samples that each pixel has.
#include "context.h"

__kernel void resolve(STAGE_ARGS, __global real *picture)
{
    STAGE_CONTEXT(c);
    size_t pixel = get_global_id(0);
    if (pixel >= (size_t)setting(&c, SETTING_width) * setting(&c, SETTING_height)) return;
    const uint slots = setting(&c, SETTING_slots_per_pixel);
    for (uint k = 0; k < FILM_CHANNELS; k++) {
        real sum = 0;
        for (uint i = 0; i < slots; i++) {
            __global const real *film = c.film + 2 * FILM_CHANNELS * (pixel * slots + i);
            sum += film[k] - film[FILM_CHANNELS + k];
        }
        picture[pixel * FILM_CHANNELS + k] = sum / launch;
    }
}
