// The points of the default sampler, before they are scrambled.
#define SAMPLER_SOBOL
#include "random.h"

// Points of Sobol's sequence, at indices spread over all 32 bits.
__kernel void sobol_points(__global uint4 *out)
{
    const uint i = (uint)get_global_id(0);
    out[i] = sobol_reversed(i * 0x9e3779b9u);
}
