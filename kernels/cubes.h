// Random numbers as the reference implementation's testrender takes them, so that pictures can be compared sample by sample: each
// event of a path has one cube, three dimensions of Sobol's sequence, which its light and its next direction share. Scrambling as
// in random.h; seeds by the finaliser of C. Wellons, "Hash Prospector", 2018.
//
// In: pixel, sample, event. Out: words of random bits. It must not know path state.
#ifndef OSLCL_CUBES_H
#define OSLCL_CUBES_H

#include "random.h"

// Events of a path: 0 is the camera's, then one a bounce. From here on single numbers beside the cubes.
#define CUBE_SINGLES 0x400000u

static inline uint cube_hash(uint x)
{
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0xd35a2d97u;
    return x ^ (x >> 15);
}

// Of a number whose bits stand in reverse; they come back in order.
static inline uint owen_scramble(uint x, uint seed) { return reverse_bits(scramble_reversed((uint4)(x), (uint4)(seed)).x); }

static inline uint cube_seed(uint2 pixel, uint event, uint seed)
{
    return (((pixel.x & 2047u) << 22 | (pixel.y & 2047u) << 11) + 4 * event) ^ (seed * 0x9e3779b9u);
}

// Which point of the sequence: all samples of a pixel in another order for each event. Bits in reverse.
static inline uint cube_index(uint sample, uint seed)
{
    return owen_scramble(reverse_bits(sample), cube_hash(seed)) & 0xffffffu;
}

// Of each word random_reals takes 24 bits, as testrender does; the choice among many lights takes those below as well.
static inline uint3 cube3(uint2 pixel, uint sample, uint event, uint seed)
{
    const uint s = cube_seed(pixel, event, seed);
    const uint index = cube_index(sample, s);
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
    return (uint3)(owen_scramble(index, cube_hash(s + 1)), owen_scramble(y, cube_hash(s + 2)), owen_scramble(z, cube_hash(s + 3)));
}

static inline uint cube1(uint2 pixel, uint sample, uint event, uint seed)
{
    const uint s = cube_seed(pixel, event + CUBE_SINGLES, seed);
    return owen_scramble(cube_index(sample, s), cube_hash(s + 1));
}

#endif
