// Cell noise: constant within each unit cell, in [0, 1], unrelated between cells; and its periodic form.
//
// pnoise("cell", p, period) follows the specification. The reference implementation turns it into cellnoise with the
// period's first component as one more coordinate when the kind is a constant (special.txt shows hashes of
// (0, 0, 0, 2) and (5, -8, 0, 2)): not copied.
#ifndef OSLCL_OSL_NOISE_CELL_H
#define OSLCL_OSL_NOISE_CELL_H

#include "osl/noise.h"
#include "osl/noise_words.h"

static inline uint cell_word(real x) { return (uint)(int)floor(x); }

// The cell of x modulo floor(period), at least 1.
static inline uint cell_wrap(real x, real period) { return noise_cell_periodic(x, period).lower; }

NOISE_OF_WORDS(cell, cell_word, cell_wrap)

#endif
