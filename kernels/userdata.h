// Userdata of a point on a triangle: what the mesh has at its vertices, interpolated, and attributes of the object. The plan
// writes, for each material that asks, USERDATA_COLUMNS and the function material_userdata, which calls these.
//
// In: the shape, the triangle's corners, barycentric weights. Out: slots as ShaderGlobals.userdata has them, and whether the
// shape has the data. It must not know path state or materials.
#ifndef OSLCL_USERDATA_H
#define OSLCL_USERDATA_H

#include "context.h"

#define USERDATA_ABSENT 0xffffffffu // stride of what the shape lacks; stride 0 is the same at all vertices

static inline __global const uint *userdata_place(const Context *c, uint shape, uint column)
{
    return c->userdata_places + 2 * ((size_t)shape * USERDATA_COLUMNS + column);
}

static inline int userdata_reals(const Context *c, uint shape, uint column, uint count, __global const uint *corner, real u,
                                 real v, real *slots)
{
    __global const uint *place = userdata_place(c, shape, column);
    const uint first = place[0], stride = place[1];
    if (stride == USERDATA_ABSENT) {
        for (uint k = 0; k < count; k++) slots[k] = 0;
        return 0;
    }
    for (uint k = 0; k < count; k++) {
        // Sums of 32 bits: `first` may have wrapped.
        const real p = c->userdata[first + stride * corner[0] + k];
        slots[k] = stride == 0 ? p
                               : p * (1 - u - v) + c->userdata[first + stride * corner[1] + k] * u +
                                     c->userdata[first + stride * corner[2] + k] * v;
    }
    return 1;
}

// Ints, and strings by their ids: attributes only.
static inline int userdata_ints(const Context *c, uint shape, uint column, uint count, __global const uint *corner, real u,
                                real v, real *slots)
{
    __global const uint *place = userdata_place(c, shape, column);
    const int found = place[1] != USERDATA_ABSENT;
    for (uint k = 0; k < count; k++) *(int *)(slots + k) = found ? as_int(c->userdata[place[0] + k]) : 0;
    return found;
}

#endif
