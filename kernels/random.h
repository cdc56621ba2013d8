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

#if defined(SAMPLER_SOBOL) || defined(HAS_SHARED_CUBES)
static inline uint reverse_bits(uint x)
{
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    return as_uint(as_uchar4(x).wzyx);
}

// A permutation in which each bit depends on lower ones only: on reversed bits, Owen's scrambling. Laine and Karras,
// "Stratified Sampling for Stochastic Transparency", EGSR 2011, with Vegdahl's constants.
static inline uint4 scramble_reversed(uint4 x, uint4 seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}
#endif

#ifdef SAMPLER_SOBOL
// The point of Sobol's sequence in four dimensions, by polynomials x, x + 1, x^2 + x + 1 and x^3 + x + 1 and Joe and Kuo's first
// direction numbers, SIAM J. Sci. Comput. 30, 2008; bits in reverse.
// The index is a polynomial in E, the step from one direction number to the next. With D for a shift by one bit these numbers
// follow E + 1 = D, E^2 + E + 1 = D^2 or E^3 + E + 1 = D^3, and modulo 2 so do their powers by m = 8, 4, 2 and 1, as in
// E^2m + E^m + 1 = D^2m. Each reduces the index in place, where bit p stands for D^d E^(p - d). The last step puts in the first
// direction numbers. Tests hold the points to sums of direction numbers.
#define SOBOL_STEP(shift_y, mask_y, shift_z, mask_z, shift_w, mask_w)                                                  \
    v ^= (v >> (uint4)(0, shift_y, shift_z, shift_w)) & (uint4)(0, mask_y, mask_z, mask_w)

static inline uint4 sobol_reversed(uint index)
{
    uint4 v = (uint4)(index);
    SOBOL_STEP(16, 0x0000ffffu, 8, 0x00ff0000u, 24, 0x000000ffu);
    SOBOL_STEP(8, 0x00ff00ffu, 16, 0x0000ffffu, 16, 0x0000ff00u);
    SOBOL_STEP(4, 0x0f0f0f0fu, 8, 0x0000ff00u, 8, 0x0000f000u);
    SOBOL_STEP(2, 0x33333333u, 4, 0x0f000f00u, 12, 0xff000fffu);
    SOBOL_STEP(1, 0x55555555u, 8, 0x00ff00ffu, 8, 0xf0000ff0u);
    SOBOL_STEP(0, 0, 4, 0x00f000f0u, 4, 0xc00c00c0u);
    SOBOL_STEP(0, 0, 2, 0x30303030u, 6, 0x3f03f03fu);
    SOBOL_STEP(0, 0, 4, 0x0f0f0f0fu, 4, 0x3c03c03cu);
    SOBOL_STEP(0, 0, 2, 0x0c0c0c0cu, 2, 0x08208208u);
    SOBOL_STEP(0, 0, 1, 0x44444444u, 3, 0xc71c71c7u);
    SOBOL_STEP(0, 0, 2, 0x33333333u, 2, 0x86186186u);
    SOBOL_STEP(0, 0, 1, 0x22222222u, 1, 0x49249249u);
    SOBOL_STEP(0, 0, 1, 0x55555555u, 0, 0);
    return v;
}

#endif // SAMPLER_SOBOL

// What the samples of a pixel have in common in a block of dimensions. SAMPLER_SOBOL: a block is four dimensions of its own,
// scrambled and put in its own order by the pixel: Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020. Else independent
// numbers.
typedef struct {
    uint pixel, block, seed;
#ifdef SAMPLER_SOBOL
    uint4 hash;
    uint order;
#endif
} PixelSequence;

static inline PixelSequence pixel_sequence(uint pixel, uint block, uint seed)
{
    PixelSequence p;
    p.pixel = pixel;
    p.block = block;
    p.seed = seed;
#ifdef SAMPLER_SOBOL
    const uint4 hash = random_bits(pixel, 0x9e3779b9u, block, seed);
    p.hash = hash;
    p.order = (hash.x ^ (hash.y * 0x2c1b3c6du)) + (hash.z ^ (hash.w * 0x297a2d39u));
#endif
    return p;
}

static inline uint4 sequence_point(const PixelSequence *p, uint sample)
{
#ifdef SAMPLER_SOBOL
    const uint index = reverse_bits(scramble_reversed((uint4)(reverse_bits(sample)), (uint4)(p->order)).x);
    const uint4 v = scramble_reversed(sobol_reversed(index), p->hash);
    return (uint4)(reverse_bits(v.x), reverse_bits(v.y), reverse_bits(v.z), reverse_bits(v.w));
#else
    return random_bits(p->pixel, sample, p->block, p->seed);
#endif
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
    const PixelSequence sequence = pixel_sequence(pixel, block, seed);
    return random_reals(sequence_point(&sequence, sample));
}

#endif
