// The picture: the mean over the samples of a pixel, its slots' sums added in order.
// Out: FILM_CHANNELS reals a pixel. `launch` is the number of samples that each pixel has.
#include "compensated.h"
#include "context.h"

__kernel void resolve(STAGE_ARGS, __global real *picture)
{
    STAGE_CONTEXT(c);
    size_t pixel = get_global_id(0);
    if (pixel >= (size_t)setting(&c, SETTING_width) * setting(&c, SETTING_height)) return;
    const uint slots = setting(&c, SETTING_slots_per_pixel);
    __global const real4 *sums = (__global const real4 *)c.film + 2 * pixel * slots;
    real4 sum = (real4)(0), lost = (real4)(0);
    for (uint i = 0; i < slots; i++) add_compensated(&sum, &lost, sums[2 * i] - sums[2 * i + 1]);
    const real4 mean = sum / (real)launch;
    picture[pixel * FILM_CHANNELS] = mean.x;
    picture[pixel * FILM_CHANNELS + 1] = mean.y;
    picture[pixel * FILM_CHANNELS + 2] = mean.z;
#ifdef PATH_hole
    picture[pixel * FILM_CHANNELS + 3] = mean.w;
#endif
}
