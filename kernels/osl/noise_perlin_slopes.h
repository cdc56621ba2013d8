// The slopes of Perlin's noise and of its periodic form: osl_noise_perlin_slopes_m_* for float results, and
// osl_noise_perlin_slopes_triple_m_*. See osl/noise_slopes.h.
#ifndef OSLCL_OSL_NOISE_PERLIN_SLOPES_H
#define OSLCL_OSL_NOISE_PERLIN_SLOPES_H

#include "osl/noise_perlin_d.h"
#include "osl/noise_slopes.h"

NOISE_SLOPES_PLAIN(noise_perlin, slopes, f, real)
NOISE_SLOPES_PLAIN(noise_perlin, slopes_triple, v, real3)
NOISE_SLOPES_PERIODIC(pnoise_perlin, slopes, f, real)
NOISE_SLOPES_PERIODIC(pnoise_perlin, slopes_triple, v, real3)

#endif
