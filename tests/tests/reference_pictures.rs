//! r1 and r2 against converged pictures of an unrelated renderer (tests/reference/, see docs/ARCHITECTURE.md).
//!
//! A pixel is a box filter's integral, so a picture of 1/k of the size is compared with the reference's k x k means. The test
//! runs at 64 x 64; with OSLCL_SLOW_TESTS set at the reference's own 512 x 512 and 4,096 samples, for a fast device.

use oslcl_runtime::choices::{Choices, Sampler};
use oslcl_runtime::device::Device;
use oslcl_runtime::film::compare::{mean, relative_mse, worst_tile};
use oslcl_runtime::film::{Picture, read_exr};
use oslcl_runtime::render::{self, Options};
use oslcl_runtime::scene;
use std::path::{Path, PathBuf};

fn file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn is_slow() -> bool {
    std::env::var_os("OSLCL_SLOW_TESTS").is_some_and(|v| v != "0")
}

/// The means of squares of `factor` pixels a side.
fn shrink(picture: &Picture, factor: usize) -> Picture {
    let (width, height) = (picture.width / factor, picture.height / factor);
    let mut pixels = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let mut sum = [0.0f64; 3];
            for k in 0..factor * factor {
                let from = picture.pixels[(y * factor + k / factor) * picture.width + x * factor + k % factor];
                for (s, v) in sum.iter_mut().zip(from) {
                    *s += f64::from(v);
                }
            }
            pixels.push(sum.map(|s| (s / (factor * factor) as f64) as f32));
        }
    }
    Picture { width, height, pixels, ..Picture::default() }
}

fn check(name: &str) {
    let side = if is_slow() { 512 } else { 64 };
    let reference = read_exr(&file(&format!("reference/{}.exr", name.to_uppercase()))).expect("a reference");
    let reference = shrink(&reference, reference.width / side);
    let mut scene = scene::load(&file(&format!("scenes/{name}.toml"))).expect("a scene");
    scene.film = scene::Film { width: side as u32, height: side as u32 };
    let device = Device::open(None).expect("an OpenCL device");
    let mut render = |samples: u32, seed: u64, sampler: Sampler| {
        scene.integrator.samples = samples;
        scene.integrator.seed = seed;
        let options = Options { choices: Choices { sampler, ..Choices::default() }, ..Options::default() };
        let (picture, summary) =
            render::render(&scene, &device, &options, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((summary.counts.dropped, summary.counts.repaired), (0, 0), "{name}");
        picture
    };

    // The error of independent samples falls as 1/N: N times the relative MSE is the same for all N.
    let mut scaled = Vec::new();
    let most = if is_slow() { 1024 } else { 256 };
    for (i, samples) in [16u32, 64, 256, 1024].into_iter().filter(|n| *n <= most).enumerate() {
        let picture = render(samples, 7 + i as u64, Sampler::Independent);
        scaled.push(f64::from(samples) * relative_mse(&picture, &reference).expect("one size"));
    }
    let (low, high) = scaled.iter().fold((f64::MAX, 0.0f64), |(l, h), x| (l.min(*x), h.max(*x)));
    assert!(high < 1.6 * low, "{name}: samples times relative MSE from 16 to {most} samples: {scaled:?}");

    let picture = render(if is_slow() { 4096 } else { 2048 }, 1, Sampler::default());
    let (got, expected) = (mean(&picture), mean(&reference));
    for (a, b) in got.iter().zip(&expected) {
        assert!((a - b).abs() < 0.005 * b, "{name}: mean {got:?}, reference {expected:?}");
    }
    if is_slow() {
        let worst = worst_tile(&picture, &reference).expect("one size");
        assert!(worst.error < 0.01, "{name}: {worst:?}");
    } else {
        // 4 x 4 pixels here are the 32 x 32 of the full size, with 128 times fewer samples: 1 % there is noise of 4 % here.
        let (small, small_reference) = (shrink(&picture, 4), shrink(&reference, 4));
        for (i, (a, b)) in small.pixels.iter().zip(&small_reference.pixels).enumerate() {
            let (a, b) = (a.iter().sum::<f32>(), b.iter().sum::<f32>());
            assert!((a - b).abs() < 0.04 * b, "{name}: tile {i} has {a}, the reference {b}");
        }
    }
}

#[test]
fn r1_is_the_reference_within_noise() {
    check("r1");
}

#[test]
fn r2_is_the_reference_within_noise() {
    check("r2");
}
