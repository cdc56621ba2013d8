//! Levels of detail of a picture that has none: each the linear interpolation of the one before at half its size.
//!
//! In: a subimage of one level. Out: levels down to one texel. Sizes and weights are those of OpenImageIO's `automip`.

use super::picture::{Level, Subimage};

/// Adds the levels that are missing below the last one.
pub fn complete(sub: &mut Subimage) {
    sub.completed = true;
    while let Some(last) = sub.levels.last().filter(|l| l.width > 1 || l.height > 1) {
        let next = half(last, sub.channels);
        sub.levels.push(next);
    }
}

fn half(fine: &Level, channels: usize) -> Level {
    let (width, height) = ((fine.width / 2).max(1), (fine.height / 2).max(1));
    // Which two texels lie around the new one's centre, and the share of the second.
    let between = |i: u32, size: u32, from: u32| {
        let x = (f64::from(i) + 0.5) / f64::from(size) * f64::from(from) - 0.5;
        let low = x.floor();
        let place = |x: f64| x.clamp(0.0, f64::from(from - 1)) as usize;
        (place(low), place(low + 1.0), x - low)
    };
    let columns: Vec<_> = (0..width).map(|i| between(i, width, fine.width)).collect();
    let texel = |x: usize, y: usize, c: usize| fine.texels.get((y * fine.width as usize + x) * channels + c);
    let mut numbers = Vec::with_capacity(width as usize * height as usize * channels);
    for j in 0..height {
        let (y0, y1, v) = between(j, height, fine.height);
        for &(x0, x1, u) in &columns {
            for c in 0..channels {
                let top = texel(x0, y0, c) * (1.0 - u) + texel(x1, y0, c) * u;
                let low = texel(x0, y1, c) * (1.0 - u) + texel(x1, y1, c) * u;
                numbers.push(top * (1.0 - v) + low * v);
            }
        }
    }
    Level { width, height, texels: fine.texels.like(numbers.into_iter()) }
}
