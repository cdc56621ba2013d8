//! Settings between accuracy and time that change a picture: each value gives the picture that it stands for, in closed form or
//! by its stated distance from the default's.

use glam::DAffine3;
use oslcl_runtime::choices::Choices;
use oslcl_runtime::device::Device;
use oslcl_runtime::film::Picture;
use oslcl_runtime::film::compare::mean;
use oslcl_runtime::render::{self, Options, Summary};
use oslcl_runtime::scene::{DVec3, Film, Filter, Scene};
use oslcl_tests::scenes::{empty, material, mesh, place, sphere, wall};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// PoCL finds no device while another thread asks for one.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

fn render_with(scene: &Scene, settings: &[(&str, &str)]) -> (Picture, Summary) {
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let device = Device::open(None).expect("an OpenCL device");
    let mut choices = Choices::default();
    settings.iter().for_each(|(name, value)| choices.set(name, value).unwrap_or_else(|e| panic!("{e}")));
    let mut scene = scene.clone();
    choices.apply(&mut scene.integrator);
    let options = Options { choices, ..Options::default() };
    render::render(&scene, &device, &options, &mut |_| {}).unwrap_or_else(|e| panic!("{settings:?}: {e}"))
}

/// Texels across and down of the texture, and pixels of the pictures that magnify it.
const TEXELS: usize = 8;
const PIXELS: usize = 64;

/// A texel: no two neighbours are near each other.
fn texel(i: usize, j: usize) -> f64 {
    ((37 * i + 101 * j + 11 * i * j) % 251) as f64 / 255.0
}

fn texture(name: &str, texels: usize) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("settings");
    std::fs::create_dir_all(&folder).expect("a folder for pictures");
    let file = folder.join(name);
    let picture = image::ImageBuffer::from_fn(texels as u32, texels as u32, |x, y| {
        image::Luma([(255.0 * texel(x as usize, y as usize)).round() as u8])
    });
    picture.save(&file).expect("a picture is written");
    file
}

/// A wall that fills the picture exactly and emits what the texture holds; rays go through the middles of pixels.
fn screen(file: &Path, pixels: usize, options: &str) -> Scene {
    let mut scene = empty();
    scene.film = Film { width: pixels as u32, height: pixels as u32 };
    scene.filter = Filter::Middle;
    scene.integrator.samples = 1;
    scene.integrator.max_depth = 1;
    // The wall is 2 across, 5 away.
    scene.camera.hfov_degrees = 2.0 * (0.2f64).atan().to_degrees();
    let file = file.to_string_lossy().replace('\\', "/");
    // t grows downwards in files, v upwards.
    let source = format!(
        "surface s() {{ Ci = (float)texture(\"{file}\", u, 1 - v, \"wrap\", \"clamp\"{options}) * emission(); }}"
    );
    let m = material(&mut scene, &source, &[]);
    // Nothing else is there that it could light.
    scene.materials[m.0 as usize].sampled_light = false;
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    scene
}

/// A texture under weights of the texels around: `taps` of them from `first` on, given how far a point lies behind a texel.
fn filtered(texels: usize, s: f64, t: f64, first: isize, weights: &dyn Fn(f64) -> Vec<f64>) -> f64 {
    let place = |s: f64| (s * texels as f64 - 0.5).floor();
    let weights_at = |s: f64| weights(s * texels as f64 - 0.5 - place(s));
    let clamp = |i: isize| i.clamp(0, texels as isize - 1) as usize;
    let mut sum = 0.0;
    for (j, wt) in weights_at(t).iter().enumerate() {
        for (i, ws) in weights_at(s).iter().enumerate() {
            let (x, y) = (place(s) as isize + first + i as isize, place(t) as isize + first + j as isize);
            sum += ws * wt * texel(clamp(x), clamp(y));
        }
    }
    sum
}

fn closest(texels: usize, s: f64, t: f64) -> f64 {
    filtered(texels, s, t, 0, &|f| if f > 0.5 { vec![0.0, 1.0] } else { vec![1.0, 0.0] })
}

fn bilinear(texels: usize, s: f64, t: f64) -> f64 {
    filtered(texels, s, t, 0, &|f| vec![1.0 - f, f])
}

/// The uniform cubic B-spline.
fn bicubic(texels: usize, s: f64, t: f64) -> f64 {
    let spline = |f: f64| {
        let g = 1.0 - f;
        let [b, c] = [f, g].map(|x| (4.0 - 3.0 * x * x * (2.0 - x)) / 6.0);
        vec![g * g * g / 6.0, b, c, f * f * f / 6.0]
    };
    filtered(texels, s, t, -1, &spline)
}

/// The largest distance of a picture's pixels from a function of s and t, at the middles of pixels.
fn distance(picture: &Picture, of: &dyn Fn(f64, f64) -> f64) -> f64 {
    let (width, height) = (picture.width as f64, picture.height as f64);
    let off = |(i, p): (usize, &[f32; 3])| {
        let (x, y) = ((i % picture.width) as f64 + 0.5, (i / picture.width) as f64 + 0.5);
        (f64::from(p[0]) - of(x / width, y / height)).abs()
    };
    picture.pixels.iter().enumerate().map(off).fold(0.0, f64::max)
}

/// The largest relative difference of two pictures' pixels.
fn apart(a: &Picture, b: &Picture) -> f64 {
    let values = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    values.map(|(a, b)| f64::from((a - b).abs()) / f64::from(b.abs()).max(1e-6)).fold(0.0, f64::max)
}

/// Whatever a lookup says, the setting decides; without it, the lookup.
#[test]
fn texture_filters_are_what_they_are_called() {
    let file = texture("filters.png", TEXELS);
    type Filter = fn(usize, f64, f64) -> f64;
    let filters: [(&str, &str, Filter); 3] =
        [("closest", "closest", closest), ("bilinear", "linear", bilinear), ("bicubic", "cubic", bicubic)];
    for (k, (value, _, wanted)) in filters.into_iter().enumerate() {
        let (_, interp, asked) = filters[(k + 1) % 3];
        let scene = screen(&file, PIXELS, &format!(", \"interp\", \"{interp}\""));
        let off = |settings: &[(&str, &str)], filter: Filter| {
            distance(&render_with(&scene, settings).0, &|s, t| filter(TEXELS, s, t))
        };
        let overruled = off(&[("texture_filter", value)], wanted);
        assert!(overruled < 1e-3, "texture_filter={value} of a lookup by {interp}: {overruled} from its closed form");
        let as_asked = off(&[], asked);
        assert!(as_asked < 1e-3, "a lookup by {interp}: {as_asked} from its closed form");
    }
}

/// A level is the one before at half the size. So a lookup so many levels finer reads the file's texels, however small they are
/// in the picture; one so many levels coarser the mean of all; and one coarser is a filter twice as wide.
#[test]
fn mip_bias_moves_levels_of_detail() {
    const FINE: usize = 64;
    // Four texels a pixel each way.
    let pixels = FINE / 4;
    let file = texture("levels.png", FINE);
    let linear = ", \"interp\", \"linear\"";
    let scene = screen(&file, pixels, linear);
    let with = |bias: &str| render_with(&scene, &[("texture_mip_bias", bias)]).0;
    let texels = || (0..FINE * FINE).map(|i| texel(i % FINE, i / FINE));
    let mean = texels().sum::<f64>() / (FINE * FINE) as f64;
    let spread = (texels().map(|t| (t - mean).powi(2)).sum::<f64>() / (FINE * FINE) as f64).sqrt();
    let (default, _) = render_with(&scene, &[]);

    let off = distance(&with("-16"), &|s, t| bilinear(FINE, s, t));
    assert!(off < 1e-3, "the finest level: {off}");
    assert!(distance(&default, &|s, t| bilinear(FINE, s, t)) > spread / 2.0, "the default is no finer");

    // Levels are kept in bytes: half of one is lost at each.
    let off = distance(&with("16"), &|_, _| mean);
    assert!(off < 6.0 * 0.5 / 255.0, "the coarsest level: {off}");
    assert!(distance(&default, &|_, _| mean) > 0.02, "the default is no coarser");

    let (wide, _) = render_with(&screen(&file, pixels, &format!("{linear}, \"width\", 2.0")), &[]);
    let one = with("1");
    assert!(apart(&one, &wide) < 1e-3, "one level coarser: {}", apart(&one, &wide));
    assert!(apart(&one, &default) > 0.02, "one level does something: {}", apart(&one, &default));
}

/// A 16-bit float has 11 bits: what the number next to x is.
fn rounded_to_half(x: f64) -> f64 {
    let unit = 2f64.powi(x.abs().log2().floor() as i32 - 10);
    (x / unit).round() * unit
}

/// A wall with this shader under a sky of 1.
fn wall_under_sky(shader: &str) -> Scene {
    let mut scene = empty();
    let m = material(&mut scene, shader, &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    let sky = material(&mut scene, "surface s() { Ci = background(); }", &[]);
    scene.environment = Some(sky);
    scene
}

/// Throughput is what the sky's light is multiplied with: the wall shows it, rounded as it is stored.
#[test]
fn half_path_state_rounds_throughput_to_16_bits() {
    let mut scene = wall_under_sky("surface d() { Ci = color(0.3, 0.1, 0.7) * diffuse(N); }");
    scene.integrator.samples = 4;
    for (setting, wanted) in [("float", [0.3, 0.1, 0.7]), ("half", [0.3, 0.1, 0.7].map(rounded_to_half))] {
        let (picture, _) = render_with(&scene, &[("path_state", setting)]);
        let found = mean(&picture);
        for c in 0..3 {
            let off = (found[c] - wanted[c]).abs() / wanted[c];
            assert!(off < 2e-6, "path_state={setting}: {found:?}, not {wanted:?}");
        }
    }
}

/// Two bounces at most: each rounds by at most a part in 2,048, so the light of a path is off by no more than twice that, and with the
/// same random numbers so is the picture.
#[test]
fn half_path_state_stays_within_its_bound_and_takes_fewer_bytes() {
    let mut scene = empty();
    scene.integrator.max_depth = 3;
    scene.integrator.samples = 16;
    let m = material(&mut scene, "surface d() { Ci = color(0.3, 0.55, 0.8) * diffuse(N); }", &[]);
    let ball = mesh(&mut scene, sphere());
    place(&mut scene, ball, m, DAffine3::IDENTITY);
    let floor = mesh(&mut scene, wall());
    place(&mut scene, floor, m, DAffine3::from_translation(DVec3::new(0.0, 1.0, 0.0)));
    let lamp = material(&mut scene, "surface l() { Ci = 7 * emission(); }", &[]);
    let quad = mesh(&mut scene, wall());
    let turned = DAffine3::from_rotation_z(2.5);
    place(&mut scene, quad, lamp, DAffine3 { translation: DVec3::new(3.0, -3.0, 0.5), ..turned });
    let (float, plain) = render_with(&scene, &[]);
    let (half, short) = render_with(&scene, &[("path_state", "half")]);
    let off = apart(&half, &float);
    assert!(off > 1e-6, "nothing is rounded");
    assert!(off < 2.0 / 2048.0, "{off}");
    assert!(short.bytes_per_path < plain.bytes_per_path, "{} {}", short.bytes_per_path, plain.bytes_per_path);
}

/// What is too large for 16 bits becomes the largest there, and is counted.
#[test]
fn half_path_state_counts_what_it_clamps() {
    let mut scene = wall_under_sky("surface d() { Ci = 2e5 * diffuse(N); }");
    scene.integrator.samples = 2;
    scene.camera.hfov_degrees = 20.0;
    let (picture, summary) = render_with(&scene, &[("path_state", "half")]);
    let middle = picture.pixels[picture.width * picture.height / 2 + picture.width / 2];
    assert_eq!(middle, [65504.0; 3]);
    // The wall fills the picture: all channels of all samples.
    assert_eq!(summary.counts.clamped, 3 * 2 * 16 * 16);
    let (picture, summary) = render_with(&scene, &[]);
    assert!(picture.pixels.iter().flatten().all(|x| (x / 2e5 - 1.0).abs() < 1e-5));
    assert_eq!(summary.counts.clamped, 0);
}

/// A picture whose left half is 0.5 and whose right half is uniform noise from 0 to 1 in every sample.
fn half_noise(width: u32, height: u32, samples: u32) -> Scene {
    let mut scene = empty();
    scene.film = Film { width, height };
    scene.integrator.samples = samples;
    scene.integrator.max_depth = 1;
    scene.camera.hfov_degrees = 2.0 * (0.2f64).atan().to_degrees();
    let m = material(&mut scene, "surface s() { Ci = (u < 0.5 ? 0.5 : noise(\"cell\", 1e5 * P)) * emission(); }", &[]);
    scene.materials[m.0 as usize].sampled_light = false;
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    scene
}

/// Mean and standard deviation of the pixels of the right half.
fn right_half(picture: &Picture) -> (f64, f64) {
    let right = picture.pixels.iter().enumerate().filter(|(i, _)| i % picture.width >= picture.width / 2);
    let values: Vec<f64> = right.map(|(_, p)| f64::from(p[0])).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
}

/// A sample of the right half has the variance 1/12: the relative error is below 0.05 from 128 samples on, as 0.51^2 = 0.5^2 + 0.01.
#[test]
fn adaptive_sampling_ends_where_the_error_is_small() {
    let scene = half_noise(64, 32, 512);
    let (uniform, _) = render_with(&scene, &[]);
    let (picture, summary) = render_with(&scene, &[("adaptive", "0.05")]);
    let outcome = summary.adaptive.expect("it is on");
    let (least, most, mean) = outcome.samples;
    assert_eq!(outcome.tiles, (32, 32));
    assert_eq!(least, 24, "the second look ends what has no noise");
    assert!((96..=192).contains(&most), "{most}");
    // What the film had is what was counted, and less than half of what each pixel alike would have needed.
    assert_eq!(summary.counts.samples as f64, mean * 64.0 * 32.0);
    assert!(mean < 0.65 * f64::from(most), "{outcome:?}");
    assert!((outcome.saved - (1.0 - mean / 512.0)).abs() < 1e-9);
    // The flat half is what it is, the noisy one as noisy as was asked for, and not biased: its mean is within 4 standard deviations.
    assert!(picture.pixels.iter().enumerate().all(|(i, p)| i % 64 >= 32 || *p == [0.5; 3]));
    let (found, spread) = right_half(&picture);
    assert!(spread / 0.51 < 0.055, "{spread}");
    let (wanted, _) = right_half(&uniform);
    let per_pixel = (1.0 / 12.0 / 96.0f64).sqrt() / (32.0f64 * 32.0).sqrt();
    assert!((found - 0.5).abs() < 4.0 * per_pixel && (found - wanted).abs() < 4.0 * per_pixel, "{found} {wanted}");
}

/// In a picture of more pixels than there are paths in flight: each pixel that goes on keeps its samples.
#[test]
fn pixels_that_go_on_are_as_without_adaptive_sampling() {
    let scene = half_noise(192, 176, 32);
    let (uniform, _) = render_with(&scene, &[]);
    let (picture, summary) = render_with(&scene, &[("adaptive", "0.0001")]);
    // A column of tiles of the flat half goes on beside the noisy one.
    assert_eq!(summary.adaptive.expect("it is on").samples, (24, 32, 28.0 + 8.0 * 8.0 / 192.0));
    assert_eq!(picture.pixels, uniform.pixels);
}

/// Each sample of `all` has every lobe's colour, and what the surface emits once; one of `one` has one lobe's, so that pixels differ.
#[test]
fn all_lobes_are_followed_once_a_sample() {
    let mut scene = empty();
    scene.integrator.samples = 3;
    let source = "surface d() { Ci = color(0.2, 0, 0) * diffuse(N) + color(0, 0.3, 0) * oren_nayar(N, 0)
        + color(0, 0, 0.4) * translucent(N) + 0.25 * emission(); }";
    let m = material(&mut scene, source, &[]);
    scene.materials[m.0 as usize].sampled_light = false;
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    let sky = material(&mut scene, "surface s() { Ci = background(); }", &[]);
    scene.environment = Some(sky);
    let wanted = [0.45, 0.55, 0.65];
    let off = |picture: &Picture| {
        let values = picture.pixels.iter().flat_map(|p| [0, 1, 2].map(|c| (f64::from(p[c]) - wanted[c]).abs()));
        values.fold(0.0, f64::max)
    };
    let (all, summary) = render_with(&scene, &[("lobes", "all")]);
    assert!(off(&all) < 1e-5, "{}", off(&all));
    let pixels = 16 * 16;
    assert_eq!(summary.counts.samples, 3 * pixels, "turns are no samples");
    // Of each sample three camera rays, and one behind each of the lobes.
    assert_eq!(summary.counts.rays, 3 * 3 * 2 * pixels);
    let (one, summary) = render_with(&scene, &[]);
    assert!(off(&one) > 0.1, "one lobe a sample: {}", off(&one));
    assert_eq!(summary.counts.rays, 3 * 2 * pixels);
}

/// Whoever takes paths on, they are the same: between two balls and a wall, with more pixels than there are slots for on a small device, so
/// that samples begin where others end.
#[test]
fn followed_paths_are_the_same_paths() {
    let mut scene = empty();
    scene.film = Film { width: 160, height: 128 };
    scene.integrator.samples = 5;
    let ball = mesh(&mut scene, sphere());
    let glossy = "surface g() { Ci = 0.4 * diffuse(N) + 0.3 * reflection(N) + 0.2 * transparent(); }";
    let sources = [(glossy, -1.0), ("surface d() { Ci = 0.8 * diffuse(N) + 0.1 * emission(); }", 1.0)];
    for (source, x) in sources {
        let material = material(&mut scene, source, &[]);
        place(&mut scene, ball, material, DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)));
    }
    let matte = material(&mut scene, "surface m() { Ci = 0.5 * oren_nayar(N, 0.3); }", &[]);
    let behind = mesh(&mut scene, wall());
    place(&mut scene, behind, matte, DAffine3::from_scale(DVec3::splat(4.0)));
    let sky = material(&mut scene, "surface s() { Ci = 0.7 * background(); }", &[]);
    scene.environment = Some(sky);
    let others = [
        &[("roulette", "3")][..],
        &[("lobes", "all"), ("path_state", "half")],
        &[("precision", "fast"), ("sampler", "independent")],
        &[("precision", "reference"), ("depth", "3")],
    ];
    for settings in others {
        let (picture, summary) = render_with(&scene, settings);
        let (apart, kernels) = render_with(&scene, &[settings, &[("follow", "off")]].concat());
        assert_eq!(summary.counts.samples, kernels.counts.samples, "{settings:?}");
        if settings.contains(&("precision", "fast")) {
            // Relaxed arithmetic is rounded as the kernel around it lets it, and a rounding may send a path elsewhere.
            let (followed, apart) = (mean(&picture), mean(&apart));
            assert!((0..3).all(|c| (followed[c] / apart[c] - 1.0).abs() < 1e-4), "{followed:?} {apart:?}");
        } else {
            assert_eq!(summary.counts, kernels.counts, "{settings:?}");
            assert!(picture.pixels == apart.pixels, "{settings:?}: other bits");
        }
        let launched = |summary: &Summary, name: &str| summary.launches.keys().any(|(stage, _)| stage.name() == name);
        assert!(launched(&summary, "follow_path") && !launched(&summary, "sample_next"), "{settings:?}");
        assert!(launched(&kernels, "select_bsdf") && launched(&kernels, "sample_next"), "{settings:?}");
    }
}

/// Alpha is a sample's, not a turn's.
#[test]
fn what_is_held_out_counts_once_a_sample() {
    let mut scene = empty();
    scene.integrator.samples = 3;
    let source = "surface d() { Ci = 0.2 * diffuse(N) + 0.3 * oren_nayar(N, 0) + 0.25 * holdout(); }";
    let m = material(&mut scene, source, &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    for lobes in ["one", "all"] {
        let alpha = render_with(&scene, &[("lobes", lobes)]).0.alpha;
        assert!(alpha.iter().all(|a| (a - 0.75).abs() < 1e-6), "{lobes}: {alpha:?}");
    }
}

/// Through bounces, lights and roulette the mean is the same, and the noise of a sample less.
#[test]
fn all_lobes_have_the_mean_of_one() {
    let mut scene = empty();
    scene.integrator.samples = 64;
    scene.integrator.max_depth = 6;
    scene.integrator.roulette_from = Some(3);
    let source = "surface d() { Ci = color(0.6, 0.1, 0.3) * diffuse(N) + color(0.1, 0.5, 0.3) * ward(N, dPdu, 0.3, 0.2)
        + 0.02 * emission(); }";
    let m = material(&mut scene, source, &[]);
    let ball = mesh(&mut scene, sphere());
    place(&mut scene, ball, m, DAffine3::IDENTITY);
    let behind = mesh(&mut scene, wall());
    place(&mut scene, behind, m, DAffine3::from_translation(DVec3::new(0.0, 1.0, 0.0)));
    let lamp = material(&mut scene, "surface l() { Ci = 4 * emission(); }", &[]);
    let quad = mesh(&mut scene, wall());
    let turned = DAffine3::from_rotation_z(2.5);
    place(&mut scene, quad, lamp, DAffine3 { translation: DVec3::new(3.0, -3.0, 0.5), ..turned });
    let sky = material(&mut scene, "surface s() { Ci = (0.5 + 0.4 * I[2]) * background(); }", &[]);
    scene.environment = Some(sky);
    for sampler in ["sobol", "independent"] {
        let (one, _) = render_with(&scene, &[("sampler", sampler)]);
        let (all, _) = render_with(&scene, &[("sampler", sampler), ("lobes", "all")]);
        let (a, b) = (mean(&one), mean(&all));
        for c in 0..3 {
            assert!((a[c] - b[c]).abs() < 0.01 * a[c], "{sampler}: {a:?}, all lobes {b:?}");
        }
        assert_ne!(one.pixels, all.pixels);
    }
}
