// Runs a displacement shader at the vertices of a mesh.
// In: DISPLACE_ENTRY, a grid function with the outputs P and N that the compiler wrote; the generated text stands before this
// one. Per vertex 16 reals: P and N in common space, dPdu, dPdv, u, v, and
// how far u and v go to the next vertex. Out per vertex 6 reals: how far P moved, and N.
#include "globals.h"
#include "maths.h"

#define VERTEX_REALS 16

__kernel void displace(uint first, uint count, real eye_x, real eye_y, real eye_z, __global const real *spaces,
                       __global const real *vertices, __global real *outputs
#ifdef HAS_TEXTURES
                       , __global const uint *textures
#endif
#ifdef HAS_MESSAGES
                       , __global uint *records
#endif
#ifdef HAS_INTERACTIVE
                       , __global const real *interactive
#endif
#ifdef HAS_POINT_CLOUDS
                       , __global const uint *clouds
#endif
#ifdef HAS_USERDATA
                       , __global const real *vertex_userdata
#endif
                       )
{
    const uint i = (uint)get_global_id(0);
    if (i >= count) return;
    __global const real *vertex = vertices + (size_t)VERTEX_REALS * (first + i);
    ShaderGlobals sg;
    sg.P = vload3(0, vertex);
    sg.N = sg.Ng = vload3(1, vertex);
    sg.dPdu = vload3(2, vertex);
    sg.dPdv = vload3(3, vertex);
    sg.u = vertex[12];
    sg.v = vertex[13];
    sg.I = sg.P - (real3)(eye_x, eye_y, eye_z);
    const real far = length(sg.I);
    sg.I = far > 0 ? sg.I / far : -sg.N;
    sg.Ps = sg.dPdtime = (real3)(0);
    sg.time = sg.dtime = 0;
    sg.surfacearea = 0;
    sg.backfacing = 0;
    sg.raytype = 0;
    sg.object_space = spaces;
    sg.shader_space = spaces;
    sg.camera_space = spaces + 32;
    sg.other_spaces = spaces + 64;
#ifdef HAS_DERIVATIVES
    // There are no pixels: x and y run along u and v, by as much as vertices are apart, so that
    // calculatenormal(P) is the displaced surface's normal and filters are as wide as the mesh resolves.
    sg.dudx = vertex[14];
    sg.dvdy = vertex[15];
    sg.dPdx = sg.dPdu * sg.dudx;
    sg.dPdy = sg.dPdv * sg.dvdy;
    sg.dudy = sg.dvdx = 0;
    sg.dIdx = sg.dIdy = sg.dPsdx = sg.dPsdy = (real3)(0);
    sg.flip_handedness = dot(cross(sg.dPdx, sg.dPdy), sg.N) < 0;
#endif
#ifdef HAS_TEXTURES
    sg.textures = textures;
#endif
#ifdef HAS_POINT_CLOUDS
    sg.clouds = clouds;
#endif
    sg.point = first + i;
#ifdef HAS_MESSAGES
    sg.records = records;
#endif
#ifdef HAS_INTERACTIVE
    sg.interactive = interactive;
#endif
#ifdef HAS_USERDATA
    real userdata[HAS_USERDATA];
    // By bytes: some slots are ints, which a store of reals need not reach.
    __global const uchar *from = (__global const uchar *)(vertex_userdata + (size_t)HAS_USERDATA * (first + i));
    for (uint k = 0; k < sizeof(userdata); k++) ((uchar *)userdata)[k] = from[k];
    sg.userdata = userdata;
#endif
    real values[6];
    DISPLACE_ENTRY(&sg, values);
    vstore3((real3)(values[0], values[1], values[2]) - sg.P, 2 * (size_t)i, outputs);
    vstore3((real3)(values[3], values[4], values[5]), 2 * (size_t)i + 1, outputs);
}
