// Orthonormal frames around a normal; shading space has z along the normal.
// In: unit normals, tangents of any length. Out: right-handed frames, always orthonormal.
#ifndef OSLCL_BSDF_FRAME_H
#define OSLCL_BSDF_FRAME_H

#include "bsdf/numeric.h"

typedef struct {
    real3 s, t, n; // unit and perpendicular, in world space
} Frame;

// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017, listing 3: no branch, no pole.
static inline Frame frame_from_normal(real3 n)
{
    real sign = copysign((real)1, n.z);
    real a = -1 / (sign + n.z);
    real b = n.x * n.y * a;
    Frame f;
    f.s = (real3)(1 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    f.t = (real3)(b, sign + n.y * n.y * a, -n.y);
    f.n = n;
    return f;
}

// s along the part of T that is perpendicular to n. Any s when T is zero, not finite, or parallel to n within 1e-3.
static inline Frame frame_from_tangent(real3 n, real3 T)
{
    real3 unit_t = safe_normalize(T);
    real3 s = unit_t - n * dot(n, unit_t);
    real len2 = dot(s, s);
    if (!(len2 > (real)1e-6)) return frame_from_normal(n);
    Frame f;
    s /= sqrt(len2);
    // A second step of Gram-Schmidt removes what cancellation left along n.
    f.s = normalize(s - n * dot(n, s));
    f.t = cross(n, f.s);
    f.n = n;
    return f;
}

static inline real3 to_local(const Frame *f, real3 v) { return (real3)(dot(v, f->s), dot(v, f->t), dot(v, f->n)); }
static inline real3 to_world(const Frame *f, real3 v) { return f->s * v.x + f->t * v.y + f->n * v.z; }

#endif
