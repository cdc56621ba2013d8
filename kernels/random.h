// Counter-based random numbers: a pure function of pixel, sample, block of dimensions and seed, so that a picture does not
// depend on the order in which paths are traced. Four numbers a block.
// Method: pcg4d of Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020.
#ifndef OSLCL_RANDOM_H
#define OSLCL_RANDOM_H

#include "real.h"

// Blocks of a path: 0 is the camera's, then two a bounce.
#define BLOCK_CAMERA 0u
#define BLOCK_LIGHT(depth) (2u * (depth) - 1u)
#define BLOCK_BSDF(depth) (2u * (depth))

static inline uint4 random_bits(uint pixel, uint sample, uint block, uint seed)
{
    uint4 v = (uint4)(pixel, sample, block, seed) * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> 16;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// Uniform in [0,1): 24 bits in both precisions, so that f64 runs on the same numbers as f32 and 1 is never reached. The low 8 bits of
// each word are left for others.
static inline real4 random_reals(uint4 bits)
{
    uint4 v = bits >> 8;
    return (real4)((real)v.x, (real)v.y, (real)v.z, (real)v.w) * (real)5.9604644775390625e-8;
}

static inline real4 random4(uint pixel, uint sample, uint block, uint seed)
{
    return random_reals(random_bits(pixel, sample, block, seed));
}

#endif
