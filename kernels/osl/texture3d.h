// texture3d(): a picture as a volume of one slice (OSL specification ch. 7, "Texture").
//
// In: what the rows texture3d_* of the compiler's table take. Out: a colour or a number, or its derivative by s, t or r. Files
// with several slices are formats that the reference reads by plug-ins; without them a picture is a slice from r = 0 to 1. As
// in OpenImageIO's TextureSystem the finest level alone is read, the closest texel or linearly.
#ifndef OSLCL_OSL_TEXTURE3D_H
#define OSLCL_OSL_TEXTURE3D_H

#include "osl/texture_sample.h"

static inline real3 texture3d_lookup(__global const uint *data, int channels, int by, int file, real3 P, int mode, int first,
                                     int subimage, int name, real fill, real3 missing)
{
    Texture x;
    real s = 0, t = 0;
    if (!texture_open(&x, data, file, &s, &t, subimage, name))
        return by == 0 ? texture_absent(mode, fill, missing) : (real3)(0);
    texture_options(&x, first, channels, MODE_SWRAP(mode), MODE_TWRAP(mode));
    __global const uint *sub = data + x.sub;
    const real2 scale = (real2)(as_float(sub[SUB_SSCALE]), as_float(sub[SUB_TSCALE]));
    const int width = texture_width(&x, 0), height = texture_height(&x, 0);
    const real column = (P.x * scale.x + as_float(sub[SUB_SOFFSET])) * (real)width;
    const real row = (P.y * scale.y + as_float(sub[SUB_TOFFSET])) * (real)height;
    const int rwrap = MODE_RWRAP(mode);
    TextureSum sum = texture_nothing();
    real u, v, w;
    if (TEXTURE_INTERP(mode) == INTERP_CLOSEST) {
        int i = texture_floor(column, &u), j = texture_floor(row, &v), k = texture_floor(P.z, &w);
        if (by == 0 && texture_wrap(x.swrap, &i, width) && texture_wrap(x.twrap, &j, height) &&
            texture_wrap(rwrap, &k, 1)) {
            sum.value = texture_texel(&x, texture_level(&x, 0), i, j);
            sum.covered = 1;
        }
        return texture_filled(&x, &sum, by == 0 ? fill : (real)0);
    }
    const int i = texture_floor(column - (real)0.5, &u), j = texture_floor(row - (real)0.5, &v);
    int slice = texture_floor(P.z - (real)0.5, &w);
    const real wx[2] = {1 - u, u}, wy[2] = {1 - v, v}, slope[2] = {-1, 1};
    int behind = slice + 1;
    // The slice before and the one behind the point are the same picture, or black.
    const real in = texture_wrap(rwrap, &slice, 1) ? (real)1 : (real)0;
    const real out = texture_wrap(rwrap, &behind, 1) ? (real)1 : (real)0;
    const real weight = by == 3 ? out - in : in * (1 - w) + out * w;
    texture_weighted(&x, 0, i, j, 2, wx, wy, slope, slope, weight, &sum);
    switch (by) {
    case 1: return sum.ds * scale.x;
    case 2: return sum.dt * scale.y;
    case 3: return sum.value;
    default: return texture_filled(&x, &sum, fill);
    }
}

// The rows of the compiler's table: NAME is lookup, ds, dt or dr; BY counts them.
#define OSL_TEXTURE3D(NAME, BY)                                                                                        \
    static inline real3 osl_texture3d_##NAME##_v_sviiisfv(const ShaderGlobals *sg, int file, real3 P, int mode,        \
                                                          int first, int subimage, int name, real fill, real3 missing) \
    {                                                                                                                  \
        return texture3d_lookup(sg->textures, 3, BY, file, P, mode, first, subimage, name, fill, missing);             \
    }                                                                                                                  \
    static inline real osl_texture3d_##NAME##_f_sviiisfv(const ShaderGlobals *sg, int file, real3 P, int mode,         \
                                                         int first, int subimage, int name, real fill, real3 missing)  \
    {                                                                                                                  \
        return texture3d_lookup(sg->textures, 1, BY, file, P, mode, first, subimage, name, fill, missing).x;           \
    }
OSL_TEXTURE3D(lookup, 0)
OSL_TEXTURE3D(ds, 1)
OSL_TEXTURE3D(dt, 2)
OSL_TEXTURE3D(dr, 3)

#endif
