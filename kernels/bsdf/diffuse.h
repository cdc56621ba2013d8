// diffuse(N): Lambert's reflection, f = 1/pi.
// Also what subsurface scattering comes to when light leaves where it entered: subsurface_bssrdf(N, albedo, radius, anisotropy) at
// radius 0, and subsurface(eta, g, mfp, albedo) at the shading normal. Their albedo, that of all scattering together, is a factor of the
// weight (ClosureRow::tint); radius and anisotropy don't count (docs/closures.md).
#ifndef OSLCL_BSDF_DIFFUSE_H
#define OSLCL_BSDF_DIFFUSE_H

#include "bsdf/albedo.h"
#include "bsdf/frame.h"
#include "bsdf/sampling.h"
#include "lobe.h"

static inline Lobe closure_diffuse_v(real3 N)
{
    Lobe l = {0};
    l.type = LOBE_DIFFUSE;
    l.flags = LOBE_REFLECTS;
    l.N = safe_normalize(N);
    return l;
}

static inline Lobe closure_subsurface_bssrdf_vvf(real3 N, real3 radius, real anisotropy) { return closure_diffuse_v(N); }

static inline Lobe closure_subsurface_ffv(real3 N, real eta, real g, real3 mfp) { return closure_diffuse_v(N); }

// Whether it is seen from its side; normals that are trusted leave that to the surface.
static inline int diffuse_is_seen(const Lobe *l, real3 wo)
{
#ifdef HAS_TRUSTED_NORMALS
    return 1;
#else
    return dot(l->N, wo) > 0;
#endif
}

static inline real diffuse_albedo(const Lobe *l, real3 wo) { return diffuse_is_seen(l, wo) ? 1 : 0; }

static inline real3 diffuse_eval(const Lobe *l, real3 wo, real3 wi, real *pdf)
{
    real ci = dot(l->N, wi);
    *pdf = diffuse_is_seen(l, wo) && ci > 0 ? ci * (real)INV_PI : 0;
    return (real3)(*pdf);
}

static inline int diffuse_sample(const Lobe *l, real3 wo, real3 u, real3 *wi, real3 *value, real *pdf)
{
    if (!diffuse_is_seen(l, wo)) return 0;
    Frame frame = frame_from_normal(l->N);
    // The disk's axes in the order of the reference's renderer: with its random numbers, the same directions.
    real3 local_wi = sample_cosine(u.x, u.y).yxz;
    if (!(local_wi.z > 0)) return 0;
    *wi = to_world(&frame, local_wi);
    *value = (real3)(1);
    *pdf = local_wi.z * (real)INV_PI;
    return SAMPLE_REFLECT | SAMPLE_DIFFUSE;
}

ALBEDO_IS_EXACT(diffuse)

#endif
