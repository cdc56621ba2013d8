// What a generated shader can read of the point it shades. Directions and positions are in common (= world) space.
// It knows nothing of queues, path state or pixels.
#ifndef OSLCL_GLOBALS_H
#define OSLCL_GLOBALS_H

#include "real.h"

// Bits of ShaderGlobals.raytype; lower and OSL's raytype() names agree on them.
#define RAY_CAMERA 1
#define RAY_SHADOW 2
#define RAY_DIFFUSE 4
#define RAY_GLOSSY 8
#define RAY_REFLECTION 16
#define RAY_REFRACTION 32

typedef struct {
    real3 P;       // position
    real3 I;       // unit, from the viewer to P
    real3 N;       // unit shading normal, turned to the viewer's side
    real3 Ng;      // unit geometric normal, turned to the viewer's side
    real3 dPdu;    // tangents of the surface
    real3 dPdv;
    real3 Ps;      // the point a light is asked about; zero on surfaces
    real3 dPdtime;
    real u, v;     // surface coordinates
    real time, dtime;
    real surfacearea;  // of the object, world units squared
    int backfacing;    // 1 when the viewer is on the side that Ng of the mesh points away from
    int raytype;       // RAY_* of the ray that came here
    // Spaces: row-major 4x4 for row vectors, 32 reals each: to common, then from common. May be 0 when no shader asks.
    __global const real *object_space;
    __global const real *shader_space;
    __global const real *camera_space;
    __global const real *other_spaces;  // screen, NDC, raster, then the renderer's own in the order of their names
#ifdef HAS_DERIVATIVES
    // By the pixel's x (to the right) and y (down).
    real3 dPdx, dPdy, dIdx, dIdy, dPsdx, dPsdy;
    real dudx, dudy, dvdx, dvdy;
    int flip_handedness;  // 1 when raster space and common space turn opposite ways
#endif
#ifdef HAS_TRACES
    // For rays that the shader traces; it does not look at them itself.
    const void *scene;
    real3 here;        // P relative to the camera
    real3 clearance;   // along Ng: here plus or minus it lies clear of the surface
#endif
    uint point;        // its number among the points shaded together
#ifdef HAS_MESSAGES
    __global uint *records;  // where what the shader says goes (osl/records.h); 0: nobody listens
#endif
    // What the artifact lists as `userdata` and `interactive`, by its offsets: a real per slot, or an int in its first bytes.
#ifdef HAS_USERDATA
    const real *userdata;
#endif
#ifdef HAS_INTERACTIVE
    __global const real *interactive;
#endif
#ifdef HAS_POINT_CLOUDS
    __global const uint *clouds;   // all point clouds (osl/points.h)
#endif
#ifdef HAS_TEXTURES
    __global const uint *textures; // all texture files (osl/texture_data.h)
#endif
} ShaderGlobals;

#endif
