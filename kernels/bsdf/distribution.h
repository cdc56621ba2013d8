// Distributions of microfacet normals: GGX (Trowbridge-Reitz) and Beckmann, anisotropic, with Smith masking of each
// direction on its own. In: unit vectors in shading space, a Lobe's ax, ay and LOBE_BECKMANN.
// Out: densities per solid angle. It knows nothing of Fresnel's laws.
//
// Masking and shadowing multiply, G = G1(wo) G1(wi) ("separable"): so do Mitsuba 3's roughconductor and
// roughdielectric, by which the reference pictures were made. The height-correlated form would be brighter when rough.
//
// A program that knows that no lobe of the scene is Beckmann may define NO_BECKMANN: its code is not compiled then.
#ifndef OSLCL_BSDF_DISTRIBUTION_H
#define OSLCL_BSDF_DISTRIBUTION_H

#include "bsdf/frame.h"
#include "bsdf/sampling.h"
#include "lobe.h"
#include "strings.h"

// Below this roughness in both directions a lobe is its delta limit, and ax = ay = 0 says so: f32 directions do not
// resolve it. When only one roughness is smaller, it is taken as this.
#define ALPHA_MIN 1e-4
// Rougher than this looks the same, and squares have to stay in range.
#define ALPHA_MAX 100

// Stores the roughness into a lobe; NaN is 0.
static inline void set_roughness(Lobe *l, real ax, real ay)
{
    ax = fmin(fmax(ax, (real)0), (real)ALPHA_MAX);
    ay = fmin(fmax(ay, (real)0), (real)ALPHA_MAX);
    int delta = ax < (real)ALPHA_MIN && ay < (real)ALPHA_MIN;
    l->ax = delta ? 0 : fmax(ax, (real)ALPHA_MIN);
    l->ay = delta ? 0 : fmax(ay, (real)ALPHA_MIN);
}

// The flag of a distribution's name. "default" is Beckmann, as in OSL's testrender; unknown names are GGX.
static inline int distribution_flag(int name)
{
    return name == STR_BECKMANN || name == STR_DEFAULT ? LOBE_BECKMANN : 0;
}

// The shading space of a lobe: along its tangent only if that matters.
static inline Frame lobe_frame(const Lobe *l)
{
    return l->ax == l->ay ? frame_from_normal(l->N) : frame_from_tangent(l->N, l->T);
}

// Beckmann's D(m). Walter et al. 2007, eq. 25, anisotropic as in Heitz, "Understanding the Masking-Shadowing Function",
// JCGT 3(2), 2014, eq. 83.
static inline real beckmann_D(real ax, real ay, real3 m)
{
    real z2 = m.z * m.z;
    real e = m_exp(-(sqr(m.x / ax) + sqr(m.y / ay)) / z2);
    return e > 0 ? e / ((real)PI * ax * ay * z2 * z2) : 0;
}

// D(m), m.z > 0.
static inline real ndf_D(const Lobe *l, real3 m)
{
#ifndef NO_BECKMANN
    if (l->flags & LOBE_BECKMANN) return beckmann_D(l->ax, l->ay, m);
#endif
    // Heitz 2014, eq. 85, multiplied out: no division by cos.
    real q = sqr(m.x / l->ax) + sqr(m.y / l->ay) + sqr(m.z);
    return 1 / ((real)PI * l->ax * l->ay * q * q);
}

// Projected area of the visible microfacets, w.z (1 + Lambda(w)), for w.z >= 0. Smith's G1 is w.z over it; alone it
// stays finite and non-zero at grazing incidence. Heitz 2014, eq. 72 (GGX) and 70 (Beckmann, by the exact erf).
static inline real ndf_projected(const Lobe *l, real3 w)
{
    real s2 = sqr(w.x * l->ax) + sqr(w.y * l->ay);
#ifndef NO_BECKMANN
    if (l->flags & LOBE_BECKMANN) {
        real s = sqrt(s2);
        if (w.z > 5 * s) return w.z;
        real a = w.z / s;
        return (real)0.5 * (w.z * (1 + erf(a)) + s * m_exp(-a * a) * (real)0.56418958354775628695);
    }
#endif
    return (real)0.5 * (w.z + sqrt(w.z * w.z + s2));
}

// A visible normal of unit GGX seen from unit v, v.z >= 0, in the stretched space.
// Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023, listing 3. Not normalised.
static inline real3 ggx_visible_normal(real3 v, real u1, real u2)
{
    real s, c;
    m_sincos((real)(2 * PI) * u1, &s, &c);
    real hz = (1 - u2) * (1 + v.z);
    real z = hz - v.z;
    real r = safe_sqrt((1 - z) * (hz + (1 - v.z)));
    return (real3)(r * c + v.x, r * s + v.y, hz);
}

#ifndef NO_BECKMANN
// A visible normal of unit Beckmann seen from unit v, in the stretched space. Not normalised.
// The slope x towards v has the density (v.z - x sin) exp(-x^2), x < cot, the other is normal. The distribution function
// of x is inverted over b = erf(x), where its slope is (v.z - x sin)/2 and Newton's steps converge fast:
// Jakob, "An Improved Visible Normal Sampling Routine for the Beckmann Distribution", 2014.
static inline real3 beckmann_visible_normal(real3 v, real u1, real u2)
{
    const real inv_2_sqrt_pi = 0.28209479177387814347;
    real sin_v = sqrt(v.x * v.x + v.y * v.y);
    if (sin_v < (real)1e-6) {
        real s, c;
        m_sincos((real)(2 * PI) * u2, &s, &c);
        real r = sqrt(-m_log(1 - u1));
        return (real3)(r * c, r * s, 1);
    }
    // Beyond 3.8 erf is 1 in f32; the tail's weight is below 1e-7.
    real cot = fmin(v.z / sin_v, (real)3.8);
    real hi = erf(cot), lo = -1;
    real top = (real)0.5 * v.z * (1 + hi) + sin_v * inv_2_sqrt_pi * m_exp(-cot * cot);
    real target = u1 * top;
    real b = lo + (hi - lo) * u1;
    real x = 0;
    for (int i = 0; i < 12; i++) {
        x = erf_inverse(b);
        real error = (real)0.5 * v.z * (1 + b) + sin_v * inv_2_sqrt_pi * m_exp(-x * x) - target;
        if (error > 0) hi = b;
        else lo = b;
        if (fabs(error) < 4 * REAL_EPSILON * top) break;
        real next = b - 2 * error / (v.z - x * sin_v);
        if (!(next > lo && next < hi)) next = (real)0.5 * (lo + hi);
        if (fabs(next - b) < REAL_EPSILON) break;
        b = next;
    }
    real y = erf_inverse(2 * u2 - 1);
    real cp = v.x / sin_v, sp = v.y / sin_v;
    return (real3)(sp * y - cp * x, -sp * x - cp * y, 1);
}
#endif

// A normal with the density D(m) dot(wo, m) / ndf_projected(wo), wo.z > 0: Heitz, "Sampling the GGX Distribution of
// Visible Normals", JCGT 7(4), 2018, sec. 3, whose stretching holds for Beckmann as well.
static inline real3 ndf_sample(const Lobe *l, real3 wo, real u1, real u2)
{
    real3 v = normalize((real3)(wo.x * l->ax, wo.y * l->ay, wo.z));
    real3 h;
#ifndef NO_BECKMANN
    if (l->flags & LOBE_BECKMANN) h = beckmann_visible_normal(v, u1, u2);
    else
#endif
        h = ggx_visible_normal(v, u1, u2);
    return safe_normalize((real3)(h.x * l->ax, h.y * l->ay, fmax(h.z, (real)1e-12)));
}

// Reflection by the facets, without Fresnel's factor. Returns f |cos|; *pdf of sampling visible normals; *m the normal.
// With P = ndf_projected and G1 = z/P, Walter et al. 2007, eq. 20 and eq. 24 become D zi / (4 Po Pi) and D / (4 Po).
static inline real ndf_reflect(const Lobe *l, real3 wo, real3 wi, real3 *m, real *pdf)
{
    *pdf = 0;
    if (!(wo.z > 0 && wi.z > 0)) return 0;
    *m = normalize(wo + wi);
    *pdf = ndf_D(l, *m) / (4 * ndf_projected(l, wo));
    return *pdf * wi.z / ndf_projected(l, wi);
}

// Refraction's directions are computed with this eta: nearer to 1, all of the lobe lies within the rounding of the
// directions. The side above 1 is taken, which has no total reflection; Fresnel's factor still uses the true eta.
static inline real refraction_eta(real eta) { return fabs(eta - 1) < (real)1e-3 ? (real)1.001 : eta; }

// Refraction by the facets without Fresnel's factor, as ndf_reflect; wi.z < 0. Walter et al. 2007, eq. 21 and eq. 17,
// with eta^2 in the numerator: radiance is not scaled by the change of index, see refraction.h.
static inline real ndf_refract(const Lobe *l, real3 wo, real3 wi, real eta, real3 *m, real *pdf)
{
    *pdf = 0;
    if (!(wo.z > 0 && wi.z < 0)) return 0;
    eta = refraction_eta(eta);
    real3 h = -(wo + wi * eta);
    real len2 = dot(h, h);
    h *= (h.z < 0 ? -1 : 1) / sqrt(len2);
    real co = dot(wo, h), ci = -dot(wi, h);
    if (!(co > 0 && ci > 0 && h.z > 0)) return 0;
    *m = h;
    *pdf = ndf_D(l, h) * co / ndf_projected(l, wo) * (eta * eta * ci / len2);
    return *pdf * -wi.z / ndf_projected(l, -wi);
}

#endif
