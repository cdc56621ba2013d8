// Runs a shader over a grid of points and stores its outputs, one point behind the other: `oslcl shade`.
// In: SHADE_ENTRY, a grid function that the compiler wrote, and SHADE_REALS, how many reals it stores per point; the
// generated text stands before this one. The points are those of OSL's testshade: the unit square at z = 1, seen from +z.
#include "globals.h"

__kernel void shade(uint first_row, uint count, uint width, uint height, __global const real *spaces,
                    __global real *outputs
#ifdef HAS_MESSAGES
                    , __global uint *records
#endif
                    )
{
    const uint i = (uint)get_global_id(0);
    if (i >= count) return;
    const uint x = i % width, y = first_row + i / width;
    ShaderGlobals sg;
    sg.u = width > 1 ? (real)x / (real)(width - 1) : (real)0.5;
    sg.v = height > 1 ? (real)y / (real)(height - 1) : (real)0.5;
    sg.P = (real3)(sg.u, sg.v, 1);
    sg.I = (real3)(0, 0, -1);
    sg.N = sg.Ng = (real3)(0, 0, 1);
    sg.dPdu = (real3)(1, 0, 0);
    sg.dPdv = (real3)(0, 1, 0);
    sg.Ps = sg.dPdtime = (real3)(0);
    sg.time = sg.dtime = 0;
    sg.surfacearea = 1;
    sg.backfacing = 0;
    sg.raytype = RAY_CAMERA;
    sg.object_space = sg.camera_space = spaces;
#ifdef HAS_MESSAGES
    sg.records = records;
    sg.point = first_row * width + i;
#endif
    real values[SHADE_REALS];
    SHADE_ENTRY(&sg, values);
    for (int k = 0; k < SHADE_REALS; k++) outputs[(size_t)i * SHADE_REALS + k] = values[k];
}
