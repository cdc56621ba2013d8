// dielectric_bsdf(N, U, reflection_tint, transmission_tint, roughness_x, roughness_y, ior, distribution, "thinfilm_thickness",
// float, "thinfilm_ior", float): a smooth or rough interface. ior is that of the inside over the outside; from inside (backfacing)
// it turns round by itself. The roughness is alpha, as MaterialX's nodes hand it over. Fresnel's law of fresnel.h, the facets of
// facets.h; with a film that of thin_film.h.
#ifndef OSLCL_BSDF_DIELECTRIC_H
#define OSLCL_BSDF_DIELECTRIC_H

#include "bsdf/facets.h"
#include "bsdf/thin_film.h"

static inline Lobe closure_dielectric_bsdf_vvvvfffs(int backfacing, real3 N, real3 T, real3 reflection, real3 transmission,
                                                    real ax, real ay, real ior, int dist)
{
    return facets_lobe(LOBE_DIELECTRIC, backfacing, N, T, reflection, transmission, ax, ay, ior, dist);
}

#ifdef HAS_LOBE_THIN_FILM
// The film lies outside. From inside the stack reflects as it does from outside at the refracted angle: it absorbs nothing.
static inline real3 facets_film(const Lobe *l, real c, real3 n)
{
    if (l->flags & LOBE_BACK) {
        real s2 = (1 - c) * (1 + c) / sqr(l->eta);
        if (!(s2 < 1)) return (real3)(1);
        c = sqrt(1 - s2);
    }
    return film_reflectance(c, l->film, l->film_ior, n, (real3)(0));
}
#endif

static inline real3 dielectric_fresnel(const Lobe *l, real c)
{
#ifdef HAS_LOBE_THIN_FILM
    if (l->film > 0) return facets_film(l, c, (real3)(l->flags & LOBE_BACK ? 1 / l->eta : l->eta));
#endif
    return (real3)(fresnel_dielectric(c, l->eta));
}

FACETS(dielectric)

#endif
