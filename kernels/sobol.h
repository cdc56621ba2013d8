// Sobol's sequence in three dimensions, scrambled after Owen: samples of a pixel fill each unit cube evenly, and each event of a
// path has a cube of its own. Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020, with the hash of N. Vegdahl,
// "Building a Better LK Hash", 2021, and the finaliser of C. Wellons, "Hash Prospector", 2018. The same choices as those of the
// reference implementation's testrender, so that pictures can be compared sample by sample.
//
// In: pixel, sample, event. Out: numbers in [0,1). It must not know path state.
#ifndef OSLCL_SOBOL_H
#define OSLCL_SOBOL_H

#include "real.h"

// Events of a path: 0 is the camera's, then one a bounce. From here on single numbers beside the cubes.
#define SOBOL_SINGLES 0x400000u

static inline uint reverse_bits(uint x)
{
    x = (x << 16) | (x >> 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

static inline uint sobol_hash(uint x)
{
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0xd35a2d97u;
    return x ^ (x >> 15);
}

// Of a number whose bits stand in reverse; they come back in order.
static inline uint owen_scramble(uint x, uint seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverse_bits(x);
}

// Uniform in [0,1), 24 bits as in random4.
static inline real sobol_real(uint x, uint seed) { return (real)(owen_scramble(x, seed) >> 8) * (real)5.9604644775390625e-8; }

static inline uint sobol_seed(uint2 pixel, uint event, uint seed)
{
    return (((pixel.x & 2047u) << 22 | (pixel.y & 2047u) << 11) + 4 * event) ^ (seed * 0x9e3779b9u);
}

// Which point of the sequence: all samples of a pixel in another order for each event. Bits in reverse.
static inline uint sobol_index(uint sample, uint seed)
{
    return owen_scramble(reverse_bits(sample), sobol_hash(seed)) & 0xffffffu;
}

static inline real3 sobol3(uint2 pixel, uint sample, uint event, uint seed)
{
    const uint s = sobol_seed(pixel, event, seed);
    const uint index = sobol_index(sample, s);
    // Direction numbers of the second and third dimension, by their primitive polynomials x + 1 and x^2 + x + 1, in reverse.
    uint y = 0, z = 0, y_column = 1, z_column = 1, z_next = 3;
    for (uint bit = 0; bit < 24; bit++) {
        const uint on = (index >> bit) & 1u;
        y ^= on * y_column;
        z ^= on * z_column;
        y_column ^= y_column << 1;
        const uint z_after = z_next ^ z_column ^ (z_column << 2);
        z_column = z_next;
        z_next = z_after;
    }
    y &= 0xffffffu;
    z &= 0xffffffu;
    return (real3)(sobol_real(index, sobol_hash(s + 1)), sobol_real(y, sobol_hash(s + 2)), sobol_real(z, sobol_hash(s + 3)));
}

static inline real sobol1(uint2 pixel, uint sample, uint event, uint seed)
{
    const uint s = sobol_seed(pixel, event + SOBOL_SINGLES, seed);
    return sobol_real(sobol_index(sample, s), sobol_hash(s + 1));
}

#endif
