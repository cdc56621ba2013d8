// The directional albedo of a lobe, per channel, by a small fixed rule: the mean of f |cos| / pdf over 24 directions that the
// lobe's own sampling takes. layer() weighs its base by one minus this (docs/adr/0016).
// In: a lobe's NAME_sample. Out: 0..1 per channel. Of microfacets the error is 0.01 in the mean and below 0.04 (roughness 1, total
// reflection); tests/tests/bsdf.rs holds each lobe to its own bound, docs/closures.md lists them.
#ifndef OSLCL_BSDF_ALBEDO_H
#define OSLCL_BSDF_ALBEDO_H

#include "bsdf/sampling.h"

#define ALBEDO_POINTS 24

// The k-th point of a lattice of rank 1 (Niederreiter, "Random Number Generation and Quasi-Monte Carlo Methods", 1992, ch. 5): one
// point in each row and column. 7 is the multiplier with the least error over roughness, angle and index of GGX reflection.
static inline real3 albedo_point(int k)
{
    return (real3)((k + (real)0.5) / ALBEDO_POINTS, (k * 7 % ALBEDO_POINTS + (real)0.5) / ALBEDO_POINTS, (real)0.5);
}

// Defines NAME_albedo3 for a lobe whose sampling doesn't choose between kinds of light.
#define ALBEDO_BY_SAMPLING(NAME)                                                                                        \
    static inline real3 NAME##_albedo3(Lobe l, real3 wo)                                                                \
    {                                                                                                                   \
        real3 sum = (real3)(0);                                                                                         \
        for (int k = 0; k < ALBEDO_POINTS; k++) {                                                                       \
            real3 wi, value;                                                                                            \
            real pdf;                                                                                                   \
            if (NAME##_sample(&l, wo, albedo_point(k), &wi, &value, &pdf)) sum += value;                                \
        }                                                                                                               \
        return fmin(sum / ALBEDO_POINTS, (real3)(1));                                                                   \
    }

// Defines NAME_albedo3 for a lobe whose NAME_albedo is exact and the same in all channels.
#define ALBEDO_IS_EXACT(NAME)                                                                                           \
    static inline real3 NAME##_albedo3(Lobe l, real3 wo) { return (real3)(NAME##_albedo(&l, wo)); }

#endif
