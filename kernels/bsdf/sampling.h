// Transformations of uniform random numbers, and the bits that say what a sampled direction did.
// In: numbers in [0,1). Out: points and directions in shading space (z along the normal).
#ifndef OSLCL_BSDF_SAMPLING_H
#define OSLCL_BSDF_SAMPLING_H

#include "bsdf/numeric.h"

// Results of bsdf_sample: one of REFLECT and TRANSMIT, and one of DELTA, DIFFUSE and GLOSSY.
#define SAMPLE_REFLECT 1   // stays on the side of wo
#define SAMPLE_TRANSMIT 2  // goes to the other side
#define SAMPLE_DELTA 4     // the only direction: no light sampling can find it, pdf is 0
#define SAMPLE_STRAIGHT 8  // wi = -wo exactly: the surface was not there
#define SAMPLE_DIFFUSE 16  // the lobe covers the hemisphere
#define SAMPLE_GLOSSY 32   // the lobe is concentrated

// Uniform on the unit disk, continuous in u. Shirley and Chiu, "A Low Distortion Map Between Disk and Square", 1997.
// Returns x, y and the radius.
static inline real3 sample_disk(real u1, real u2)
{
    real a = 2 * u1 - 1, b = 2 * u2 - 1;
    int wide = fabs(a) > fabs(b);
    real r = wide ? a : b;
    if (r == 0) return (real3)(0);
    real s, c;
    m_sincos((real)(PI / 4) * (wide ? b / a : a / b), &s, &c);
    return (real3)(r * (wide ? c : s), r * (wide ? s : c), fabs(r));
}

// In proportion to cos: pdf z / pi. Malley's method.
static inline real3 sample_cosine(real u1, real u2)
{
    real3 d = sample_disk(u1, u2);
    return (real3)(d.x, d.y, safe_sqrt((1 - d.z) * (1 + d.z)));
}

// The inverse of erf, relative error below 4e-7. Giles, "Approximating the erfinv Function", GPU Computing Gems, 2010,
// table 5. Arguments within 6e-8 of +-1 are taken as that: the tail beyond has no weight in a picture.
static inline real erf_inverse(real x)
{
    x = clamp(x, (real)-0.99999994, (real)0.99999994);
    real w = -m_log((1 - x) * (1 + x));
    real p;
    if (w < 5) {
        w -= (real)2.5;
        p = (real)2.81022636e-08;
        p = (real)3.43273939e-07 + p * w;
        p = (real)-3.5233877e-06 + p * w;
        p = (real)-4.39150654e-06 + p * w;
        p = (real)0.00021858087 + p * w;
        p = (real)-0.00125372503 + p * w;
        p = (real)-0.00417768164 + p * w;
        p = (real)0.246640727 + p * w;
        p = (real)1.50140941 + p * w;
    } else {
        w = sqrt(w) - 3;
        p = (real)-0.000200214257;
        p = (real)0.000100950558 + p * w;
        p = (real)0.00134934322 + p * w;
        p = (real)-0.00367342844 + p * w;
        p = (real)0.00573950773 + p * w;
        p = (real)-0.0076224613 + p * w;
        p = (real)0.00943887047 + p * w;
        p = (real)1.00167406 + p * w;
        p = (real)2.83297682 + p * w;
    }
    return p * x;
}

#endif
