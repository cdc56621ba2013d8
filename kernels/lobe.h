// Between a generated material and the renderer: the lobe it picked, and what it emits.
//
// A material function, its name in Artifact.entry, is
//     void ENTRY(const ShaderGlobals *sg, real pick, ShadeResult *out);
// `pick` is uniform in [0,1), or, where the scene splits paths, LOBE_NUMBER(k): the k-th lobe that is offered, not one at random. It
// calls, for every lobe slot with non-zero weight,
//     Lobe lobe = closure_NAME_CODES(args...);          // kernels/bsdf/NAME.h; CODES as in the table of built-ins
//     lobe_offer(out, &choice, &lobe, weight, wo);      // kernels/bsdf/pick.h; wo = -sg->I
// then lobe_finish(out, &choice), and adds emission, background and holdout itself. String arguments are string ids (strings.h).
#ifndef OSLCL_LOBE_H
#define OSLCL_LOBE_H

#include "real.h"

// Lobe types. HAS_LOBE_<NAME> is defined for those that the scene uses; no code of the others is compiled.
#define LOBE_NONE 0
#define LOBE_DIFFUSE 1
#define LOBE_OREN_NAYAR 2
#define LOBE_TRANSLUCENT 3
#define LOBE_PHONG 4
#define LOBE_WARD 5
#define LOBE_MICROFACET 6
#define LOBE_REFLECTION 7
#define LOBE_REFRACTION 8
#define LOBE_TRANSPARENT 9
#define LOBE_CONDUCTOR 10
#define LOBE_OREN_NAYAR_DIFFUSE 11
#define LOBE_BURLEY_DIFFUSE 12
#define LOBE_DIELECTRIC 13
#define LOBE_GENERALIZED_SCHLICK 14
#define LOBE_SHEEN 15
#define LOBE_CHIANG_HAIR 16
// HAS_LOBE_THIN_FILM is no type: some lobe lies under a thin film.

// Flags of a lobe.
#define LOBE_BECKMANN 1      // else GGX
#define LOBE_REFLECTS 2
#define LOBE_TRANSMITS 4
#define LOBE_BACK 8          // seen from inside
#define LOBE_ZELTNER 16      // sheen, mode 1
#define LOBE_COMPENSATED 32  // oren_nayar_diffuse: energy_compensation

typedef struct {
    int type;      // LOBE_*
    int flags;
    real3 weight;  // colour weight; after picking divided by the probability of the pick
    real3 N;       // unit normal of the lobe, on the viewer's side
    real3 T;       // tangent for anisotropy; need not be normalised or perpendicular; zero: any
    real ax, ay;   // roughness (alpha; Phong: exponent; Oren-Nayar: sigma) along T and across
    real eta;      // relative index of refraction: below the surface over above, as the shader gave it
    real3 c0, c1;  // conductor: index of refraction and extinction; dielectrics: tints; hair: tints of R and TT
#if defined(HAS_LOBE_GENERALIZED_SCHLICK) || defined(HAS_LOBE_CHIANG_HAIR)
    real3 c2, c3;  // Schlick: f0 and f90; hair: tint of TRT, absorption
#endif
#ifdef HAS_LOBE_GENERALIZED_SCHLICK
    real exponent; // of Schlick's curve
#endif
#ifdef HAS_LOBE_CHIANG_HAIR
    real3 c4, c5;  // longitudinal and azimuthal roughness of R, TT, TRT
#endif
#ifdef HAS_LOBE_THIN_FILM
    real film, film_ior; // thickness in nanometres, 0: none
#endif
} Lobe;

typedef struct {
    Lobe lobe;        // type LOBE_NONE: nothing scatters
    real3 emission;   // radiance towards the viewer, W / (m^2 sr) per channel, whichever side that is on: see emitted
    real3 background; // radiance of the environment in direction I
    real3 holdout;    // weight of holdout, 0..1 per channel
#ifdef HAS_SHARED_CUBES
    real rest;        // what the choice of the lobe left of `pick`, uniform in [0,1); set to `pick` by the caller
#endif
#ifdef HAS_SPLIT_LOBES
    uint offered;     // how many lobes there were to take, if one was taken by number; set to 0 by the caller
#endif
} ShadeResult;

// What of it is seen from a side that does not emit, or from one that does.
static inline real3 emitted(const ShadeResult *r, int dark_side) { return dark_side ? (real3)(0) : r->emission; }

// Running state of the weighted choice among the offered lobes.
typedef struct {
    real u;      // uniform in [0,1), rescaled at each step
    real total;  // sum of the importances so far
    real chosen; // importance of the lobe in hand
} LobeChoice;

// A lobe by its number: u stays at LOBE_NUMBER(k), total is the number of lobes so far, chosen stays 0.
#define LOBE_NUMBER(k) ((real)((k) + 1u))

#endif
