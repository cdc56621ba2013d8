//! How far two pictures are apart.
//!
//! In: pictures of one size. Out: means and errors. It must not know files.

use super::Picture;

/// Side of the tiles of [`worst_tile`], in pixels.
pub const TILE: usize = 32;

/// Mean radiance per channel.
pub fn mean(picture: &Picture) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for pixel in &picture.pixels {
        for (sum, value) in sums.iter_mut().zip(pixel) {
            *sum += f64::from(*value);
        }
    }
    sums.map(|sum| sum / picture.pixels.len().max(1) as f64)
}

/// Mean over pixels and channels of (a - b)^2 / (b^2 + 0.01), `b` being the reference; `None` for different sizes.
pub fn relative_mse(a: &Picture, b: &Picture) -> Option<f64> {
    if (a.width, a.height) != (b.width, b.height) || a.pixels.len() != b.pixels.len() {
        return None;
    }
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    let sum: f64 =
        pairs.map(|(a, b)| (f64::from(*a), f64::from(*b))).map(|(a, b)| (a - b).powi(2) / (b * b + 0.01)).sum();
    Some(sum / (3 * a.pixels.len().max(1)) as f64)
}

/// A tile and its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tile {
    /// Left column in pixels.
    pub x: usize,
    /// Top row in pixels.
    pub y: usize,
    /// |mean a - mean b| / mean b, the means over pixels and channels; at least 1e-3 counts as mean b.
    pub error: f64,
}

/// The 32 x 32 tile whose mean is relatively farthest from the reference `b`; `None` for different sizes or no pixels.
pub fn worst_tile(a: &Picture, b: &Picture) -> Option<Tile> {
    if (a.width, a.height) != (b.width, b.height) || a.pixels.len() != b.pixels.len() {
        return None;
    }
    let mut worst: Option<Tile> = None;
    for y in (0..a.height).step_by(TILE) {
        for x in (0..a.width).step_by(TILE) {
            let (of_a, of_b) = (tile_mean(a, x, y), tile_mean(b, x, y));
            let error = (of_a - of_b).abs() / of_b.abs().max(1e-3);
            // A NaN is the worst of all.
            if worst.is_none_or(|w| error > w.error || error.is_nan()) {
                worst = Some(Tile { x, y, error });
            }
            if error.is_nan() {
                return worst;
            }
        }
    }
    worst
}

fn tile_mean(picture: &Picture, x: usize, y: usize) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for row in y..(y + TILE).min(picture.height) {
        for column in x..(x + TILE).min(picture.width) {
            sum += picture.pixels[row * picture.width + column].iter().map(|v| f64::from(*v)).sum::<f64>();
            count += 3;
        }
    }
    sum / f64::from(count.max(1))
}
