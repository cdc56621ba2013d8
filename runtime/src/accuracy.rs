//! How far a shader's values are from those of the same shader in f64.
//!
//! In: two runs over the same grid. Out: a [`Deviation`] per output. It must not know devices or files.
//!
//! An error in ulp is the difference over the distance of neighbouring 32-bit floats at the reference value (Goldberg, "What
//! every computer scientist should know about floating-point arithmetic", 1991, sec. 1.2), so that 0.5 is what rounding the
//! reference to 32 bits costs at most.

use crate::shade::Plane;

/// Errors of one output, over all points and numbers of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    /// The output's name.
    pub output: String,
    /// Largest error in ulp of 32-bit floats.
    pub max_ulp: f64,
    /// Mean error in ulp.
    pub mean_ulp: f64,
    /// Largest error.
    pub max_abs: f64,
    /// Mean error.
    pub mean_abs: f64,
    /// Where the error in ulp is largest.
    pub worst: Worst,
    /// Numbers that are infinite or NaN on one side only, or differently; they are in none of the above.
    pub not_finite: u64,
}

/// A point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// Its column and row.
    pub at: [u32; 2],
    /// Which of the output's numbers.
    pub channel: u32,
    /// What it should be.
    pub wanted: f64,
    /// What it is.
    pub got: f64,
}

/// Distance from |x| to the next larger 32-bit float.
pub fn ulp(x: f64) -> f64 {
    let x = (x.abs() as f32).min(f32::MAX);
    // The exponent decides; below the smallest normal number it stays.
    let exponent = (x.to_bits() >> 23).max(1) as i32 - 127;
    2f64.powi(exponent - 23)
}

/// Compares the outputs of two runs over the same grid, pair by pair.
pub fn deviations(got: &[Plane], wanted: &[Plane]) -> Vec<Deviation> {
    got.iter().zip(wanted).map(|(got, wanted)| deviation(got, wanted)).collect()
}

fn deviation(got: &Plane, wanted: &Plane) -> Deviation {
    let mut out = Deviation {
        output: wanted.name.clone(),
        max_ulp: 0.0,
        mean_ulp: 0.0,
        max_abs: 0.0,
        mean_abs: 0.0,
        worst: Worst::default(),
        not_finite: 0,
    };
    let channels = wanted.channels.max(1) as usize;
    let mut count = 0u64;
    for (i, (a, b)) in got.data.iter().zip(&wanted.data).enumerate() {
        if !(a.is_finite() && b.is_finite()) {
            // Equal infinities, and NaN on both sides, agree; so does an f64 beyond the range of f32 with an infinity.
            let agree =
                a == b || (a.is_nan() && b.is_nan()) || (b.abs() > f64::from(f32::MAX) && *a == b.signum() / 0.0);
            out.not_finite += u64::from(!agree);
            continue;
        }
        let off = (a - b).abs();
        let ulps = off / ulp(*b);
        count += 1;
        out.mean_abs += off;
        out.mean_ulp += ulps;
        out.max_abs = out.max_abs.max(off);
        if ulps > out.max_ulp {
            out.max_ulp = ulps;
            let point = (i / channels) as u32;
            let width = wanted.grid.width.max(1);
            out.worst =
                Worst { at: [point % width, point / width], channel: (i % channels) as u32, wanted: *b, got: *a };
        }
    }
    if count > 0 {
        out.mean_abs /= count as f64;
        out.mean_ulp /= count as f64;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shade::Grid;

    fn plane(data: &[f64]) -> Plane {
        let grid = Grid::new(2, data.len() as u32 / 2);
        Plane { name: "f".to_owned(), ty: "float".to_owned(), grid, channels: 1, data: data.to_vec() }
    }

    #[test]
    fn ulps_are_those_of_f32() {
        for x in [1.0, 1.5, -1.0, 3e-39, 1e-45, 0.0, 6e37, 0.1] {
            let x32 = (x as f32).abs();
            let next = f32::from_bits(x32.to_bits() + 1);
            assert_eq!(ulp(x), f64::from(next) - f64::from(x32), "{x}");
        }
        assert_eq!(ulp(1e300), ulp(f64::from(f32::MAX)));
    }

    #[test]
    fn the_worst_point_is_found() {
        let wanted = plane(&[1.0, 1e6, 1e-6, 0.0]);
        let got = plane(&[1.0, 1e6 + 1.0, 1e-6 * (1.0 + 1e-4), 0.0]);
        let d = &deviations(&[got], std::slice::from_ref(&wanted))[0];
        assert_eq!((d.worst.at, d.max_abs, d.not_finite), ([0, 1], 1.0, 0));
        assert!((d.max_ulp - 1e-10 / ulp(1e-6)).abs() < 1e-3 && (d.mean_abs - 0.25).abs() < 1e-9, "{d:?}");
    }

    #[test]
    fn what_is_not_finite_is_counted_apart() {
        let wanted = plane(&[f64::NAN, f64::INFINITY, 1.0, 1e39]);
        let got = plane(&[f64::NAN, 1.0, f64::INFINITY, f64::INFINITY]);
        let d = &deviations(&[got], &[wanted])[0];
        assert_eq!((d.not_finite, d.max_abs), (2, 0.0));
    }
}
