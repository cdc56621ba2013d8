//! Errors of a setting from renders with several seeds.
//!
//! In: runs and a reference picture. Out: estimates with 95 % confidence intervals (Student's t over the seeds).
//!
//! With runs x_1..x_n of a pixel and the reference r, all per channel and relative to r^2 + 0.01:
//! - variance: mean of the sample variance of x;
//! - squared bias: mean of (mean x - r)^2 minus variance / n, which is what noise alone leaves of it, and minus the reference's own
//!   variance; it can come out below 0 when there is no bias to be seen;
//! - relative MSE: mean of (x - r)^2, each run on its own, minus the reference's variance.

use crate::film::Picture;
use crate::film::flip;

/// What is added to the square of the reference, as in [`crate::film::compare::relative_mse`].
const FLOOR: f64 = 0.01;

/// One render.
#[derive(Clone, Debug)]
pub struct Run {
    /// What came out.
    pub picture: Picture,
    /// Seconds of tracing.
    pub seconds: f64,
}

/// A number and how sure it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The mean over the seeds.
    pub value: f64,
    /// Half the width of the 95 % confidence interval; infinite for one seed.
    pub within: f64,
}

/// Errors and time of a setting.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Seconds of a render.
    pub seconds: Estimate,
    /// Relative mean squared error.
    pub mse: Estimate,
    /// What a person sees of the error: the mean of FLIP.
    pub flip: Estimate,
    /// Share of the relative MSE that differs from seed to seed.
    pub variance: f64,
    /// Share of it that does not: squared bias. Below `bias_noise` nothing can be told from 0.
    pub squared_bias: f64,
    /// Standard deviation of `squared_bias` by noise alone, as far as pixels are independent.
    pub bias_noise: f64,
}

impl Measured {
    /// Whether a bias is seen: three standard deviations of what noise leaves.
    pub fn is_biased(&self) -> bool {
        self.squared_bias > 3.0 * self.bias_noise
    }

    /// Seconds to a relative MSE of `target`, as the variance falls with the samples and the bias stays; `None`: never.
    pub fn seconds_to(&self, target: f64) -> Option<f64> {
        let bias = if self.is_biased() { self.squared_bias } else { 0.0 };
        (bias < target).then(|| self.seconds.value * self.variance / (target - bias))
    }
}

/// 97.5 % quantile of Student's t by degrees of freedom, from 1; the normal distribution's beyond.
const STUDENT: [f64; 15] =
    [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131];

/// Mean of a sample with its confidence interval.
pub fn estimate(sample: &[f64]) -> Estimate {
    let n = sample.len();
    let mean = sample.iter().sum::<f64>() / n.max(1) as f64;
    if n < 2 {
        return Estimate { value: mean, within: f64::INFINITY };
    }
    let variance = sample.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1) as f64;
    let t = STUDENT.get(n - 2).copied().unwrap_or(1.96);
    Estimate { value: mean, within: t * (variance / n as f64).sqrt() }
}

/// Measures runs against a reference; `reference_variance` is the reference's own relative MSE (0: exact). `None` for no runs or
/// for pictures of different sizes.
pub fn measure(runs: &[Run], reference: &Picture, reference_variance: f64) -> Option<Measured> {
    let size = reference.pixels.len();
    if runs.is_empty() || size == 0 || runs.iter().any(|r| r.picture.pixels.len() != size) {
        return None;
    }
    let n = runs.len() as f64;
    let numbers = (3 * size) as f64;
    let mut errors = vec![0.0; runs.len()];
    let (mut variance, mut offset, mut noise) = (0.0, 0.0, 0.0);
    for i in 0..size {
        for c in 0..3 {
            let wanted = f64::from(reference.pixels[i][c]);
            let weight = 1.0 / (wanted * wanted + FLOOR);
            let mut mean = 0.0;
            for (run, error) in runs.iter().zip(&mut errors) {
                let x = f64::from(run.picture.pixels[i][c]);
                *error += weight * (x - wanted).powi(2);
                mean += x / n;
            }
            let around: f64 = runs.iter().map(|r| (f64::from(r.picture.pixels[i][c]) - mean).powi(2)).sum();
            let own = if runs.len() > 1 { weight * around / (n - 1.0) } else { 0.0 };
            variance += own;
            offset += weight * (mean - wanted).powi(2);
            // The square of a normal number of variance s has the standard deviation sqrt(2) s; channels go together.
            noise += 3.0 * 2.0 * (own / n + reference_variance).powi(2);
        }
    }
    errors.iter_mut().for_each(|e| *e = *e / numbers - reference_variance);
    let flips: Vec<f64> = runs.iter().map(|r| flip::mean(&r.picture, reference)).collect::<Option<_>>()?;
    let seconds: Vec<f64> = runs.iter().map(|r| r.seconds).collect();
    variance /= numbers;
    Some(Measured {
        seconds: estimate(&seconds),
        mse: estimate(&errors),
        flip: estimate(&flips),
        variance,
        squared_bias: offset / numbers - variance / n - reference_variance,
        bias_noise: noise.sqrt() / numbers,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs of 32 x 32 pixels of radiance `level` with uniform noise of half-width `noise`.
    fn runs(seeds: u32, level: f64, noise: f64) -> Vec<Run> {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / f64::from(1u32 << 31) - 0.5
        };
        let picture = |random: &mut dyn FnMut() -> f64| Picture {
            width: 32,
            height: 32,
            pixels: (0..1024).map(|_| [0; 3].map(|_| (level + 2.0 * noise * random()) as f32)).collect(),
            ..Picture::default()
        };
        (0..seeds).map(|i| Run { picture: picture(&mut random), seconds: 1.0 + 0.1 * f64::from(i % 2) }).collect()
    }

    fn flat(level: f32) -> Picture {
        Picture { width: 32, height: 32, pixels: vec![[level; 3]; 1024], ..Picture::default() }
    }

    #[test]
    fn noise_is_variance_and_an_offset_is_bias() {
        // Uniform noise of half-width 0.1 has the variance 0.01 / 3.
        let wanted = 0.01 / 3.0 / (0.25 + FLOOR);
        let noisy = measure(&runs(8, 0.5, 0.1), &flat(0.5), 0.0).expect("runs");
        assert!((noisy.variance / wanted - 1.0).abs() < 0.05 && !noisy.is_biased(), "{noisy:?}");
        assert!(
            (noisy.mse.value - noisy.variance).abs() < 0.03 * wanted && noisy.mse.within < 0.1 * wanted,
            "{noisy:?}"
        );
        let off = measure(&runs(8, 0.52, 0.1), &flat(0.5), 0.0).expect("runs");
        let bias = 0.02f64.powi(2) / (0.25 + FLOOR);
        assert!((off.squared_bias / bias - 1.0).abs() < 0.2 && off.is_biased(), "{off:?}");
        // Half the error takes twice the time; no time takes the bias away.
        let time = noisy.seconds_to(noisy.variance / 2.0).expect("no bias");
        assert!((time / noisy.seconds.value - 2.0).abs() < 1e-9, "{time}");
        assert_eq!(off.seconds_to(bias / 2.0), None);
    }

    #[test]
    fn intervals_are_students() {
        let found = estimate(&[1.0, 2.0, 3.0]);
        assert!((found.value - 2.0).abs() < 1e-12 && (found.within - 4.303 / 3f64.sqrt()).abs() < 1e-9, "{found:?}");
        assert_eq!(estimate(&[5.0]), Estimate { value: 5.0, within: f64::INFINITY });
        assert_eq!(measure(&[], &flat(0.5), 0.0), None);
        assert_eq!(measure(&runs(2, 0.5, 0.0), &Picture::default(), 0.0), None);
    }
}
