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
// Sobol's sequence in four dimensions; dimension 0 is the reversed index. Direction numbers of Joe and Kuo, SIAM J. Sci. Comput.
// 30, 2008. A row is what four bits of the index add to a point: one table look-up for four bits.
#define SOBOL_ROW(y0, z0, w0, y1, z1, w1, y2, z2, w2, y3, z3, w3)                                                      \
    {SOBOL_EIGHT(0u, 0u, 0u, y0, z0, w0, y1, z1, w1, y2, z2, w2), SOBOL_EIGHT(y3, z3, w3, y0, z0, w0, y1, z1, w1, y2, z2, w2)}
#define SOBOL_EIGHT(y, z, w, y0, z0, w0, y1, z1, w1, y2, z2, w2)                                                       \
    SOBOL_FOUR(y, z, w, y0, z0, w0, y1, z1, w1), SOBOL_FOUR(y ^ y2, z ^ z2, w ^ w2, y0, z0, w0, y1, z1, w1)
#define SOBOL_FOUR(y, z, w, y0, z0, w0, y1, z1, w1)                                                                    \
    SOBOL_TWO(y, z, w, y0, z0, w0), SOBOL_TWO(y ^ y1, z ^ z1, w ^ w1, y0, z0, w0)
#define SOBOL_TWO(y, z, w, y0, z0, w0) 0u, y, z, w, 0u, y ^ y0, z ^ z0, w ^ w0
__constant uint SOBOL[8][64] __attribute__((aligned(16))) = {
    SOBOL_ROW(0x80000000u, 0x80000000u, 0x80000000u, 0xc0000000u, 0xc0000000u, 0xc0000000u,
              0xa0000000u, 0x60000000u, 0x20000000u, 0xf0000000u, 0x90000000u, 0x50000000u),
    SOBOL_ROW(0x88000000u, 0xe8000000u, 0xf8000000u, 0xcc000000u, 0x5c000000u, 0x74000000u,
              0xaa000000u, 0x8e000000u, 0xa2000000u, 0xff000000u, 0xc5000000u, 0x93000000u),
    SOBOL_ROW(0x80800000u, 0x68800000u, 0xd8800000u, 0xc0c00000u, 0x9cc00000u, 0x25400000u,
              0xa0a00000u, 0xee600000u, 0x59e00000u, 0xf0f00000u, 0x55900000u, 0xe6d00000u),
    SOBOL_ROW(0x88880000u, 0x80680000u, 0x78080000u, 0xcccc0000u, 0xc09c0000u, 0xb40c0000u,
              0xaaaa0000u, 0x60ee0000u, 0x82020000u, 0xffff0000u, 0x90550000u, 0xc3050000u),
    SOBOL_ROW(0x80008000u, 0xe8808000u, 0x208f8000u, 0xc000c000u, 0x5cc0c000u, 0x51474000u,
              0xa000a000u, 0x8e606000u, 0xfbea2000u, 0xf000f000u, 0xc5909000u, 0x75d93000u),
    SOBOL_ROW(0x88008800u, 0x6868e800u, 0xa0858800u, 0xcc00cc00u, 0x9c9c5c00u, 0x914e5400u,
              0xaa00aa00u, 0xeeee8e00u, 0xdbe79e00u, 0xff00ff00u, 0x5555c500u, 0x25db6d00u),
    SOBOL_ROW(0x80808080u, 0x8000e880u, 0x58800080u, 0xc0c0c0c0u, 0xc0005cc0u, 0xe54000c0u,
              0xa0a0a0a0u, 0x60008e60u, 0x79e00020u, 0xf0f0f0f0u, 0x9000c590u, 0xb6d00050u),
    SOBOL_ROW(0x88888888u, 0xe8006868u, 0x800800f8u, 0xccccccccu, 0x5c009c9cu, 0xc00c0074u,
              0xaaaaaaaau, 0x8e00eeeeu, 0x200200a2u, 0xffffffffu, 0xc5005555u, 0x50050093u)};

// A block is four dimensions of its own, scrambled and put in its own order by the pixel: Burley, "Practical Hash-based Owen
// Scrambling", JCGT 9(4), 2020.
static inline uint4 sample_bits(uint pixel, uint sample, uint block, uint seed)
{
    const uint4 hash = random_bits(pixel, 0x9e3779b9u, block, seed);
    const uint order = (hash.x ^ (hash.y * 0x2c1b3c6du)) + (hash.z ^ (hash.w * 0x297a2d39u));
    // The index reversed, which is the first dimension as well.
    const uint first = scramble_reversed((uint4)(reverse_bits(sample)), (uint4)(order)).x;
    const uint index = reverse_bits(first);
    uint4 v = (uint4)(first, 0, 0, 0);
    for (uint row = 0; row < 8; row++)
        v ^= ((__constant uint4 *)SOBOL[row])[(index >> (4 * row)) & 15u];
    v = (uint4)(reverse_bits(v.x), reverse_bits(v.y), reverse_bits(v.z), reverse_bits(v.w));
    v = scramble_reversed(v, hash);
    return (uint4)(reverse_bits(v.x), reverse_bits(v.y), reverse_bits(v.z), reverse_bits(v.w));
}
#else
// Independent numbers.
static inline uint4 sample_bits(uint pixel, uint sample, uint block, uint seed)
{
    return random_bits(pixel, sample, block, seed);
}
#endif

// Uniform in [0,1): 24 bits in both precisions, so that f64 runs on the same numbers as f32 and 1 is never reached. The low 8 bits of
// each word are left for others.
static inline real4 random_reals(uint4 bits)
{
    uint4 v = bits >> 8;
    return (real4)((real)v.x, (real)v.y, (real)v.z, (real)v.w) * (real)5.9604644775390625e-8;
}

static inline real4 random4(uint pixel, uint sample, uint block, uint seed)
{
    return random_reals(sample_bits(pixel, sample, block, seed));
}

#endif
