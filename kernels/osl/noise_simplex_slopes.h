// The slopes of simplex noise: osl_noise_simplex_slopes_m_* for float results, and osl_noise_simplex_slopes_triple_m_*. See
// osl/noise_slopes.h.
#ifndef OSLCL_OSL_NOISE_SIMPLEX_SLOPES_H
#define OSLCL_OSL_NOISE_SIMPLEX_SLOPES_H

#include "osl/noise_simplex_d.h"
#include "osl/noise_slopes.h"

NOISE_SLOPES_PLAIN(noise_simplex, slopes, f, real)
NOISE_SLOPES_PLAIN(noise_simplex, slopes_triple, v, real3)

#endif
