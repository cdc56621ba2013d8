// Sums that lose nothing to rounding: Kahan, "Pracniques: Further Remarks on Reducing Truncation Errors", 1965. What a sum has lost,
// which is to be subtracted from it, is kept beside it.
#ifndef OSLCL_COMPENSATED_H
#define OSLCL_COMPENSATED_H

#include "real.h"

// Relaxed arithmetic would find that nothing can be lost; it may not look behind what is volatile.
#ifdef __FAST_RELAXED_MATH__
#define AS_ROUNDED volatile
#else
#define AS_ROUNDED
#endif

static inline void add_compensated(real4 *sum, real4 *lost, real4 x)
{
    const real4 before = *sum;
    const real4 y = x - *lost;
    AS_ROUNDED real4 t = before + y;
    AS_ROUNDED real4 grown = t - before;
    *lost = grown - y;
    *sum = t;
}

#endif
