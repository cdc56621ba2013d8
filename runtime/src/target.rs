//! Renders to a stated error: takes samples until the picture is as close to the converged one as asked.
//!
//! In: a scene, a device, settings, the error. Out: the picture, its samples, the error that it has. It must not know the command
//! line.
//!
//! The error is the root of the relative mean squared error: of (x - r)^2 / (r^2 + 0.01), r being the converged picture. Nobody has
//! that, but two pictures a and b of as many samples each, with other random numbers, tell it: their mean is off by a quarter of
//! (a - b)^2. What noise does not tell, such as a shorter path, is not in it.

use crate::choices::Choices;
use crate::device::Device;
use crate::film::Picture;
use crate::render::{Error, Options, Summary};
use crate::scene::{Integrator, Scene};
use crate::session::Session;

/// Samples per pixel of each of the first two pictures.
const PILOT: u32 = 8;

/// How much more than the last estimate says, so that it seldom takes one more step.
const MARGIN: f64 = 1.1;

/// Most times that a step may take of what is done: first estimates are rough.
const LEAP: f64 = 16.0;

/// Most samples per pixel of a half.
const MOST: u32 = Integrator::MOST_SAMPLES / 2;

/// Two seeds of one: far from those that users add to theirs.
const OTHER_SEED: u64 = 0x0b5e_55ed_0000_0000;

/// What it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// Samples per pixel.
    pub samples: u32,
    /// The error of the picture, as its halves tell it.
    pub error: f64,
    /// Error of the first samples, and how many.
    pub pilot: (f64, u32),
}

/// One half of the samples.
#[derive(Default)]
struct Half {
    sum: Vec<[f64; 3]>,
    samples: u32,
}

impl Half {
    fn add(&mut self, picture: &Picture, samples: u32) {
        self.sum.resize(picture.pixels.len(), [0.0; 3]);
        for (sum, pixel) in self.sum.iter_mut().zip(&picture.pixels) {
            sum.iter_mut().zip(pixel).for_each(|(s, v)| *s += f64::from(*v) * f64::from(samples));
        }
        self.samples += samples;
    }
}

/// The mean of both halves, and its error.
fn mean_and_error(a: &Half, b: &Half) -> (Vec<[f32; 3]>, f64) {
    let n = f64::from(a.samples.max(1));
    let mut error = 0.0;
    let mean = |(p, q): (&[f64; 3], &[f64; 3])| {
        [0, 1, 2].map(|c| {
            let (x, y) = (p[c] / n, q[c] / n);
            let mean = 0.5 * (x + y);
            error += 0.25 * (x - y).powi(2) / (mean * mean + 0.01);
            mean as f32
        })
    };
    let pixels: Vec<[f32; 3]> = a.sum.iter().zip(&b.sum).map(mean).collect();
    let error = (error / (3 * pixels.len().max(1)) as f64).sqrt();
    (pixels, error)
}

/// Samples per half that should reach the target, after `done` that have this error.
fn next(done: u32, error: f64, target: f64) -> u32 {
    let wanted = f64::from(done) * ((error / target).powi(2) * MARGIN).clamp(1.0, LEAP);
    (wanted.ceil() as u32).max(done + 1).min(MOST)
}

/// Renders until the error is at most `target`, or until no more samples can be taken. `watch` hears the samples per pixel so far,
/// their error (infinite before the first) and the samples that come next. All pixels get as many samples: `adaptive` is another way to
/// an error.
pub fn render(
    scene: &Scene,
    device: &Device,
    options: &Options,
    target: f64,
    watch: &mut dyn FnMut(u32, f64, u32),
) -> Result<(Picture, Summary, Reached), Error> {
    let options = &Options { choices: Choices { adaptive: None, ..options.choices }, ..*options };
    let mut session = Session::new(scene, device, options)?;
    let seed = scene.integrator.seed;
    let (mut a, mut b) = (Half::default(), Half::default());
    let mut taken: u64 = 0;
    // All renders so far as one summary.
    let mut half_more = |half: &mut Half, more: u32, before: Option<Summary>| -> Result<(Picture, Summary), Error> {
        session.set_samples(more);
        session.set_seed(seed ^ taken.wrapping_mul(OTHER_SEED | 1));
        taken += 1;
        let (picture, mut summary) = session.render(&mut |_| {})?;
        half.add(&picture, more);
        if let Some(before) = before {
            summary.counts += before.counts;
            summary.render_time += before.render_time;
        }
        Ok((picture, summary))
    };
    let mut pilot = None;
    let mut summary = None;
    let mut wanted = PILOT;
    let mut error = f64::INFINITY;
    loop {
        watch(2 * a.samples, error, 2 * wanted);
        let more = wanted - a.samples;
        let (_, first) = half_more(&mut a, more, summary.take())?;
        let (picture, mut both) = half_more(&mut b, more, Some(first))?;
        let (pixels, now) = mean_and_error(&a, &b);
        error = now;
        let samples = 2 * a.samples;
        let pilot = *pilot.get_or_insert((error, samples));
        if error <= target || a.samples >= MOST {
            both.samples = samples;
            let mut picture = Picture { pixels, ..picture };
            for (name, value) in &mut picture.attributes {
                if name == "oslcl:samples" {
                    *value = samples.to_string();
                }
            }
            return Ok((picture, both, Reached { samples, error, pilot }));
        }
        wanted = next(a.samples, error, target);
        summary = Some(both);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_grow_as_the_error_asks() {
        assert_eq!(next(8, 0.02, 0.01), 36);
        assert_eq!(next(8, 1.0, 0.001), 128);
        assert_eq!(next(100, 0.0101, 0.01), 113);
        assert_eq!(next(100, 0.0, 0.01), 101);
        assert_eq!(next(Integrator::MOST_SAMPLES / 2 - 1, 1.0, 0.001), Integrator::MOST_SAMPLES / 2);
    }

    #[test]
    fn halves_tell_the_error_of_their_mean() {
        let picture = |v: f32| Picture { width: 2, height: 1, pixels: vec![[v; 3]; 2], ..Picture::default() };
        let (mut a, mut b) = (Half::default(), Half::default());
        a.add(&picture(1.0), 4);
        a.add(&picture(2.0), 4);
        b.add(&picture(1.3), 8);
        let (pixels, error) = mean_and_error(&a, &b);
        assert!((pixels[0][0] - 1.4).abs() < 1e-6);
        assert!((error - (0.25 * 0.04 / (1.96 + 0.01f64)).sqrt()).abs() < 1e-6, "{error}");
    }
}
