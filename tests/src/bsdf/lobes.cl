// The lobes under test: one kernel per question. In: the parameters of a case (tests/src/bsdf/mod.rs writes them).
#define HAS_LOBE_DIFFUSE
#define HAS_LOBE_OREN_NAYAR
#define HAS_LOBE_TRANSLUCENT
#define HAS_LOBE_PHONG
#define HAS_LOBE_WARD
#define HAS_LOBE_MICROFACET
#define HAS_LOBE_REFLECTION
#define HAS_LOBE_REFRACTION
#define HAS_LOBE_TRANSPARENT
#define HAS_LOBE_CONDUCTOR
#define HAS_LOBE_OREN_NAYAR_DIFFUSE
#define HAS_LOBE_BURLEY_DIFFUSE
#define HAS_LOBE_DIELECTRIC
#define HAS_LOBE_GENERALIZED_SCHLICK
#define HAS_LOBE_SHEEN
#define HAS_LOBE_CHIANG_HAIR
#define HAS_LOBE_THIN_FILM
#include "bsdf/pick.h"

// Reals of a case: vectors first, then numbers.
#define CASE_N 0
#define CASE_T 3
#define CASE_WO 6
#define CASE_A 9
#define CASE_B 10
#define CASE_ETA 11
#define CASE_C0 12
#define CASE_C1 15
#define CASE_GRIDS 18  // two polar grids: axis, two directions across, scale
#define GRID_REALS 10
#define CASE_REALS 38

static real3 case_vector(__global const real *p, int at) { return (real3)(p[at], p[at + 1], p[at + 2]); }

// Dielectrics are given eta as their lobes have it; the closures take the index of the inside and the side.
static real inside_ior(real eta) { return eta < 1 && eta > 0 ? 1 / eta : eta; }

static real3 tint_if(int on, real3 tint) { return on ? tint : (real3)(0); }

// The constructor of closure number `which` (CLOSURES of mod.rs). `dist`: a name's number, and 4 for a film.
static Lobe make_bare_lobe(int which, int dist, int refract, __global const real *p)
{
    const int names[4] = {STR_GGX, STR_BECKMANN, STR_DEFAULT, 12345};
    const int name = names[dist & 3];
    const real3 N = case_vector(p, CASE_N), T = case_vector(p, CASE_T);
    const real a = p[CASE_A], b = p[CASE_B], eta = p[CASE_ETA];
    switch (which) {
    case 0: return closure_diffuse_v(N);
    case 1: return closure_oren_nayar_vf(N, a);
    case 2: return closure_translucent_v(N);
    case 3: return closure_phong_vf(N, a);
    case 4: return closure_ward_vvff(N, T, a, b);
    case 5: return closure_microfacet_svvfffi(name, N, T, a, b, eta, refract);
    case 6: return closure_microfacet_svffi(name, N, a, eta, refract);
    case 7: return closure_reflection_vf(N, eta);
    case 8: return closure_reflection_v(N);
    case 9: return closure_refraction_vf(N, eta);
    case 10: return closure_conductor_bsdf_vvffvvs(N, T, a, b, case_vector(p, CASE_C0), case_vector(p, CASE_C1), name);
    case 11: return closure_transparent();
    case 12: return closure_subsurface_ffv(N, eta, a, case_vector(p, CASE_C0));
    case 13: return closure_oren_nayar_diffuse_bsdf_vfi(N, a, refract);
    case 14: return closure_burley_diffuse_bsdf_vf(N, a);
    case 15:
        return closure_dielectric_bsdf_vvvvfffs(eta < 1, N, T, tint_if(refract != 1, (real3)(1, 0.8, 0.6)),
                                                tint_if(refract != 0, (real3)(1, 0.9, 0.3)), a, b, inside_ior(eta), name);
    case 16: {
        // Reflectances whose mean belongs to eta.
        const real ior = inside_ior(eta), r = (ior - 1) / (ior + 1);
        return closure_generalized_schlick_bsdf_vvvvffvvfs(
            eta < 1, N, T, tint_if(refract != 1, (real3)(1, 0.8, 0.6)), tint_if(refract != 0, (real3)(1, 0.9, 0.3)), a, b,
            r * r * (real3)(1, 0.5, 1.5), (real3)(1, 0.9, 1), 5, name);
    }
    case 17: return closure_translucent_bsdf_v(N);
    case 18: return closure_subsurface_bssrdf_vvf(N, case_vector(p, CASE_C0), a);
    case 19: return closure_sheen_bsdf_vfi(N, a, refract);
    case 20:
        return closure_chiang_hair_bsdf_vvvvvffffffffv(N, T, (real3)(1, 0.9, 0.8), (real3)(1, 0.5, 0.8), (real3)(0.9, 1, 1), eta, a,
                                                       (real)0.7 * a, 2 * a, b, (real)0.8 * b, (real)1.5 * b, (real)0.5 + (real)0.05 * refract,
                                                       case_vector(p, CASE_C1));
    default: return closure_transparent_bsdf();
    }
}

static Lobe make_lobe(int which, int dist, int refract, __global const real *p)
{
    const Lobe lobe = make_bare_lobe(which, dist, refract, p);
    return dist & 4 ? lobe_film(lobe, 420, (real)1.33) : lobe;
}

// What layer() takes off its base.
static real3 albedo3(const Lobe *l, real3 wo)
{
    switch (l->type) {
    case LOBE_DIFFUSE: return diffuse_albedo3(*l, wo);
    case LOBE_OREN_NAYAR: return oren_nayar_albedo3(*l, wo);
    case LOBE_TRANSLUCENT: return translucent_albedo3(*l, wo);
    case LOBE_PHONG: return phong_albedo3(*l, wo);
    case LOBE_WARD: return ward_albedo3(*l, wo);
    case LOBE_MICROFACET: return microfacet_albedo3(*l, wo);
    case LOBE_REFLECTION: return reflection_albedo3(*l, wo);
    case LOBE_REFRACTION: return refraction_albedo3(*l, wo);
    case LOBE_CONDUCTOR: return conductor_albedo3(*l, wo);
    case LOBE_OREN_NAYAR_DIFFUSE: return oren_nayar_diffuse_albedo3(*l, wo);
    case LOBE_BURLEY_DIFFUSE: return burley_diffuse_albedo3(*l, wo);
    case LOBE_DIELECTRIC: return dielectric_albedo3(*l, wo);
    case LOBE_GENERALIZED_SCHLICK: return generalized_schlick_albedo3(*l, wo);
    case LOBE_SHEEN: return sheen_albedo3(*l, wo);
    case LOBE_CHIANG_HAIR: return chiang_hair_albedo3(*l, wo);
    default: return (real3)(1);
    }
}

static uint next_random(uint *state)
{
    // O'Neill's PCG, output RXS-M-XS.
    *state = *state * 747796405u + 2891336453u;
    uint word = ((*state >> ((*state >> 28) + 4)) ^ *state) * 277803737u;
    return (word >> 22) ^ word;
}

// Uniform in [0,1).
static real uniform_random(uint *state)
{
#ifdef OSLCL_F64
    const uint high = next_random(state) >> 6, low = next_random(state) >> 5;
    return ((real)high * 134217728.0 + (real)low) * (1.0 / 9007199254740992.0);
#else
    return (real)(next_random(state) >> 8) * (real)(1.0 / 16777216.0);
#endif
}

// Samples, and asks bsdf_eval about the direction taken, and about the swapped pair. 19 reals per sample.
LOBE_KERNEL void sample_lobe(int which, int dist, int refract, __global const real *p, uint seed, __global real *out)
{
    const uint i = (uint)get_global_id(0);
    uint state = i * 9781u + seed;
    next_random(&state);
    const Lobe lobe = make_lobe(which, dist, refract, p);
    const real3 wo = case_vector(p, CASE_WO);
    real3 u;
    u.x = uniform_random(&state);
    u.y = uniform_random(&state);
    u.z = uniform_random(&state);
    real3 wi = (real3)(0), value = (real3)(0), f = (real3)(0), swapped = (real3)(0);
    real pdf = 0, eval_pdf = 0, ignored;
    const int flags = bsdf_sample(&lobe, wo, u, &wi, &value, &pdf);
    if (flags) {
        f = bsdf_eval(&lobe, wo, wi, &eval_pdf);
        swapped = bsdf_eval(&lobe, wi, wo, &ignored);
    }
    __global real *o = out + 19 * (size_t)i;
    o[0] = flags;
    vstore3(wi, 0, o + 1);
    vstore3(value, 0, o + 4);
    o[7] = pdf;
    vstore3(f, 0, o + 8);
    o[11] = eval_pdf;
    vstore3(swapped, 0, o + 12);
    o[15] = bsdf_albedo(&lobe, wo);
    vstore3(albedo3(&lobe, wo), 0, o + 16);
}

// Integrates density and f |cos| over the bins of two polar grids, each on its side of the surface. Rings are spaced so
// that half of them lie within 1 - cos < scale around the axis. 2 reals per bin.
LOBE_KERNEL void integrate_lobe(int which, int dist, int refract, __global const real *p, int rings, int sectors,
                                int steps, __global real *out)
{
    const int i = (int)get_global_id(0);
    const int grid = i / (rings * sectors);
    if (grid > 1) return;
    const int ring = i / sectors % rings, sector = i % sectors;
    __global const real *g = p + CASE_GRIDS + grid * GRID_REALS;
    const real3 axis = case_vector(g, 0), s = case_vector(g, 3), t = case_vector(g, 6);
    const real scale = g[9];
    const Lobe lobe = make_lobe(which, dist, refract, p);
    const real3 wo = case_vector(p, CASE_WO), N = case_vector(p, CASE_N);
    const real top = 2 / (2 + scale);
    real sum_pdf = 0, sum_f = 0;
    for (int j = 0; j < steps; j++) {
        const real q = (ring + (j + (real)0.5) / steps) / rings * top;
        const real d = scale * q / (1 - q);
        const real sine = sqrt(d * (2 - d));
        real row_pdf = 0, row_f = 0;
        for (int k = 0; k < steps; k++) {
            const real phi = (real)(2 * PI) * (sector + (k + (real)0.5) / steps) / sectors;
            const real3 wi = axis * (1 - d) + (s * cos(phi) + t * sin(phi)) * sine;
            const real side = dot(N, wi);
            if (grid == 0 ? side <= 0 : side >= 0) continue;
            real pdf;
            const real3 f = bsdf_eval(&lobe, wo, wi, &pdf);
            row_pdf += pdf;
            row_f += f.x;
        }
        const real jacobian = scale / ((1 - q) * (1 - q));
        sum_pdf += row_pdf * jacobian;
        sum_f += row_f * jacobian;
    }
    const real area = (real)(2 * PI) / sectors * top / rings / steps / steps;
    out[2 * i] = sum_pdf * area;
    out[2 * i + 1] = sum_f * area;
}

// Offers lobes with weights (4 reals each: closure's N is that of the case, weight) and stores what was picked:
// type and weight, 4 reals per pick.
LOBE_KERNEL void pick_lobe(int count, __global const int *which, __global const real *weights, __global const real *p,
                           int picks, __global real *out)
{
    const int i = (int)get_global_id(0);
    if (i >= picks) return;
    const real3 wo = case_vector(p, CASE_WO);
    ShadeResult result;
    result.lobe.type = LOBE_NONE;
    result.lobe.weight = (real3)(0);
    LobeChoice choice = {(i + (real)0.5) / picks, 0, 0};
    for (int k = 0; k < count; k++) {
        const Lobe lobe = make_lobe(which[k], 0, 2, p);
        lobe_offer(&result, &choice, &lobe, vload3(k, weights), wo);
    }
    lobe_finish(&result, &choice);
    out[4 * i] = result.lobe.type;
    vstore3(result.lobe.weight, 0, out + 4 * i + 1);
}

static real wild_number(uint *state)
{
    const real infinity = 1 / (real)0;
    const real specials[16] = {0, -0.0, 1, -1, 1e-30, 1e30, 1e-7, 1 + 1e-7, 0.999999, 1e-4, 1e-3, 0.5, 3, infinity,
                               -infinity, infinity - infinity};
    const uint choice = next_random(state) % 24;
    return choice < 16 ? specials[choice] : uniform_random(state) * 2;
}

static real3 wild_unit(uint *state)
{
    const real z = uniform_random(state) * 2 - 1, phi = (real)(2 * PI) * uniform_random(state);
    const real flat = next_random(state) % 4 == 0 ? (real)1e-6 : (real)1; // every fourth grazes
    return normalize((real3)(cos(phi) * sqrt(1 - z * z), sin(phi) * sqrt(1 - z * z), z * flat));
}

// Any parameters at all. Stores what was wrong: 0 nothing, 1 sample, 2 eval, 3 albedo, and the closure.
LOBE_KERNEL void wild_lobe(uint seed, __global real *p, __global int *out)
{
    const uint i = (uint)get_global_id(0);
    uint state = i * 9781u + seed;
    next_random(&state);
    p += (size_t)i * CASE_REALS;
    const int which = next_random(&state) % 22, dist = next_random(&state) % 8;
    const int refract = (int)(next_random(&state) % 4) - 1;
    const real3 n = next_random(&state) % 4 ? wild_unit(&state) : (real3)(0, 0, 1);
    vstore3(n * (next_random(&state) % 8 ? 1 : wild_number(&state)), 0, p + CASE_N);
    for (int k = CASE_T; k < CASE_GRIDS; k++) p[k] = wild_number(&state);
    const Lobe lobe = make_lobe(which, dist, refract, p);
    real3 u;
    u.x = next_random(&state) % 8 ? uniform_random(&state) : (real)0;
    u.y = next_random(&state) % 8 ? uniform_random(&state) : (real)ONE_MINUS_EPSILON;
    u.z = next_random(&state) % 8 ? uniform_random(&state) : (real)0;
    const real3 wo = wild_unit(&state), other = wild_unit(&state);
    int wrong = 0;
    real3 wi, value;
    real pdf;
    if (bsdf_sample(&lobe, wo, u, &wi, &value, &pdf)) {
        if (!all(isfinite(wi)) || !all(isfinite(value)) || !isfinite(pdf) || pdf < 0 || !all(value >= 0)) wrong = 1;
        if (!(fabs(dot(wi, wi) - 1) < (real)1e-4)) wrong = 1;
        const real3 f = bsdf_eval(&lobe, wo, wi, &pdf);
        if (!all(isfinite(f)) || !isfinite(pdf) || pdf < 0 || !all(f >= 0)) wrong = 2;
    }
    const real3 f = bsdf_eval(&lobe, wo, other, &pdf);
    if (!all(isfinite(f)) || !isfinite(pdf) || pdf < 0 || !all(f >= 0)) wrong = 2;
    const real albedo = bsdf_albedo(&lobe, wo);
    const real3 layered = albedo3(&lobe, wo);
    if (!(albedo >= 0 && albedo <= 1) || !all(layered >= 0) || !all(layered <= 1)) wrong = 3;
    out[2 * i] = wrong;
    out[2 * i + 1] = which + 32 * dist + 256 * (refract + 1);
}
