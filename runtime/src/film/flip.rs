//! FLIP: how large the difference of two pictures looks to a person who flips between them, from 0 to 1 per pixel.
//!
//! In: linear Rec.709 pictures of one size, shown as sRGB (clipped to 0..1). Out: an error per pixel. After Andersson, Nilsson,
//! Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference Evaluator for Alternating Images", HPG 2020: colours are
//! filtered as the eye does at a given distance, compared in a uniform space, and the difference is raised where edges or points
//! differ. All constants are the paper's.

use super::Picture;
use std::f64::consts::PI;

/// Pixels per degree of sight: a 4K screen 0.7 m wide, seen from 0.7 m (the paper's default).
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// Weights and widths of the two Gaussians of each channel's contrast sensitivity: achromatic, red-green, blue-yellow.
const SENSITIVITY: [[(f64, f64); 2]; 3] =
    [[(1.0, 0.0047), (0.0, 1e-5)], [(1.0, 0.0053), (0.0, 1e-5)], [(34.1, 0.04), (13.5, 0.025)]];

/// Exponent of colour differences, and the knee that compresses large ones.
const COLOUR_EXPONENT: f64 = 0.7;
const KNEE: f64 = 0.4;
const AT_KNEE: f64 = 0.95;

/// Width of the feature detectors in degrees, exponent of feature differences.
const FEATURE_WIDTH: f64 = 0.082;
const FEATURE_EXPONENT: f64 = 0.5;

/// Linear Rec.709 to XYZ (IEC 61966-2-1).
const TO_XYZ: [[f64; 3]; 3] = [
    [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
    [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
    [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
];

/// Three numbers per pixel.
type Plane = Vec<[f64; 3]>;

/// The error of each pixel, row by row; `None` for different sizes or no pixels.
pub fn errors(picture: &Picture, reference: &Picture) -> Option<Vec<f64>> {
    let size = (picture.width, picture.height);
    let same = size == (reference.width, reference.height) && picture.pixels.len() == reference.pixels.len();
    if !same || picture.pixels.is_empty() || size.0 * size.1 != picture.pixels.len() {
        return None;
    }
    let [a, b] = [picture, reference].map(opponent);
    let colours = colour_differences(&a, &b, size);
    let features = feature_differences(&a, &b, size);
    Some(colours.iter().zip(&features).map(|(c, f)| c.powf(1.0 - f)).collect())
}

/// Mean of [`errors`].
pub fn mean(picture: &Picture, reference: &Picture) -> Option<f64> {
    let errors = errors(picture, reference)?;
    Some(errors.iter().sum::<f64>() / errors.len() as f64)
}

fn times(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// The white point: all channels at 1.
fn white() -> [f64; 3] {
    times(&TO_XYZ, [1.0; 3])
}

/// Pixels in YCxCz: achromatic, red-green, blue-yellow. NaN counts as black.
fn opponent(picture: &Picture) -> Plane {
    let w = white();
    let of = |pixel: &[f32; 3]| {
        let shown = pixel.map(|v| if v.is_nan() { 0.0 } else { f64::from(v).clamp(0.0, 1.0) });
        let xyz = times(&TO_XYZ, shown);
        let [x, y, z] = [xyz[0] / w[0], xyz[1] / w[1], xyz[2] / w[2]];
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    };
    picture.pixels.iter().map(of).collect()
}

/// YCxCz to linear Rec.709, clipped to what a screen shows.
fn shown(ycxcz: [f64; 3]) -> [f64; 3] {
    let w = white();
    let y = (ycxcz[0] + 16.0) / 116.0;
    let xyz = [(y + ycxcz[1] / 500.0) * w[0], y * w[1], (y - ycxcz[2] / 200.0) * w[2]];
    // The inverse of TO_XYZ by Cramer's rule: its determinant is far from 0.
    let m = &TO_XYZ;
    let minor = |r: [usize; 2], c: [usize; 2]| m[r[0]][c[0]] * m[r[1]][c[1]] - m[r[0]][c[1]] * m[r[1]][c[0]];
    let others = [[1, 2], [0, 2], [0, 1]];
    let sign = |i: usize, j: usize| if (i + j).is_multiple_of(2) { 1.0 } else { -1.0 };
    let determinant: f64 = (0..3).map(|j| sign(0, j) * m[0][j] * minor([1, 2], others[j])).sum();
    let row = |i: usize| (0..3).map(|j| sign(i, j) * minor(others[j], others[i]) * xyz[j]).sum::<f64>() / determinant;
    [row(0), row(1), row(2)].map(|v| v.clamp(0.0, 1.0))
}

/// Linear Rec.709 to L*a*b*, chroma scaled by lightness (Hunt's effect).
fn lab(rgb: [f64; 3]) -> [f64; 3] {
    let (w, xyz) = (white(), times(&TO_XYZ, rgb));
    let f = |t: f64| {
        let delta = 6.0 / 29.0;
        if t > delta * delta * delta { t.cbrt() } else { t / (3.0 * delta * delta) + 4.0 / 29.0 }
    };
    let [x, y, z] = [f(xyz[0] / w[0]), f(xyz[1] / w[1]), f(xyz[2] / w[2])];
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// Distance of colours: city block in lightness, Euclidean in chroma.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Colour differences, 0 to 1.
fn colour_differences(a: &Plane, b: &Plane, size: (usize, usize)) -> Vec<f64> {
    let [a, b] = [a, b].map(|plane| -> Plane {
        let filtered = [0, 1, 2].map(|c| {
            let channel: Vec<f64> = plane.iter().map(|p| p[c]).collect();
            sensitivity(&channel, size, &SENSITIVITY[c])
        });
        (0..plane.len()).map(|i| lab(shown([filtered[0][i], filtered[1][i], filtered[2][i]]))).collect()
    });
    let largest = distance(lab([0.0, 1.0, 0.0]), lab([0.0, 0.0, 1.0])).powf(COLOUR_EXPONENT);
    let knee = KNEE * largest;
    let compress = |d: f64| {
        let d = d.powf(COLOUR_EXPONENT);
        if d < knee { AT_KNEE / knee * d } else { AT_KNEE + (d - knee) / (largest - knee) * (1.0 - AT_KNEE) }
    };
    a.iter().zip(&b).map(|(a, b)| compress(distance(*a, *b))).collect()
}

/// A channel as the eye's contrast sensitivity leaves it: a sum of two Gaussians of weight sqrt(pi / b) a, width b.
fn sensitivity(channel: &[f64], size: (usize, usize), gaussians: &[(f64, f64); 2]) -> Vec<f64> {
    // One radius for all channels, of the widest Gaussian.
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i64;
    let mut sum = vec![0.0; channel.len()];
    let mut total = 0.0;
    for (weight, width) in gaussians.iter().filter(|g| g.0 > 0.0) {
        let along = |i: i64| (-(PI * i as f64 / PIXELS_PER_DEGREE).powi(2) / width).exp();
        let taps: Vec<f64> = (-radius..=radius).map(along).collect();
        let factor = weight * (PI / width).sqrt();
        total += factor * taps.iter().sum::<f64>().powi(2);
        let filtered = separable(channel, size, &taps, &taps);
        sum.iter_mut().zip(filtered).for_each(|(s, f)| *s += factor * f);
    }
    sum.iter_mut().for_each(|s| *s /= total);
    sum
}

/// Convolves rows with one list of taps, columns with another; borders repeat.
fn separable(channel: &[f64], (width, height): (usize, usize), rows: &[f64], columns: &[f64]) -> Vec<f64> {
    let clamp = |i: usize, k: usize, taps: &[f64], n: usize| (i + k).saturating_sub(taps.len() / 2).min(n - 1);
    let mut across = vec![0.0; channel.len()];
    for y in 0..height {
        for x in 0..width {
            let tap = |(k, w): (usize, &f64)| w * channel[y * width + clamp(x, k, rows, width)];
            across[y * width + x] = rows.iter().enumerate().map(tap).sum();
        }
    }
    let mut out = vec![0.0; channel.len()];
    for y in 0..height {
        for x in 0..width {
            let tap = |(k, w): (usize, &f64)| w * across[clamp(y, k, columns, height) * width + x];
            out[y * width + x] = columns.iter().enumerate().map(tap).sum();
        }
    }
    out
}

/// Differences of edges and points, 0 to 1.
fn feature_differences(a: &Plane, b: &Plane, size: (usize, usize)) -> Vec<f64> {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i64;
    let gauss = |i: i64| (-(i * i) as f64 / (2.0 * deviation * deviation)).exp();
    let taps = |f: &dyn Fn(i64) -> f64| -> Vec<f64> { (-radius..=radius).map(f).collect() };
    let smooth = taps(&gauss);
    let edge = taps(&|i| -i as f64 * gauss(i));
    let point = taps(&|i| ((i * i) as f64 / (deviation * deviation) - 1.0) * gauss(i));
    // Positive and negative weights of each two-dimensional filter sum to 1 and -1.
    let across: f64 = smooth.iter().sum();
    let normalised = |filter: &[f64]| -> Vec<f64> {
        let positive: f64 = filter.iter().filter(|w| **w > 0.0).sum::<f64>() * across;
        let negative: f64 = -filter.iter().filter(|w| **w < 0.0).sum::<f64>() * across;
        filter.iter().map(|w| if *w > 0.0 { w / positive } else { w / negative }).collect()
    };
    let (edge, point) = (normalised(&edge), normalised(&point));
    let features = |plane: &Plane, filter: &[f64]| -> Vec<f64> {
        let lightness: Vec<f64> = plane.iter().map(|p| (p[0] + 16.0) / 116.0).collect();
        let x = separable(&lightness, size, filter, &smooth);
        let y = separable(&lightness, size, &smooth, filter);
        x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).collect()
    };
    let differences = |filter: &[f64]| -> Vec<f64> {
        features(a, filter).iter().zip(&features(b, filter)).map(|(a, b)| (a - b).abs()).collect()
    };
    let (edges, points) = (differences(&edge), differences(&point));
    edges.iter().zip(&points).map(|(e, p)| (e.max(*p) / 2f64.sqrt()).powf(FEATURE_EXPONENT)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ramps and a red box; then the same with the box moved and blue, a white point, a darker corner.
    fn pictures() -> (Picture, Picture) {
        let (width, height) = (48, 32);
        let mut reference = Picture { width, height, ..Picture::default() };
        for y in 0..height {
            for x in 0..width {
                reference.pixels.push([x as f32 / 47.0, y as f32 / 31.0, 0.5]);
            }
        }
        let fill = |picture: &mut Picture, rows: std::ops::Range<usize>, columns: std::ops::Range<usize>, rgb| {
            for y in rows {
                picture.pixels[y * width + columns.start..y * width + columns.end].fill(rgb);
            }
        };
        fill(&mut reference, 8..16, 10..30, [0.9, 0.2, 0.1]);
        let mut picture = reference.clone();
        fill(&mut picture, 10..18, 12..32, [0.1, 0.3, 0.8]);
        fill(&mut picture, 20..21, 40..41, [1.0; 3]);
        for y in 24..height {
            for pixel in &mut picture.pixels[y * width..y * width + 10] {
                *pixel = pixel.map(|v| v * 0.8);
            }
        }
        (picture, reference)
    }

    #[test]
    fn the_authors_program_gives_the_same() {
        // flip-evaluator 1.7 (PyPI), evaluate(reference, test, "LDR", inputsRGB=False, applyMagma=False).
        let (picture, reference) = pictures();
        let errors = errors(&picture, &reference).expect("one size");
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!((mean - 0.187266).abs() < 2e-4, "{mean}");
        for (y, x, wanted) in [
            (12, 20, 0.936635),
            (20, 40, 0.168984),
            (17, 25, 0.745482),
            (28, 5, 0.441074),
            (0, 0, 0.0),
            (9, 11, 0.347043),
        ] {
            assert!((errors[y * 48 + x] - wanted).abs() < 1e-3, "{y} {x}: {} for {wanted}", errors[y * 48 + x]);
        }
    }

    #[test]
    fn equal_pictures_do_not_differ_and_sizes_must_agree() {
        let (picture, reference) = pictures();
        assert_eq!(mean(&picture, &picture), Some(0.0));
        let black = Picture { pixels: vec![[0.0; 3]; 48 * 32], ..picture.clone() };
        let nan = Picture { pixels: vec![[f32::NAN; 3]; 48 * 32], ..picture.clone() };
        assert_eq!(mean(&nan, &reference), mean(&black, &reference));
        assert_eq!(mean(&Picture::default(), &Picture::default()), None);
        assert_eq!(mean(&picture, &Picture { width: 32, height: 48, ..reference }), None);
    }
}
