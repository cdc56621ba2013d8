// What every OSL shader may use without including anything. The compiler knows the built-in functions and closures from
// its own table; here stand the constants, and functions that OSL itself can express.
#pragma once

// Constants (OSL specification ch. 7).
#define M_PI 3.1415926535897932
#define M_PI_2 1.5707963267948966
#define M_PI_4 0.7853981633974483
#define M_2_PI 0.6366197723675813
#define M_2PI 6.2831853071795865
#define M_4PI 12.566370614359173
#define M_2_SQRTPI 1.1283791670955126
#define M_E 2.7182818284590452
#define M_LN2 0.6931471805599453
#define M_LN10 2.3025850929940457
#define M_LOG2E 1.4426950408889634
#define M_LOG10E 0.4342944819032518
#define M_SQRT2 1.4142135623730950
#define M_SQRT1_2 0.7071067811865475

// Marks a declaration of what the renderer or the compiler brings. Headers of other renderers declare their closures by it.
#define BUILTIN [[ int builtin = 1 ]]
#define BUILTIN_DERIV [[ int builtin = 1, int deriv = 1 ]]

#ifndef NO_MATERIALX_CLOSURES
// Gulbrandsen 2014, "Artist Friendly Metallic Fresnel": index of refraction and extinction from the colour at normal
// incidence and at the edge.
void artistic_ior(color reflectivity, color edge_tint, output color ior, output color extinction)
{
    color r = clamp(reflectivity, color(0), color(0.99));
    color root = sqrt(r);
    color n_min = (1 - r) / (1 + r);
    color n_max = (1 + root) / (1 - root);
    ior = mix(n_max, n_min, edge_tint);
    color np1 = ior + 1;
    color nm1 = ior - 1;
    extinction = sqrt(max((np1 * np1 * r - nm1 * nm1) / (1 - r), color(0)));
}
#endif
