// Runs a shader over a grid of points and stores its outputs, one point behind the other: `oslcl shade`.
// In: SHADE_ENTRY, a grid function that the compiler wrote, and SHADE_REALS, how many reals it stores per point; the
// generated text stands before this one, and with it shade_userdata, which fills HAS_USERDATA slots of userdata. The points are those of OSL's testshade: a patch at z = 1. Its twin is
// Grid::globals in runtime/src/shade.rs.
#include "globals.h"

// Bits of `flags`.
#define GRID_CENTER 1u  // points in the middles of the grid's cells, not from edge to edge
#define GRID_VARY_U 2u  // derivatives of u, v, P that differ from point to point
#define GRID_VARY_V 4u
#define GRID_VARY_P 8u

// One surface coordinate of point i of n.
static inline real grid_coordinate(uint i, uint n, real scale, real offset, uint flags)
{
    if (flags & GRID_CENTER) return scale * ((real)i + (real)0.5) / (real)n + offset;
    return scale * (n > 1 ? (real)i / (real)(n - 1) : (real)0.5) + offset;
}

#ifdef HAS_DERIVATIVES
static inline void grid_derivatives(ShaderGlobals *sg, real2 scale, uint width, uint height, uint flags)
{
    const real dx = scale.x / (real)max(width - 1, 1u), dy = scale.y / (real)max(height - 1, 1u);
    const bool center = (flags & GRID_CENTER) != 0;
    sg->dudx = center ? scale.x / (real)width : dx;
    sg->dvdy = center ? scale.y / (real)height : dy;
    sg->dudy = sg->dvdx = 0;
    if (flags & GRID_VARY_U) {
        sg->dudx = 1 - sg->u;
        sg->dudy = sg->u;
    }
    if (flags & GRID_VARY_V) {
        sg->dvdx = 1 - sg->v;
        sg->dvdy = sg->v;
    }
    sg->dPdx = (real3)(dx, 0, 0);
    sg->dPdy = (real3)(0, dy, 0);
    if (flags & GRID_VARY_P) {
        sg->dPdx = (real3)(1 - sg->u, 1 - sg->v, sg->u / 2);
        sg->dPdy = (real3)(1 - sg->v, 1 - sg->u, sg->v / 2);
    }
    sg->dIdx = sg->dIdy = sg->dPsdx = sg->dPsdy = (real3)(0);
    sg->flip_handedness = 0;
}
#endif

// patch: scale of u and v, offset of u and v. spaces: as in ShaderGlobals, 32 reals each: object, shader, camera, others.
__kernel void shade(uint first_row, uint count, uint width, uint height, uint flags, uint raytype,
                    __global const real *patch, __global const real *spaces, __global real *outputs
#ifdef HAS_MESSAGES
                    , __global uint *records
#endif
#ifdef HAS_TEXTURES
                    , __global const uint *textures
#endif
#ifdef HAS_INTERACTIVE
                    , __global const real *interactive
#endif
#ifdef HAS_POINT_CLOUDS
                    , __global const uint *clouds
#endif
                    )
{
    const uint i = (uint)get_global_id(0);
    if (i >= count) return;
    const uint x = i % width, y = first_row + i / width;
    ShaderGlobals sg;
    sg.u = grid_coordinate(x, width, patch[0], patch[2], flags);
    sg.v = grid_coordinate(y, height, patch[1], patch[3], flags);
    sg.P = (real3)(sg.u, sg.v, 1);
    sg.I = (real3)(0);
    sg.N = sg.Ng = (real3)(0, 0, 1);
    sg.dPdu = (real3)(1, 0, 0);
    sg.dPdv = (real3)(0, 1, 0);
    sg.Ps = sg.dPdtime = (real3)(0);
    sg.time = sg.dtime = 0;
    sg.surfacearea = 1;
    sg.backfacing = 0;
    sg.raytype = (int)raytype;
    sg.object_space = spaces;
    sg.shader_space = spaces + 32;
    sg.camera_space = spaces + 64;
    sg.other_spaces = spaces + 96;
#ifdef HAS_DERIVATIVES
    grid_derivatives(&sg, (real2)(patch[0], patch[1]), width, height, flags);
#endif
#ifdef HAS_TEXTURES
    sg.textures = textures;
#endif
#ifdef HAS_POINT_CLOUDS
    sg.clouds = clouds;
#endif
    sg.point = first_row * width + i;
#ifdef HAS_INTERACTIVE
    sg.interactive = interactive;
#endif
#ifdef HAS_USERDATA
    real userdata[HAS_USERDATA];
    shade_userdata(&sg, userdata);
    sg.userdata = userdata;
#endif
#ifdef HAS_MESSAGES
    sg.records = records;
#endif
    real values[SHADE_REALS + 1];  // never none
    SHADE_ENTRY(&sg, values);
    for (int k = 0; k < SHADE_REALS; k++) outputs[(size_t)i * SHADE_REALS + k] = values[k];
}
