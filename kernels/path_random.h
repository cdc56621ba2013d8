// The random numbers of a path, by the sampler that is chosen.
// In: a slot with its sample number, a block of random.h. Out: four words of 32 bits, or four numbers in [0,1).
#ifndef OSLCL_PATH_RANDOM_H
#define OSLCL_PATH_RANDOM_H

#include "context.h"
#include "random.h"
#ifdef HAS_SHARED_CUBES
#include "cubes.h"
#endif

// Turns of a sample share the camera's numbers and have others behind.
static inline uint path_seed(const Context *c, uint slot, uint block)
{
    const uint seed = setting(c, SETTING_seed);
#ifdef PATHU_turn
    if (block != BLOCK_CAMERA) return seed + path_turn(c, slot) * 0x9e3779b9u;
#endif
    return seed;
}

static inline PixelSequence path_sequence(const Context *c, uint slot, uint block)
{
    return pixel_sequence(path_pixel(c, slot), block, path_seed(c, slot, block));
}

// For those who have the sequence already.
static inline uint4 path_point(const Context *c, uint slot, const PixelSequence *sequence)
{
    const uint sample = path_get_uint(c, PATHU_sample, slot);
#ifdef HAS_SHARED_CUBES
    // A bounce has one cube for the light's direction and its own: they find light in different ways, and each is even.
    const uint width = setting(c, SETTING_width), block = sequence->block, seed = sequence->seed;
    const uint2 at = (uint2)(sequence->pixel % width, sequence->pixel / width);
    return (uint4)(cube3(at, sample, (block + 1) / 2, seed), cube1(at, sample, block, seed));
#else
    return sequence_point(sequence, sample);
#endif
}

static inline uint4 path_random_bits(const Context *c, uint slot, uint block)
{
    const PixelSequence sequence = path_sequence(c, slot, block);
    return path_point(c, slot, &sequence);
}

static inline real4 path_random(const Context *c, uint slot, uint block)
{
    return random_reals(path_random_bits(c, slot, block));
}

#endif
