// Evaluation, sampling and albedo of a lobe of any type. Only the lobes with HAS_LOBE_<NAME> are compiled.
// In: a Lobe; unit directions wo and wi away from the surface, in world space; u uniform in [0,1)^3.
// Out: f |cos| without the lobe's weight, densities per solid angle.
// wo below the lobe's normal is black. It knows nothing of queues, path state or pixels.
#ifndef OSLCL_BSDF_H
#define OSLCL_BSDF_H

#include "bsdf/sampling.h"
#include "lobe.h"

#ifdef HAS_LOBE_DIFFUSE
#include "bsdf/diffuse.h"
#endif
#ifdef HAS_LOBE_OREN_NAYAR
#include "bsdf/oren_nayar.h"
#endif
#ifdef HAS_LOBE_TRANSLUCENT
#include "bsdf/translucent.h"
#endif
#ifdef HAS_LOBE_PHONG
#include "bsdf/phong.h"
#endif
#ifdef HAS_LOBE_WARD
#include "bsdf/ward.h"
#endif
#ifdef HAS_LOBE_MICROFACET
#include "bsdf/microfacet.h"
#endif
#ifdef HAS_LOBE_REFLECTION
#include "bsdf/reflection.h"
#endif
#ifdef HAS_LOBE_REFRACTION
#include "bsdf/refraction.h"
#endif
#ifdef HAS_LOBE_TRANSPARENT
#include "bsdf/transparent.h"
#endif
#ifdef HAS_LOBE_CONDUCTOR
#include "bsdf/conductor.h"
#endif
#ifdef HAS_LOBE_OREN_NAYAR_DIFFUSE
#include "bsdf/oren_nayar_diffuse.h"
#endif
#ifdef HAS_LOBE_BURLEY_DIFFUSE
#include "bsdf/burley_diffuse.h"
#endif
#ifdef HAS_LOBE_DIELECTRIC
#include "bsdf/dielectric.h"
#endif
#ifdef HAS_LOBE_GENERALIZED_SCHLICK
#include "bsdf/generalized_schlick.h"
#endif
#ifdef HAS_LOBE_SHEEN
#include "bsdf/sheen.h"
#endif
#ifdef HAS_LOBE_CHIANG_HAIR
#include "bsdf/chiang_hair.h"
#endif

// Whether light sampling can't find the lobe: its f is 0 for all pairs of directions but one.
static inline int bsdf_is_delta(const Lobe *l)
{
    switch (l->type) {
    case LOBE_REFLECTION:
    case LOBE_REFRACTION:
    case LOBE_TRANSPARENT: return 1;
    case LOBE_WARD:
    case LOBE_MICROFACET:
    case LOBE_CONDUCTOR:
    case LOBE_DIELECTRIC:
    case LOBE_GENERALIZED_SCHLICK: return l->ax <= 0;
    default: return 0;
    }
}

// f |cos| for light from wi to wo; *pdf = density with which bsdf_sample takes wi. Both are 0 for a delta lobe.
static inline real3 bsdf_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)
{
    *pdf = 0;
    switch (l->type) {
#ifdef HAS_LOBE_DIFFUSE
    case LOBE_DIFFUSE: return diffuse_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_OREN_NAYAR
    case LOBE_OREN_NAYAR: return oren_nayar_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_TRANSLUCENT
    case LOBE_TRANSLUCENT: return translucent_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_PHONG
    case LOBE_PHONG: return phong_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_WARD
    case LOBE_WARD: return ward_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_MICROFACET
    case LOBE_MICROFACET: return microfacet_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_CONDUCTOR
    case LOBE_CONDUCTOR: return conductor_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_OREN_NAYAR_DIFFUSE
    case LOBE_OREN_NAYAR_DIFFUSE: return oren_nayar_diffuse_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_BURLEY_DIFFUSE
    case LOBE_BURLEY_DIFFUSE: return burley_diffuse_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_DIELECTRIC
    case LOBE_DIELECTRIC: return dielectric_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_GENERALIZED_SCHLICK
    case LOBE_GENERALIZED_SCHLICK: return generalized_schlick_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_SHEEN
    case LOBE_SHEEN: return sheen_eval(l, wo, wi, pdf);
#endif
#ifdef HAS_LOBE_CHIANG_HAIR
    case LOBE_CHIANG_HAIR: return chiang_hair_eval(l, wo, wi, pdf);
#endif
    default: return (real3)(0);
    }
}

// Takes a direction wi. Returns SAMPLE_* bits, or 0 when the path ends here; *value = f |cos| / pdf (of a delta lobe its
// weight), *pdf as bsdf_eval gives it. When 0 is returned the outputs mean nothing.
static inline int bsdf_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    switch (l->type) {
#ifdef HAS_LOBE_DIFFUSE
    case LOBE_DIFFUSE: return diffuse_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_OREN_NAYAR
    case LOBE_OREN_NAYAR: return oren_nayar_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_TRANSLUCENT
    case LOBE_TRANSLUCENT: return translucent_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_PHONG
    case LOBE_PHONG: return phong_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_WARD
    case LOBE_WARD: return ward_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_MICROFACET
    case LOBE_MICROFACET: return microfacet_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_REFLECTION
    case LOBE_REFLECTION: return reflection_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_REFRACTION
    case LOBE_REFRACTION: return refraction_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_TRANSPARENT
    case LOBE_TRANSPARENT: return transparent_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_CONDUCTOR
    case LOBE_CONDUCTOR: return conductor_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_OREN_NAYAR_DIFFUSE
    case LOBE_OREN_NAYAR_DIFFUSE: return oren_nayar_diffuse_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_BURLEY_DIFFUSE
    case LOBE_BURLEY_DIFFUSE: return burley_diffuse_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_DIELECTRIC
    case LOBE_DIELECTRIC: return dielectric_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_GENERALIZED_SCHLICK
    case LOBE_GENERALIZED_SCHLICK: return generalized_schlick_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_SHEEN
    case LOBE_SHEEN: return sheen_sample(l, wo, u, wi, value, pdf);
#endif
#ifdef HAS_LOBE_CHIANG_HAIR
    case LOBE_CHIANG_HAIR: return chiang_hair_sample(l, wo, u, wi, value, pdf);
#endif
    default: return 0;
    }
}

// An estimate of the share of light that the lobe scatters to wo, in [0,1]: 0 only if that is 0. For choosing lobes.
static inline real bsdf_albedo(const Lobe *l, real3 wo)
{
    switch (l->type) {
#ifdef HAS_LOBE_DIFFUSE
    case LOBE_DIFFUSE: return diffuse_albedo(l, wo);
#endif
#ifdef HAS_LOBE_OREN_NAYAR
    case LOBE_OREN_NAYAR: return oren_nayar_albedo(l, wo);
#endif
#ifdef HAS_LOBE_TRANSLUCENT
    case LOBE_TRANSLUCENT: return translucent_albedo(l, wo);
#endif
#ifdef HAS_LOBE_PHONG
    case LOBE_PHONG: return phong_albedo(l, wo);
#endif
#ifdef HAS_LOBE_WARD
    case LOBE_WARD: return ward_albedo(l, wo);
#endif
#ifdef HAS_LOBE_MICROFACET
    case LOBE_MICROFACET: return microfacet_albedo(l, wo);
#endif
#ifdef HAS_LOBE_REFLECTION
    case LOBE_REFLECTION: return reflection_albedo(l, wo);
#endif
#ifdef HAS_LOBE_REFRACTION
    case LOBE_REFRACTION: return refraction_albedo(l, wo);
#endif
#ifdef HAS_LOBE_TRANSPARENT
    case LOBE_TRANSPARENT: return transparent_albedo(l, wo);
#endif
#ifdef HAS_LOBE_CONDUCTOR
    case LOBE_CONDUCTOR: return conductor_albedo(l, wo);
#endif
#ifdef HAS_LOBE_OREN_NAYAR_DIFFUSE
    case LOBE_OREN_NAYAR_DIFFUSE: return oren_nayar_diffuse_albedo(l, wo);
#endif
#ifdef HAS_LOBE_BURLEY_DIFFUSE
    case LOBE_BURLEY_DIFFUSE: return burley_diffuse_albedo(l, wo);
#endif
#ifdef HAS_LOBE_DIELECTRIC
    case LOBE_DIELECTRIC: return dielectric_albedo(l, wo);
#endif
#ifdef HAS_LOBE_GENERALIZED_SCHLICK
    case LOBE_GENERALIZED_SCHLICK: return generalized_schlick_albedo(l, wo);
#endif
#ifdef HAS_LOBE_SHEEN
    case LOBE_SHEEN: return sheen_albedo(l, wo);
#endif
#ifdef HAS_LOBE_CHIANG_HAIR
    case LOBE_CHIANG_HAIR: return chiang_hair_albedo(l, wo);
#endif
    default: return 0;
    }
}

#endif
