// The points of the default sampler, before they are scrambled, and the words of testrender's.
#define SAMPLER_SOBOL
#include "cubes.h"
#include "random.h"

// Points of Sobol's sequence, at indices spread over all 32 bits.
__kernel void sobol_points(__global uint4 *out)
{
    const uint i = (uint)get_global_id(0);
    out[i] = sobol_reversed(i * 0x9e3779b9u);
}

// Words of one event for 64 samples of a pixel each.
__kernel void cube_words(__global uint4 *out)
{
    const uint i = (uint)get_global_id(0);
    const uint2 pixel = (uint2)((i >> 6) & 63u, i >> 12);
    out[i] = (uint4)(cube3(pixel, i & 63u, 1, 7), cube1(pixel, i & 63u, 1, 7));
}
