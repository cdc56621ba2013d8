// Hash noise: a value in [0, 1] for each 32-bit float, unrelated between floats; and its periodic form.
//
// Coordinates are rounded to float first in f64 too, and periods are taken in float, so that both precisions agree.
#ifndef OSLCL_OSL_NOISE_HASH_H
#define OSLCL_OSL_NOISE_HASH_H

#include "osl/noise.h"
#include "osl/noise_words.h"

static inline uint hash_word(real x) { return hash_bits(x); }

// x modulo floor(period), at least 1.
static inline uint hash_wrap(real x, real period) {
    float p = period >= 1 ? floor((float)period) : 1;
    float s = (float)x;
    return as_uint(fma(-p, floor(s / p), s));
}

NOISE_OF_WORDS(hash, hash_word, hash_wrap)

#endif
