//! OSL's colour functions (specification ch. 7.3) on constants.
//!
//! In: a row's name and its arguments. Out: the value, `None` when the name is not one of these. kernels/osl/color.h says
//! which working space and which units hold.

use super::math::{pow, quotient};
use super::{each, float, matrix, triple};
use crate::ir::Const;

type V = [f64; 3];

/// Linear RGB (Rec. 709, D65 at 0.3127, 0.3291) to XYZ.
const RGB_TO_XYZ: [V; 3] = [
    [0.412135323427, 0.357675002654, 0.180356796374],
    [0.212507276142, 0.715350005308, 0.0721427185497],
    [0.0193188432856, 0.119225000885, 0.949879127571],
];
const XYZ_TO_RGB: [V; 3] = [
    [3.24297896532, -1.53833617586, -0.498919840819],
    [-0.968997952917, 1.87549198226, 0.0415445240532],
    [0.0556683243682, -0.20411718935, 1.057698163],
];
/// NTSC.
const RGB_TO_YIQ: [V; 3] = [[0.299, 0.587, 0.114], [0.596, -0.275, -0.321], [0.212, -0.523, 0.311]];
const YIQ_TO_RGB: [V; 3] = [[1.0, 0.9557, 0.6199], [1.0, -0.2716, -0.6469], [1.0, -1.1082, 1.7051]];

fn through(m: &[V; 3], c: V) -> V {
    m.map(|row| row[0] * c[0] + row[1] * c[1] + row[2] * c[2])
}

fn rgb_to_xyy(c: V) -> V {
    let [x, y, z] = through(&RGB_TO_XYZ, c);
    let sum = x + y + z;
    let scale = if sum >= 1e-6 { 1.0 / sum } else { 0.0 };
    [x * scale, y * scale, y]
}

fn xyy_to_rgb([x, y, luminance]: V) -> V {
    if y > 1e-6 {
        let scale = luminance / y;
        through(&XYZ_TO_RGB, [scale * x, luminance, scale * (1.0 - x - y)])
    } else {
        [0.0; 3]
    }
}

/// Foley, van Dam et al. 1990, ch. 13.3.
fn hsv_to_rgb([h, s, v]: V) -> V {
    if s < 0.0001 {
        return [v; 3];
    }
    let h = 6.0 * (h - h.floor());
    let f = h - h.floor();
    let (p, q, t) = (v * (1.0 - s), v * (1.0 - s * f), v * (1.0 - s * (1.0 - f)));
    match h.floor() as i32 {
        0 => [v, t, p],
        1 => [q, v, p],
        2 => [p, v, t],
        3 => [p, q, v],
        4 => [t, p, v],
        _ => [v, p, q],
    }
}

fn extremes([r, g, b]: V) -> (f64, f64) {
    (r.max(g).max(b), r.min(g).min(b))
}

fn rgb_to_hsv(c: V) -> V {
    let [r, g, b] = c;
    let (high, low) = extremes(c);
    let range = high - low;
    let s = if high > 0.0 { range / high } else { 0.0 };
    if s <= 0.0 || s.is_nan() {
        return [0.0, s, high];
    }
    let sixths = if r >= high {
        (g - b) / range
    } else if g >= high {
        2.0 + (b - r) / range
    } else {
        4.0 + (r - g) / range
    };
    let h = sixths / 6.0;
    [if h < 0.0 { h + 1.0 } else { h }, s, high]
}

fn hsl_to_rgb([h, s, l]: V) -> V {
    let v = if l <= 0.5 { l * (1.0 + s) } else { l * (1.0 - s) + s };
    if v <= 0.0 { [0.0; 3] } else { hsv_to_rgb([h, 2.0 * (v - l) / v, v]) }
}

fn rgb_to_hsl(c: V) -> V {
    let (high, low) = extremes(c);
    let l = 0.5 * (low + high);
    let s = quotient(high - low, if l <= 0.5 { high + low } else { 2.0 - high - low });
    [rgb_to_hsv(c)[0], s, l]
}

/// IEC 61966-2-1.
fn srgb_to_rgb(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { pow((x + 0.055) / 1.055, 2.4) }
}

fn rgb_to_srgb(x: f64) -> f64 {
    if x <= 0.0031308 { 12.92 * x } else { 1.055 * pow(x, 1.0 / 2.4) - 0.055 }
}

/// XYZ to RGB, for column vectors, without negative components.
fn displayable(m: &[V; 3], xyz: V) -> V {
    through(m, xyz).map(|x| x.max(0.0))
}

fn wavelength_color(nanometres: f64, m: &[V; 3]) -> V {
    let t = (nanometres - 380.0) / 5.0;
    if !(0.0..80.0).contains(&t) {
        return [0.0; 3];
    }
    let (i, f) = (t as usize, t.fract());
    let xyz = std::array::from_fn(|k| (1.0 - f) * CIE_1931[i][k] + f * CIE_1931[i + 1][k]);
    // The reference's scale: no component exceeds 1.
    displayable(m, xyz).map(|x| x / 2.52)
}

/// Planck's law over the visible range, in W / m^2.
fn planck(kelvin: f64, m: &[V; 3]) -> V {
    let mut xyz = [0.0; 3];
    for (i, weights) in CIE_1931.iter().enumerate() {
        let metres = 380e-9 + 5e-9 * i as f64;
        let density = 3.74183e-16 / (metres.powi(5) * (1.4388e-2 / (metres * kelvin)).exp_m1());
        for (sum, weight) in xyz.iter_mut().zip(weights) {
            *sum += density * weight * 5e-9;
        }
    }
    displayable(m, xyz)
}

/// Between the entries of the reference's table, fifth roots at 800 + 2 i^1.5 K, as far as that reaches.
fn blackbody(kelvin: f64, m: &[V; 3]) -> V {
    if kelvin < 800.0 {
        return [1e-6, 0.0, 0.0];
    }
    if kelvin >= 12_000.0 || kelvin.is_nan() {
        return planck(kelvin, m);
    }
    let at = ((kelvin - 800.0) / 2.0).cbrt().powi(2);
    let entry = |i: f64| planck(800.0 + 2.0 * i.powf(1.5), m).map(|x| x.powf(0.2));
    let (low, high) = (entry(at.floor()), entry(at.floor() + 1.0));
    let t = at.fract();
    std::array::from_fn(|k| ((1.0 - t) * low[k] + t * high[k]).powi(5))
}

/// The conversion of an argument that is for row vectors.
fn conversion(args: &[Const], i: usize) -> Option<[V; 3]> {
    let m = matrix(args, i)?;
    Some(std::array::from_fn(|r| std::array::from_fn(|c| m[4 * c + r])))
}

/// The value of the row `name`.
pub(super) fn call(name: &str, args: &[Const]) -> Option<Const> {
    let c = || triple(args, 0);
    Some(Const::Triple(match name {
        "luminance_rec709" => return Some(Const::Float(through(&RGB_TO_XYZ, c()?)[1])),
        "srgb_to_rgb" => return each(args, |[x]| srgb_to_rgb(x)),
        "rgb_to_srgb" => return each(args, |[x]| rgb_to_srgb(x)),
        "blackbody_rec709" => blackbody(float(args, 0)?, &XYZ_TO_RGB),
        "blackbody_in" => blackbody(float(args, 0)?, &conversion(args, 1)?),
        "wavelength_color_rec709" => wavelength_color(float(args, 0)?, &XYZ_TO_RGB),
        "wavelength_color_in" => wavelength_color(float(args, 0)?, &conversion(args, 1)?),
        "hsv_to_rgb" => hsv_to_rgb(c()?),
        "rgb_to_hsv" => rgb_to_hsv(c()?),
        "hsl_to_rgb" => hsl_to_rgb(c()?),
        "rgb_to_hsl" => rgb_to_hsl(c()?),
        "yiq_to_rgb" => through(&YIQ_TO_RGB, c()?),
        "rgb_to_yiq" => through(&RGB_TO_YIQ, c()?),
        "xyz_to_rgb" => through(&XYZ_TO_RGB, c()?),
        "rgb_to_xyz" => through(&RGB_TO_XYZ, c()?),
        "xyy_to_rgb" => xyy_to_rgb(c()?),
        "rgb_to_xyy" => rgb_to_xyy(c()?),
        _ => return None,
    }))
}

/// CIE 1931 colour matching functions, 380 to 780 nm by 5 nm.
const CIE_1931: [V; 81] = [
    [0.0014, 0.0, 0.0065],
    [0.0022, 0.0001, 0.0105],
    [0.0042, 0.0001, 0.0201],
    [0.0076, 0.0002, 0.0362],
    [0.0143, 0.0004, 0.0679],
    [0.0232, 0.0006, 0.1102],
    [0.0435, 0.0012, 0.2074],
    [0.0776, 0.0022, 0.3713],
    [0.1344, 0.004, 0.6456],
    [0.2148, 0.0073, 1.0391],
    [0.2839, 0.0116, 1.3856],
    [0.3285, 0.0168, 1.623],
    [0.3483, 0.023, 1.7471],
    [0.3481, 0.0298, 1.7826],
    [0.3362, 0.038, 1.7721],
    [0.3187, 0.048, 1.7441],
    [0.2908, 0.06, 1.6692],
    [0.2511, 0.0739, 1.5281],
    [0.1954, 0.091, 1.2876],
    [0.1421, 0.1126, 1.0419],
    [0.0956, 0.139, 0.813],
    [0.058, 0.1693, 0.6162],
    [0.032, 0.208, 0.4652],
    [0.0147, 0.2586, 0.3533],
    [0.0049, 0.323, 0.272],
    [0.0024, 0.4073, 0.2123],
    [0.0093, 0.503, 0.1582],
    [0.0291, 0.6082, 0.1117],
    [0.0633, 0.71, 0.0782],
    [0.1096, 0.7932, 0.0573],
    [0.1655, 0.862, 0.0422],
    [0.2257, 0.9149, 0.0298],
    [0.2904, 0.954, 0.0203],
    [0.3597, 0.9803, 0.0134],
    [0.4334, 0.995, 0.0087],
    [0.5121, 1.0, 0.0057],
    [0.5945, 0.995, 0.0039],
    [0.6784, 0.9786, 0.0027],
    [0.7621, 0.952, 0.0021],
    [0.8425, 0.9154, 0.0018],
    [0.9163, 0.87, 0.0017],
    [0.9786, 0.8163, 0.0014],
    [1.0263, 0.757, 0.0011],
    [1.0567, 0.6949, 0.001],
    [1.0622, 0.631, 0.0008],
    [1.0456, 0.5668, 0.0006],
    [1.0026, 0.503, 0.0003],
    [0.9384, 0.4412, 0.0002],
    [0.8544, 0.381, 0.0002],
    [0.7514, 0.321, 0.0001],
    [0.6424, 0.265, 0.0],
    [0.5419, 0.217, 0.0],
    [0.4479, 0.175, 0.0],
    [0.3608, 0.1382, 0.0],
    [0.2835, 0.107, 0.0],
    [0.2187, 0.0816, 0.0],
    [0.1649, 0.061, 0.0],
    [0.1212, 0.0446, 0.0],
    [0.0874, 0.032, 0.0],
    [0.0636, 0.0232, 0.0],
    [0.0468, 0.017, 0.0],
    [0.0329, 0.0119, 0.0],
    [0.0227, 0.0082, 0.0],
    [0.0158, 0.0057, 0.0],
    [0.0114, 0.0041, 0.0],
    [0.0081, 0.0029, 0.0],
    [0.0058, 0.0021, 0.0],
    [0.0041, 0.0015, 0.0],
    [0.0029, 0.001, 0.0],
    [0.002, 0.0007, 0.0],
    [0.0014, 0.0005, 0.0],
    [0.001, 0.0004, 0.0],
    [0.0007, 0.0002, 0.0],
    [0.0005, 0.0002, 0.0],
    [0.0003, 0.0001, 0.0],
    [0.0002, 0.0001, 0.0],
    [0.0002, 0.0001, 0.0],
    [0.0001, 0.0, 0.0],
    [0.0001, 0.0, 0.0],
    [0.0001, 0.0, 0.0],
    [0.0, 0.0, 0.0],
];
