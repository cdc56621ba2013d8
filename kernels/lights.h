// Lights: emissive triangles, chosen in proportion to their power and sampled by area, and the environment, sampled by a
// map of its radiance. One table for both.
//
// In: random numbers, a point. Out: directions, densities per solid angle. It must not know path state or lobes.
#ifndef OSLCL_LIGHTS_H
#define OSLCL_LIGHTS_H

#include "bsdf/numeric.h"
#include "context.h"
#include "random.h"

// Reals of a light: corner, two edges, radiance, density per area (probability of the choice over the area), and of the
// alias table the share of its cell that is its own.
#define LIGHT_REALS 14
#define LIGHT_RADIANCE 9
#define LIGHT_DENSITY 12
#define LIGHT_SHARE 13
// Words of a light: the other light of its cell, triangle, instance, queue of its material's shade_light or QUEUE_NONE.
#define LIGHT_WORDS 4
#define LIGHT_ALIAS 0
#define LIGHT_TRIANGLE 1
#define LIGHT_INSTANCE 2
#define LIGHT_QUEUE 3
#define ENVIRONMENT_LIGHT 0xffffffffu

typedef struct {
    real3 wi;       // unit, towards the light
    real distance;  // REAL_MAX for the environment
    real3 radiance; // or 1 when the light's shader has to be asked
    real pdf;       // per solid angle, of the choice and of the point together
    uint light;     // index, or ENVIRONMENT_LIGHT
    real u, v;      // where on the triangle
    real slack;     // how far before the place a ray towards it may end, so that the light itself doesn't hide it
} LightSample;

// How far a ray may go that starts where `distance` is counted from. The place of a light is known to a few ulps of its terms, along a
// ray the less the more oblique it is. At most 1e-4 of the distance is left out.
static inline real shadow_length(const LightSample *s)
{
    return s->distance - fmin(s->slack, s->distance * (real)1e-4);
}

// Walker's alias method: one of n cells by bits.x, and a number uniform in [0,1) that decides between the cell's two. A float would
// leave 7 bits for that with the environment's 131,072 cells, and the faintest would be taken far too often: here they are 15, and with
// those that random_reals drops of the other words, 39.
static inline uint alias_cell(uint4 bits, uint n, real *rest)
{
    const uint low = (bits.y & 255u) << 16 | (bits.z & 255u) << 8 | (bits.w & 255u);
    const real x = (real)(bits.x * n) * (real)2.3283064365386962890625e-10 + (real)low * (real)1.3877787807814456755e-17;
    *rest = fmin(x, (real)ONE_MINUS_EPSILON);
    return mul_hi(bits.x, n);
}

// Balance of two ways to find one direction. Veach, "Robust Monte Carlo Methods", 1997, sec. 9.2.4: power heuristic, beta 2.
static inline real mis_weight(real mine, real other)
{
    real r = other / mine;
    return 1 / (1 + r * r);
}

// Whether a side does not emit: surfaces emit on their front side, or on both.
static inline int dark_side(const Context *c, int backfacing)
{
#ifdef HAS_TWO_SIDED_EMISSION
    if (setting(c, SETTING_two_sided)) return 0;
#endif
    return backfacing;
}

// The probability that a sample asks the environment, and that it asks a triangle: even where there are both; 0 where the
// scene does not call for what is compiled in.
#ifdef HAS_ENVIRONMENT_SAMPLING
#define ENVIRONMENT_SHARE constant_real(c, CONSTANT_environment_share)
#define TRIANGLES_SHARE (1 - ENVIRONMENT_SHARE)
#else
#define TRIANGLES_SHARE ((real)1)
#endif

#ifdef HAS_LIGHTS
// The density per solid angle of taking a point of a light at this distance, seen under this |cosine|.
static inline real light_pdf(const Context *c, uint light, real distance, real cosine)
{
    real density = c->lights[LIGHT_REALS * (size_t)light + LIGHT_DENSITY];
    return density * TRIANGLES_SHARE * distance * distance / cosine;
}

// The part of a cell of the alias table that is its own light's.
static inline real light_share(const Context *c, uint cell) { return c->lights[LIGHT_REALS * (size_t)cell + LIGHT_SHARE]; }

static inline int sample_triangle_light(const Context *c, real3 P, uint4 bits, LightSample *s)
{
    if (setting(c, SETTING_lights) == 0) return 0;
    const real4 u = random_reals(bits);
    real x;
    uint cell = alias_cell(bits, setting(c, SETTING_lights), &x);
    s->light = x < light_share(c, cell) ? cell : c->light_words[LIGHT_WORDS * cell + LIGHT_ALIAS];
    __global const real *light = c->lights + LIGHT_REALS * (size_t)s->light;
    real3 v0 = vload3(0, light), e1 = vload3(1, light), e2 = vload3(2, light);
#ifdef HAS_SHARED_CUBES
    // What the choice left of its number is uniform again, so that an even cube gives even points on each light.
    // Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
    const real share = light_share(c, cell);
    x = x < share ? x / share : (x - share) / (1 - share);
    s->u = u.y > x ? (real)0.5 * x : x - (real)0.5 * u.y;
    s->v = u.y > x ? u.y - (real)0.5 * x : (real)0.5 * u.y;
#else
    // Uniform on a triangle: Turk, "Generating Random Points in Triangles", Graphics Gems, 1990.
    real root = sqrt(u.y);
    s->u = root * (1 - u.z);
    s->v = root * u.z;
#endif
    real3 to = v0 + e1 * s->u + e2 * s->v - P;
    real distance2 = dot(to, to);
    s->distance = sqrt(distance2);
    s->wi = to / s->distance;
    real cosine = -dot(s->wi, safe_normalize(cross(e1, e2)));
#ifdef HAS_TWO_SIDED_EMISSION
    if (setting(c, SETTING_two_sided)) cosine = fabs(cosine);
#endif
    if (!(cosine > 0 && distance2 > 0)) return 0;
    s->slack = (max_component(fabs(v0) + fabs(e1) + fabs(e2) + fabs(P)) + s->distance) * (16 * REAL_EPSILON) / cosine;
    s->radiance = vload3(0, light + LIGHT_RADIANCE);
    s->pdf = light[LIGHT_DENSITY] * TRIANGLES_SHARE * distance2 / cosine;
    return is_finite_positive(s->pdf);
}
#endif

#ifdef HAS_ENVIRONMENT_SAMPLING
// The map has equal-area cells: rows are even in z, columns in azimuth. Reals of a cell: probability, share.
#define ENVIRONMENT_CELLS (ENVIRONMENT_WIDTH * ENVIRONMENT_HEIGHT)

static inline real environment_pdf(const Context *c, real3 d)
{
    if (ENVIRONMENT_SHARE == 0) return 0;
    real turn = m_atan2(d.y, d.x) * (real)(0.5 * INV_PI);
    turn = turn < 0 ? turn + 1 : turn;
    uint x = min((uint)(turn * ENVIRONMENT_WIDTH), ENVIRONMENT_WIDTH - 1u);
    uint y = min((uint)(clamp((1 - d.z) * (real)0.5, (real)0, (real)1) * ENVIRONMENT_HEIGHT), ENVIRONMENT_HEIGHT - 1u);
    real p = c->environment_cells[2 * (y * ENVIRONMENT_WIDTH + x)];
    return p * (real)(ENVIRONMENT_CELLS * 0.25 * INV_PI) * ENVIRONMENT_SHARE;
}

static inline int sample_environment(const Context *c, uint4 bits, LightSample *s)
{
    const real4 u = random_reals(bits);
    real x;
    uint cell = alias_cell(bits, ENVIRONMENT_CELLS, &x);
    if (!(x < c->environment_cells[2 * cell + 1])) cell = c->environment_alias[cell];
    real p = c->environment_cells[2 * cell];
    real turn = ((cell % ENVIRONMENT_WIDTH) + u.y) * (real)(1.0 / ENVIRONMENT_WIDTH);
    real z = 1 - 2 * ((cell / ENVIRONMENT_WIDTH) + u.z) * (real)(1.0 / ENVIRONMENT_HEIGHT);
    real sine = safe_sqrt((1 - z) * (1 + z));
    real sp, cp;
    m_sincos_turns(turn, &sp, &cp);
    s->wi = (real3)(sine * cp, sine * sp, z);
    s->distance = REAL_MAX;
    s->slack = 0;
    s->radiance = (real3)(1);
    s->pdf = p * (real)(ENVIRONMENT_CELLS * 0.25 * INV_PI) * ENVIRONMENT_SHARE;
    s->light = ENVIRONMENT_LIGHT;
    return is_finite_positive(s->pdf);
}
#endif

#if defined(HAS_LIGHTS) || defined(HAS_ENVIRONMENT_SAMPLING)
// Takes a direction to a light seen from P (relative to the camera) by random bits; 0 when this sample gives none.
static inline int sample_lights(const Context *c, real3 P, uint4 bits, LightSample *s)
{
#ifdef HAS_ENVIRONMENT_SAMPLING
    const real share = ENVIRONMENT_SHARE;
    // Where there are both, the highest bit chooses, half and half.
    const int environment = share == 1 || (share > 0 && bits.x < 0x80000000u);
    if (share > 0 && share < 1) bits.x <<= 1;
    if (environment) return sample_environment(c, bits, s);
#endif
#ifdef HAS_LIGHTS
    return sample_triangle_light(c, P, bits, s);
#else
    return 0;
#endif
}
#endif

#endif
