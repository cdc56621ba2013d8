// Radiance of the environment over directions, once before rendering: 2 x 2 points for each cell of the map that
// sample_environment draws from. Out: 3 reals per cell.
#include "stages/environment.h"

__kernel void environment_map(STAGE_ARGS, __global real *map)
{
    STAGE_CONTEXT(c);
    uint cell = get_global_id(0);
    if (cell >= ENVIRONMENT_WIDTH * ENVIRONMENT_HEIGHT) return;
    real3 sum = (real3)(0);
    for (uint k = 0; k < 4; k++) {
        real turn = ((cell % ENVIRONMENT_WIDTH) + (real)0.25 + (real)0.5 * (k & 1)) * (real)(1.0 / ENVIRONMENT_WIDTH);
        real z = 1 - 2 * ((cell / ENVIRONMENT_WIDTH) + (real)0.25 + (real)0.5 * (k >> 1)) * (real)(1.0 / ENVIRONMENT_HEIGHT);
        real sine = safe_sqrt((1 - z) * (1 + z));
        real sp, cp;
        m_sincos_turns(turn, &sp, &cp);
        sum += environment_radiance(&c, (real3)(sine * cp, sine * sp, z));
    }
    vstore3(sum * (real)0.25, cell, map);
}
