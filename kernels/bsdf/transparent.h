// transparent() and transparent_bsdf(): light passes straight on, as if there were no surface.
#ifndef OSLCL_BSDF_TRANSPARENT_H
#define OSLCL_BSDF_TRANSPARENT_H

#include "bsdf/albedo.h"
#include "bsdf/sampling.h"
#include "lobe.h"

static inline Lobe closure_transparent(void)
{
    Lobe l = {0};
    l.type = LOBE_TRANSPARENT;
    l.flags = LOBE_TRANSMITS;
    return l;
}

static inline Lobe closure_transparent_bsdf(void) { return closure_transparent(); }

static inline real transparent_albedo(const Lobe *l, real3 wo) { return 1; }

static inline int transparent_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    *wi = -wo;
    *value = (real3)(1);
    *pdf = 0;
    return SAMPLE_TRANSMIT | SAMPLE_DELTA | SAMPLE_STRAIGHT;
}

ALBEDO_IS_EXACT(transparent)

#endif
