//! Working colour spaces: what linear RGB means, by its primaries and white point.
//!
//! In: a name. Out: the conversions from and to XYZ, as the reference implementation derives them from chromaticities
//! (src/liboslexec/opcolor.cpp, `set_colorspace`). It must not know the tree or IR.

/// Names, then x and y of red, green, blue and white.
type Primaries = (&'static str, [f64; 8]);

const D65: [f64; 2] = [0.3127, 0.3291];
const EQUAL: [f64; 2] = [0.33333333, 0.33333333];
const ACES: [f64; 2] = [0.32168, 0.33767];

const fn with(name: &'static str, p: [f64; 6], white: [f64; 2]) -> Primaries {
    (name, [p[0], p[1], p[2], p[3], p[4], p[5], white[0], white[1]])
}

const SYSTEMS: [Primaries; 13] = [
    with("Rec709", [0.64, 0.33, 0.30, 0.60, 0.15, 0.06], D65),
    with("sRGB", [0.64, 0.33, 0.30, 0.60, 0.15, 0.06], D65),
    with("NTSC", [0.67, 0.33, 0.21, 0.71, 0.14, 0.08], [0.3101, 0.3162]),
    with("EBU", [0.64, 0.33, 0.29, 0.60, 0.15, 0.06], D65),
    with("PAL", [0.64, 0.33, 0.29, 0.60, 0.15, 0.06], D65),
    with("SECAM", [0.64, 0.33, 0.29, 0.60, 0.15, 0.06], D65),
    with("SMPTE", [0.630, 0.340, 0.310, 0.595, 0.155, 0.070], D65),
    with("HDTV", [0.670, 0.330, 0.210, 0.710, 0.150, 0.060], D65),
    with("CIE", [0.7355, 0.2645, 0.2658, 0.7243, 0.1669, 0.0085], EQUAL),
    with("AdobeRGB", [0.64, 0.33, 0.21, 0.71, 0.15, 0.06], D65),
    with("XYZ", [1.0, 0.0, 0.0, 1.0, 0.0, 0.0], EQUAL),
    with("ACES2065-1", [0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077], ACES),
    with("ACEScg", [0.713, 0.293, 0.165, 0.83, 0.128, 0.044], ACES),
];

/// A working colour space.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorSystem {
    /// Its name.
    pub name: &'static str,
    /// For row vectors: c * m.
    pub xyz_to_rgb: [[f64; 3]; 3],
    /// Its inverse.
    pub rgb_to_xyz: [[f64; 3]; 3],
    /// What a colour's luminance is the dot product with.
    pub luminance: [f64; 3],
}

impl Default for ColorSystem {
    fn default() -> ColorSystem {
        ColorSystem::of(&SYSTEMS[0])
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl ColorSystem {
    /// The names that [`ColorSystem::by_name`] knows.
    pub fn names() -> [&'static str; 13] {
        SYSTEMS.map(|s| s.0)
    }

    /// The space with this name.
    pub fn by_name(name: &str) -> Option<ColorSystem> {
        SYSTEMS.iter().find(|s| s.0 == name).map(ColorSystem::of)
    }

    fn of((name, p): &Primaries) -> ColorSystem {
        let [red, green, blue, white] = [0, 2, 4, 6].map(|i| [p[i], p[i + 1], 1.0 - p[i] - p[i + 1]]);
        // The rows of XYZ to RGB are dual to the primaries; each is scaled so that white of luminance 1 becomes 1.
        let dual = [cross(green, blue), cross(blue, red), cross(red, green)];
        let rows = dual.map(|r| {
            let w = dot(r, white) / white[1];
            r.map(|x| x / w)
        });
        let [r, g, b] = rows;
        let d = dot(r, cross(g, b));
        let columns = [cross(g, b), cross(b, r), cross(r, g)].map(|c| c.map(|x| x / d));
        let transposed = |m: [[f64; 3]; 3]| [0, 1, 2].map(|j| m.map(|row: [f64; 3]| row[j]));
        let mut luminance = columns.map(|c| c[1]);
        let rest = 1.0 - luminance[0] - luminance[1];
        if (rest - luminance[2]).abs() < 0.001 {
            luminance[2] = rest;
        }
        ColorSystem { name, xyz_to_rgb: transposed(rows), rgb_to_xyz: columns, luminance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn through(c: [f64; 3], m: [[f64; 3]; 3]) -> [f64; 3] {
        [0, 1, 2].map(|j| c[0] * m[0][j] + c[1] * m[1][j] + c[2] * m[2][j])
    }

    #[test]
    fn conversions_are_those_of_the_reference() {
        let rec709 = ColorSystem::default();
        assert!((rec709.xyz_to_rgb[0][0] - 3.24297896532).abs() < 1e-8, "{rec709:?}");
        assert!((rec709.rgb_to_xyz[2][1] - 0.0721427185497).abs() < 1e-9);
        // testsuite/colorspace: (0.1, 0.7, 0.2) in ACEScg.
        let aces = ColorSystem::by_name("ACEScg").expect("a known name");
        let xyz = through([0.1, 0.7, 0.2], aces.rgb_to_xyz);
        for (ours, theirs) in xyz.into_iter().zip([0.191286, 0.509818, 0.204353]) {
            assert!((ours - theirs).abs() < 1e-6, "{xyz:?}");
        }
        for name in ColorSystem::names() {
            let system = ColorSystem::by_name(name).expect("a known name");
            let back = through(through([0.2, 0.5, 0.7], system.rgb_to_xyz), system.xyz_to_rgb);
            assert!(back.iter().zip([0.2, 0.5, 0.7]).all(|(a, b)| (a - b).abs() < 1e-12), "{name}");
            assert!((system.luminance.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{name}");
        }
    }
}
