// The slopes of Gabor noise and of its periodic form by its point: osl_noise_gabor_slopes_m_* for float results, and
// osl_noise_gabor_slopes_triple_m_*. The filter counts as constant. See osl/noise_slopes.h.
#ifndef OSLCL_OSL_NOISE_GABOR_SLOPES_H
#define OSLCL_OSL_NOISE_GABOR_SLOPES_H

#include "osl/noise_gabor.h"
#include "osl/noise_slopes.h"

#define GABOR_SLOPES(ROW, R, TYPE)                                                                                     \
    NOISE_SLOPES(noise_gabor, ROW, R, TYPE, vvvivffi,                                                                  \
                 (real3 p, real3 dx, real3 dy, int kind, real3 along, real bandwidth, real impulses, int filtered),    \
                 (p, dx, dy, kind, along, bandwidth, impulses, filtered), 3)                                           \
    NOISE_SLOPES(pnoise_gabor, ROW, R, TYPE, vvvvivffi,                                                                \
                 (real3 p, real3 dx, real3 dy, real3 period, int kind, real3 along, real bandwidth, real impulses,     \
                  int filtered),                                                                                       \
                 (p, dx, dy, period, kind, along, bandwidth, impulses, filtered), 3)

GABOR_SLOPES(slopes, f, real)
GABOR_SLOPES(slopes_triple, v, real3)

#endif
