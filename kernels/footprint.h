// What a pixel covers where its path meets the scene: the derivatives in ShaderGlobals by the pixel's x and y.
//
// In: the path's ray and how wide its cone has become. Out: dPdx and the like. On rays of the camera they are exact: H. Igehy,
// "Tracing Ray Differentials", SIGGRAPH 1999, eq. 8 to 12. Behind the first bounce a cone carries the size alone:
// T. Akenine-Moeller et al., "Texture Level of Detail Strategies for Real-Time Ray Tracing", Ray Tracing Gems 2019, ch. 20. It
// must not know materials. All of it is there only when a shader asks for derivatives.
#ifndef OSLCL_FOOTPRINT_H
#define OSLCL_FOOTPRINT_H

#include "bsdf/frame.h"
#include "context.h"
#include "globals.h"

#ifdef HAS_DERIVATIVES

// No footprint: what is asked about a single point.
static inline void footprint_none(ShaderGlobals *sg)
{
    sg->dPdx = sg->dPdy = sg->dIdx = sg->dIdy = sg->dPsdx = sg->dPsdy = (real3)(0);
    sg->dudx = sg->dudy = sg->dvdx = sg->dvdy = 0;
    sg->flip_handedness = 0;
}

// A shader may ask for footprints that the scene does without: then all of them are none.
#ifdef PATH_cone_width

// The angle that a pixel in the middle of the picture covers.
static inline real footprint_of_pixel(const Context *c)
{
    return 2 * length(constant_real3(c, CONSTANT_camera_up)) / setting(c, SETTING_height);
}

// How the direction changes from pixel to pixel. I: unit, from the viewer on.
static inline void footprint_direction(const Context *c, uint slot, real3 I, ShaderGlobals *sg)
{
    if (path_get_uint(c, PATHU_depth, slot) == 1) {
        // The ray's length where its part along the view is 1.
        const real scale = 2 * dot(I, constant_real3(c, CONSTANT_camera_forward));
        const real3 x = constant_real3(c, CONSTANT_camera_right) * (scale / setting(c, SETTING_width));
        const real3 y = constant_real3(c, CONSTANT_camera_up) * (-scale / setting(c, SETTING_height));
        sg->dIdx = x - I * dot(I, x);
        sg->dIdy = y - I * dot(I, y);
        return;
    }
    const real spread = path_get(c, PATH_cone_spread, slot);
    const Frame frame = frame_from_normal(I);
    sg->dIdx = frame.s * spread;
    sg->dIdy = frame.t * spread;
}

// Where the surface is cut by a ray that was moved across I: along I onto the tangent plane. Grazing rays are cut off at
// twenty times the ray's own width.
static inline real3 footprint_on_plane(real3 across, real3 I, real3 N)
{
    const real cosine = -fmax(-dot(I, N), (real)0.05);
    return across - I * (dot(across, N) / cosine);
}

// At a hit in distance t: after surface_point. Keeps the cone's width there for the next edge.
static inline void footprint_surface(const Context *c, uint slot, real t, ShaderGlobals *sg)
{
    footprint_direction(c, slot, sg->I, sg);
    const real width = path_get(c, PATH_cone_width, slot) + path_get(c, PATH_cone_spread, slot) * t;
    path_set(c, PATH_cone_width, slot, width);
    const int first = path_get_uint(c, PATHU_depth, slot) == 1;
    const Frame frame = frame_from_normal(sg->I);
    sg->dPdx = footprint_on_plane(first ? sg->dIdx * t : frame.s * width, sg->I, sg->Ng);
    sg->dPdy = footprint_on_plane(first ? sg->dIdy * t : frame.t * width, sg->I, sg->Ng);
    sg->flip_handedness = dot(cross(sg->dPdx, sg->dPdy), sg->N) < 0;
    // The plane's coordinates of a step within it.
    const real uu = dot(sg->dPdu, sg->dPdu), uv = dot(sg->dPdu, sg->dPdv), vv = dot(sg->dPdv, sg->dPdv);
    const real det = uu * vv - uv * uv;
    const real inverse = det > 0 ? 1 / det : 0;
    const real ux = dot(sg->dPdu, sg->dPdx), vx = dot(sg->dPdv, sg->dPdx);
    const real uy = dot(sg->dPdu, sg->dPdy), vy = dot(sg->dPdv, sg->dPdy);
    sg->dudx = (vv * ux - uv * vx) * inverse;
    sg->dvdx = (uu * vx - uv * ux) * inverse;
    sg->dudy = (vv * uy - uv * vy) * inverse;
    sg->dvdy = (uu * vy - uv * uy) * inverse;
}

// A bounce widens the cone by what a sample stands for: its solid angle is 1 / pdf, shared with sixteen samples or so
// (F. Suykens and Y. Willems, "Path Differentials and Applications", EGWR 2001, section 4). pdf 0: a mirror.
static inline void footprint_bounce(const Context *c, uint slot, real pdf)
{
    if (!(pdf > 0)) return;
    const real angle = (real)0.25 * sqrt(fmin(1 / ((real)3.14159265358979 * pdf), (real)1));
    path_set(c, PATH_cone_spread, slot, path_get(c, PATH_cone_spread, slot) + angle);
}

#endif

#endif

#endif
