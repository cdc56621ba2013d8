// Cycles' closures by ours: what a shader written for Blender gets here. docs/closures.md lists how near each comes.
//
// A shader that includes this file by name uses these functions as they stand. One that brings Blender's own stdcycles.h only declares
// the closures; the compiler then takes the functions from here (docs/adr/0018). The last `tokens` parameters are token/value pairs.
#pragma once
#include "stdosl.h"

// The mean of a ramp: the share of each of its steps in a lobe is taken as equal.
color cycles_mean(color colors[8])
{
    color sum = 0;
    for (int i = 0; i < 8; i++)
        sum += colors[i];
    return sum / 8;
}

// Longitudinal variance and azimuthal scale of a hair's roughness, 0..1: Chiang et al. 2016, eq. 7 and 8.
float cycles_hair_variance(float roughness)
{
    float r = clamp(roughness, 0.001, 1.0);
    float v = 0.726 * r + 0.812 * r * r + 3.7 * pow(r, 20);
    return v * v;
}
float cycles_hair_scale(float roughness)
{
    float r = clamp(roughness, 0.001, 1.0);
    return 0.626657069 * (0.265 * r + 1.194 * r * r + 5.372 * pow(r, 22));
}

// Hair, whose cuticles stand at `tilt` radians.
closure color cycles_hair(normal N, color sigma, float along, float around, float coat, float tilt, float eta)
{
    float v = cycles_hair_variance(along);
    float s = cycles_hair_scale(around);
    float smooth = cycles_hair_variance(along * (1 - coat));
    return chiang_hair_bsdf(N, normalize(dPdu), color(1), color(1), color(1), eta, smooth, v * 0.25, v * 4, s, s, s,
                            0.5 + tilt / M_PI, sigma);
}

// ---- Diffuse
closure color diffuse_ramp(normal N, color colors[8]) [[ int tokens = 0 ]] { return cycles_mean(colors) * diffuse(N); }
closure color diffuse_toon(normal N, float size, float smooth) [[ int tokens = 0 ]] { return diffuse(N); }
closure color ambient_occlusion() [[ int tokens = 0 ]] { return diffuse(N); }
closure color principled_diffuse(normal N, float roughness) [[ int tokens = 0 ]] { return burley_diffuse_bsdf(N, color(1), roughness); }
closure color bssrdf(string method, normal N, vector radius, color albedo, float roughness, float ior, float anisotropy)
    [[ int tokens = 3 ]]
{
    return subsurface_bssrdf(N, albedo, color(radius), anisotropy);
}

// ---- Cloth
closure color sheen(normal N, float roughness) [[ int tokens = 0 ]] { return sheen_bsdf(N, color(1), roughness, "mode", 1); }
closure color ashikhmin_velvet(normal N, float sigma) [[ int tokens = 0 ]] { return sheen_bsdf(N, color(1), clamp(sigma, 0.1, 1.0)); }
closure color principled_sheen(normal N) [[ int tokens = 0 ]] { return sheen_bsdf(N, color(1), 0.3); }

// ---- Glossy
closure color phong_ramp(normal N, float exponent, color colors[8]) [[ int tokens = 0 ]]
{
    return cycles_mean(colors) * phong(N, exponent);
}
closure color glossy_toon(normal N, float size, float smooth) [[ int tokens = 0 ]]
{
    return microfacet("ggx", N, size * size, 0, 0);
}
closure color microfacet_ggx(normal N, float ag) [[ int tokens = 0 ]] { return microfacet("ggx", N, ag, 0, 0); }
closure color microfacet_ggx_aniso(normal N, vector T, float ax, float ay) [[ int tokens = 0 ]]
{
    return microfacet("ggx", N, T, ax, ay, 0, 0);
}
closure color microfacet_beckmann(normal N, float ab) [[ int tokens = 0 ]] { return microfacet("beckmann", N, ab, 0, 0); }
closure color microfacet_beckmann_aniso(normal N, vector T, float ax, float ay) [[ int tokens = 0 ]]
{
    return microfacet("beckmann", N, T, ax, ay, 0, 0);
}
closure color ashikhmin_shirley(normal N, vector T, float ax, float ay) [[ int tokens = 0 ]]
{
    return microfacet("beckmann", N, T, ax, ay, 0, 0);
}
closure color microfacet_multi_ggx(normal N, float ag, color C) [[ int tokens = 0 ]] { return microfacet("ggx", N, ag, 0, 0); }
closure color microfacet_multi_ggx_aniso(normal N, vector T, float ax, float ay, color C) [[ int tokens = 0 ]]
{
    return microfacet("ggx", N, T, ax, ay, 0, 0);
}
// The curve through f0 at normal incidence and through f82 times Schlick's curve at 82 degrees, by the reflectance at grazing angles.
closure color microfacet_f82_tint(string distribution, vector N, vector T, float ax, float ay, color f0, color f82)
    [[ int tokens = 0 ]]
{
    float slope = pow(6.0 / 7.0, 5.0);
    color at82 = mix(f0, color(1), slope) * f82;
    color f90 = clamp(f0 + (at82 - f0) / slope, color(0), color(1));
    return generalized_schlick_bsdf(normal(N), T, color(1), color(0), ax, ay, f0, f90, 5, distribution);
}
closure color principled_clearcoat(normal N, float roughness) [[ int tokens = 0 ]]
{
    return microfacet("ggx", N, roughness * roughness, backfacing() ? 1 / 1.5 : 1.5, 0);
}

// ---- Glass. eta is that of the far side over the near one, as in microfacet.
closure color microfacet_multi_ggx_glass(normal N, float ag, float eta, color C) [[ int tokens = 0 ]]
{
    return microfacet("ggx", N, ag, eta, 2);
}
closure color microfacet_ggx_refraction(normal N, float ag, float eta) [[ int tokens = 0 ]] { return microfacet("ggx", N, ag, eta, 1); }
closure color microfacet_beckmann_refraction(normal N, float ab, float eta) [[ int tokens = 0 ]]
{
    return microfacet("beckmann", N, ab, eta, 1);
}
closure color microfacet_ggx_glass(normal N, float ag, float eta) [[ int tokens = 0 ]] { return microfacet("ggx", N, ag, eta, 2); }
closure color microfacet_beckmann_glass(normal N, float ab, float eta) [[ int tokens = 0 ]]
{
    return microfacet("beckmann", N, ab, eta, 2);
}

// ---- Hair
closure color hair_reflection(normal N, float roughnessu, float roughnessv, vector T, float offset) [[ int tokens = 0 ]]
{
    return microfacet("ggx", N, T, roughnessv, roughnessu, 0, 0);
}
closure color hair_transmission(normal N, float roughnessu, float roughnessv, vector T, float offset) [[ int tokens = 0 ]]
{
    return translucent(N);
}
closure color hair_chiang(normal N, color sigma, float roughnessu, float roughnessv, float coat, float alpha, float eta)
    [[ int tokens = 0 ]]
{
    return cycles_hair(N, sigma, roughnessu, roughnessv, coat, alpha, eta);
}
closure color principled_hair(normal N, color sigma, float roughnessu, float roughnessv, float coat, float alpha, float eta)
    [[ int tokens = 0 ]]
{
    return cycles_hair(N, sigma, roughnessu, roughnessv, coat, alpha, eta);
}
closure color hair_huang(normal N, color sigma, float roughness, float tilt, float eta, float aspect_ratio, float r_lobe,
                         float tt_lobe, float trt_lobe) [[ int tokens = 0 ]]
{
    float v = cycles_hair_variance(roughness);
    float s = cycles_hair_scale(roughness);
    return chiang_hair_bsdf(N, normalize(dPdu), color(r_lobe), color(tt_lobe), color(trt_lobe), eta, v, v, v, s, s, s,
                            0.5 + tilt / M_PI, sigma);
}

// ---- Media, and what leads elsewhere
closure color fournier_forand(float B, float IOR) [[ int tokens = 0 ]] { return henyey_greenstein(0.9); }
closure color draine(float g, float alpha) [[ int tokens = 0 ]] { return henyey_greenstein(g); }
closure color rayleigh() [[ int tokens = 0 ]] { return isotropic(); }
closure color ray_portal_bsdf(vector position, vector direction) [[ int tokens = 0 ]] { return transparent(); }
