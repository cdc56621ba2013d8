// OSL's colour functions (specification ch. 7.3). Linear RGB has Rec. 709 primaries and a D65 white at x, y = 0.3127,
// 0.3291, the reference implementation's default, but for the forms `_in`, which take the conversion from XYZ to another
// one; `lower` turns transformc into these conversions.
//
// In, out: values only. Negative results of blackbody and wavelength_color are set to 0. blackbody is in W / m^2 of the
// spectrum from 380 to 780 nm, below 800 K a dim red (1e-6, 0, 0). Below 12,000 K it lies between the entries of the
// reference's table (src/liboslexec/opcolor_impl.h), which are not stored but computed: up to 0.1 % off the spectrum.
#ifndef OSLCL_OSL_COLOR_H
#define OSLCL_OSL_COLOR_H

#include "osl/math.h"
#include "osl/matrix.h"

// Dot product of luminance with linear RGB: the second row of RGB to XYZ.
static inline real osl_luminance_rec709_f_v(real3 c) {
    return 0.212507276142 * c.x + 0.715350005308 * c.y + 0.0721427185497 * c.z;
}

// ---- Linear conversions ---------------------------------------------------------------------------------------------

static inline real3 osl_rgb_to_xyz_v_v(real3 c) {
    return (real3)(0.412135323427 * c.x + 0.357675002654 * c.y + 0.180356796374 * c.z, osl_luminance_rec709_f_v(c),
                   0.0193188432856 * c.x + 0.119225000885 * c.y + 0.949879127571 * c.z);
}

static inline real3 osl_xyz_to_rgb_v_v(real3 c) {
    return (real3)(3.24297896532 * c.x - 1.53833617586 * c.y - 0.498919840819 * c.z,
                   -0.968997952917 * c.x + 1.87549198226 * c.y + 0.0415445240532 * c.z,
                   0.0556683243682 * c.x - 0.20411718935 * c.y + 1.057698163 * c.z);
}

// NTSC's YIQ. The two matrices are the usual rounded ones: they are inverses to about 3 digits.
static inline real3 osl_rgb_to_yiq_v_v(real3 c) {
    return (real3)(0.299 * c.x + 0.587 * c.y + 0.114 * c.z, 0.596 * c.x - 0.275 * c.y - 0.321 * c.z,
                   0.212 * c.x - 0.523 * c.y + 0.311 * c.z);
}

static inline real3 osl_yiq_to_rgb_v_v(real3 c) {
    return (real3)(c.x + 0.9557 * c.y + 0.6199 * c.z, c.x - 0.2716 * c.y - 0.6469 * c.z,
                   c.x - 1.1082 * c.y + 1.7051 * c.z);
}

// ---- Chromaticity ---------------------------------------------------------------------------------------------------

static inline real3 osl_rgb_to_xyy_v_v(real3 c) {
    real3 xyz = osl_rgb_to_xyz_v_v(c);
    real sum = xyz.x + xyz.y + xyz.z;
    real scale = sum >= 1e-6 ? 1 / sum : 0;
    return (real3)(xyz.x * scale, xyz.y * scale, xyz.y);
}

static inline real3 osl_xyy_to_rgb_v_v(real3 c) {
    real scale = c.y > 1e-6 ? c.z / c.y : 0;
    return osl_xyz_to_rgb_v_v((real3)(scale * c.x, c.z * (c.y > 1e-6 ? 1 : 0), scale * (1 - c.x - c.y)));
}

// ---- Hue (Foley, van Dam et al. 1990, ch. 13.3); hue, saturation and the rest in [0, 1] -------------------------------

static inline real3 osl_hsv_to_rgb_v_v(real3 c) {
    real h = 6 * clamp(c.x - floor(c.x), (real)0, (real)1), s = c.y, v = c.z;
    real sector = floor(h), f = h - sector;
    real p = v * (1 - s), q = v * (1 - s * f), t = v * (1 - s * (1 - f));
    real3 rgb = sector == 0   ? (real3)(v, t, p)
                : sector == 1 ? (real3)(q, v, p)
                : sector == 2 ? (real3)(p, v, t)
                : sector == 3 ? (real3)(p, q, v)
                : sector == 4 ? (real3)(t, p, v)
                              : (real3)(v, p, q);
    return s < 0.0001 ? (real3)(v, v, v) : rgb;
}

static inline real3 osl_rgb_to_hsv_v_v(real3 c) {
    real high = max_component(c), low = fmin(c.x, fmin(c.y, c.z));
    real range = high - low;
    real s = high > 0 ? range / high : 0;
    int red = c.x >= high, green = c.y >= high;
    real base = red ? 0 : (green ? 2 : 4);
    real difference = red ? c.y - c.z : (green ? c.z - c.x : c.x - c.y);
    real h = s > 0 ? (base + difference / range) * (1 / 6.0) : 0;
    return (real3)(h < 0 ? h + 1 : h, s, high);
}

static inline real3 osl_hsl_to_rgb_v_v(real3 c) {
    real l = c.z;
    real v = l <= 0.5 ? l * (1 + c.y) : l * (1 - c.y) + c.y;
    return v <= 0 ? (real3)(0, 0, 0) : osl_hsv_to_rgb_v_v((real3)(c.x, 2 * (v - l) / v, v));
}

static inline real3 osl_rgb_to_hsl_v_v(real3 c) {
    real3 hsv = osl_rgb_to_hsv_v_v(c);
    real high = hsv.z, low = fmin(c.x, fmin(c.y, c.z));
    real l = 0.5 * (low + high);
    real s = osl_quotient(high - low, l <= 0.5 ? high + low : 2 - high - low);
    return (real3)(hsv.x, s, l);
}

// ---- sRGB's transfer curve (IEC 61966-2-1) --------------------------------------------------------------------------

static inline real osl_srgb_to_rgb_f_f(real x) {
    return x <= 0.04045 ? x * (1 / 12.92) : osl_pow_f_ff((x + 0.055) * (1 / 1.055), 2.4);
}

static inline real osl_rgb_to_srgb_f_f(real x) {
    return x <= 0.0031308 ? 12.92 * x : 1.055 * osl_pow_f_ff(x, 1 / 2.4) - 0.055;
}

OSL_MAP1(srgb_to_rgb)
OSL_MAP1(rgb_to_srgb)

// ---- Spectra --------------------------------------------------------------------------------------------------------

// CIE 1931 colour matching functions x y z, 380 to 780 nm by 5 nm.
__constant real COLOR_CIE_1931[243] = {
    0.0014, 0, 0.0065, 0.0022, 0.0001, 0.0105, 0.0042, 0.0001, 0.0201, 0.0076, 0.0002, 0.0362, 0.0143, 0.0004, 0.0679,
    0.0232, 0.0006, 0.1102, 0.0435, 0.0012, 0.2074, 0.0776, 0.0022, 0.3713, 0.1344, 0.004, 0.6456,
    0.2148, 0.0073, 1.0391, 0.2839, 0.0116, 1.3856, 0.3285, 0.0168, 1.623, 0.3483, 0.023, 1.7471,
    0.3481, 0.0298, 1.7826, 0.3362, 0.038, 1.7721, 0.3187, 0.048, 1.7441, 0.2908, 0.06, 1.6692,
    0.2511, 0.0739, 1.5281, 0.1954, 0.091, 1.2876, 0.1421, 0.1126, 1.0419, 0.0956, 0.139, 0.813,
    0.058, 0.1693, 0.6162, 0.032, 0.208, 0.4652, 0.0147, 0.2586, 0.3533, 0.0049, 0.323, 0.272, 0.0024, 0.4073, 0.2123,
    0.0093, 0.503, 0.1582, 0.0291, 0.6082, 0.1117, 0.0633, 0.71, 0.0782, 0.1096, 0.7932, 0.0573,
    0.1655, 0.862, 0.0422, 0.2257, 0.9149, 0.0298, 0.2904, 0.954, 0.0203, 0.3597, 0.9803, 0.0134,
    0.4334, 0.995, 0.0087, 0.5121, 1, 0.0057, 0.5945, 0.995, 0.0039, 0.6784, 0.9786, 0.0027, 0.7621, 0.952, 0.0021,
    0.8425, 0.9154, 0.0018, 0.9163, 0.87, 0.0017, 0.9786, 0.8163, 0.0014, 1.0263, 0.757, 0.0011,
    1.0567, 0.6949, 0.001, 1.0622, 0.631, 0.0008, 1.0456, 0.5668, 0.0006, 1.0026, 0.503, 0.0003,
    0.9384, 0.4412, 0.0002, 0.8544, 0.381, 0.0002, 0.7514, 0.321, 0.0001, 0.6424, 0.265, 0, 0.5419, 0.217, 0,
    0.4479, 0.175, 0, 0.3608, 0.1382, 0, 0.2835, 0.107, 0, 0.2187, 0.0816, 0, 0.1649, 0.061, 0, 0.1212, 0.0446, 0,
    0.0874, 0.032, 0, 0.0636, 0.0232, 0, 0.0468, 0.017, 0, 0.0329, 0.0119, 0, 0.0227, 0.0082, 0, 0.0158, 0.0057, 0,
    0.0114, 0.0041, 0, 0.0081, 0.0029, 0, 0.0058, 0.0021, 0, 0.0041, 0.0015, 0, 0.0029, 0.001, 0, 0.002, 0.0007, 0,
    0.0014, 0.0005, 0, 0.001, 0.0004, 0, 0.0007, 0.0002, 0, 0.0005, 0.0002, 0, 0.0003, 0.0001, 0, 0.0002, 0.0001, 0,
    0.0002, 0.0001, 0, 0.0001, 0, 0, 0.0001, 0, 0, 0.0001, 0, 0, 0, 0, 0};

static inline real3 color_matching(int i) {
    return (real3)(COLOR_CIE_1931[3 * i], COLOR_CIE_1931[3 * i + 1], COLOR_CIE_1931[3 * i + 2]);
}

// Of XYZ, for row vectors, without negative components.
static inline real3 color_displayable(real3 xyz, mat4 xyz_to_rgb) {
    return fmax(osl_transform_vector_v_mv(xyz_to_rgb, xyz), 0);
}

static inline mat4 color_rec709(void) {
    return make_mat4(3.24297896532, -0.968997952917, 0.0556683243682, 0, -1.53833617586, 1.87549198226, -0.20411718935, 0,
                     -0.498919840819, 0.0415445240532, 1.057698163, 0, 0, 0, 0, 1);
}

static inline real3 osl_wavelength_color_in_v_fm(real nanometres, mat4 xyz_to_rgb) {
    real t = (nanometres - 380) / 5;
    if (!(t >= 0 && t < 80)) return (real3)(0, 0, 0);
    int i = (int)t;
    t -= i;
    real3 xyz = (1 - t) * color_matching(i) + t * color_matching(i + 1);
    return color_displayable(xyz, xyz_to_rgb) * (1 / 2.52); // the reference's scale, no component exceeds 1
}

// Planck's law with 2 pi h c^2 = 3.74183e-16 W m^2 and h c / k = 1.4388e-2 m K.
static inline real3 color_blackbody(real kelvin, mat4 xyz_to_rgb) {
    real3 xyz = (real3)(0, 0, 0);
    for (int i = 0; i < 81; ++i) {
        real um = 0.38 + 0.005 * i;
        real um2 = um * um;
        real density = 3.74183e14 / (um2 * um2 * um * m_expm1(1.4388e4 / (um * kelvin))); // W / m^3
        xyz += density * 5e-9 * color_matching(i);
    }
    return color_displayable(xyz, xyz_to_rgb);
}

// Entry i of the table: the fifth root at 800 + 2 i^1.5 K.
static inline real3 color_blackbody_entry(real i, mat4 xyz_to_rgb) {
    real3 rgb = color_blackbody(800 + 2 * i * sqrt(i), xyz_to_rgb);
    return (real3)(osl_pow_f_ff(rgb.x, 0.2), osl_pow_f_ff(rgb.y, 0.2), osl_pow_f_ff(rgb.z, 0.2));
}

static inline real3 osl_blackbody_in_v_fm(real kelvin, mat4 xyz_to_rgb) {
    if (kelvin < 800) return (real3)(1e-6, 0, 0);
    if (!(kelvin < 12000)) return color_blackbody(kelvin, xyz_to_rgb);
    real root = m_cbrt((kelvin - 800) * 0.5);
    real at = root * root;
    real i = floor(at), t = at - i;
    real3 c = (1 - t) * color_blackbody_entry(i, xyz_to_rgb) + t * color_blackbody_entry(i + 1, xyz_to_rgb);
    real3 c2 = c * c;
    return c2 * c2 * c;
}

static inline real3 osl_wavelength_color_rec709_v_f(real nanometres) {
    return osl_wavelength_color_in_v_fm(nanometres, color_rec709());
}

static inline real3 osl_blackbody_rec709_v_f(real kelvin) { return osl_blackbody_in_v_fm(kelvin, color_rec709()); }

#endif
