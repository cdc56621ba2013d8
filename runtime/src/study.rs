//! A study of a scene: what each choice between accuracy and time costs and buys there.
//!
//! In: a scene, a device, how many samples and seeds. Out: a [`Row`] per variation, measured against a reference: the same scene in
//! f64 with many samples, kept as files for the next study. It must not know the command line or tables.
//!
//! Renders of different variations take turns, so that what else the machine does falls on all alike.

use crate::choices::{Choices, PROFILES, TABLE};
use crate::device::Device;
use crate::film::{self, Picture};
use crate::measure::{Measured, Run, measure};
use crate::plan::{Effect, Plan};
use crate::render::{Error, Options};
use crate::scene::Scene;
use crate::session::Session;
use std::path::{Path, PathBuf};

/// How much work a study is.
#[derive(Clone, Debug, PartialEq)]
pub struct Effort {
    /// Samples per pixel of each variation.
    pub samples: u32,
    /// Renders of each variation, at least 2.
    pub seeds: u32,
    /// Samples per pixel of the reference.
    pub reference_samples: u32,
    /// Where references are kept.
    pub references: PathBuf,
}

/// One way to render the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Variation {
    /// What differs from the default.
    pub name: String,
    /// All choices.
    pub choices: Choices,
    /// Samples per pixel.
    pub samples: u32,
}

/// A variation and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Which.
    pub variation: Variation,
    /// Its errors and times.
    pub measured: Measured,
    /// Values that had to be repaired, in all renders.
    pub repaired: u64,
}

/// What a study found.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// The device's name.
    pub device: String,
    /// The default first.
    pub rows: Vec<Row>,
    /// Relative MSE of the reference itself, as its halves tell it.
    pub reference_error: f64,
    /// Whether the reference was there already.
    pub reference_was_kept: bool,
    /// Whether the reference is in f64: else the device has no such numbers.
    pub reference_is_double: bool,
}

/// Why there is no study.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A render fails.
    #[error("{variation}: {cause}")]
    Render {
        /// Which.
        variation: String,
        /// Why.
        cause: Box<Error>,
    },
    /// The reference can't be kept or read.
    #[error(transparent)]
    Film(#[from] film::Error),
    /// There is no folder for references.
    #[error("cannot make the folder {} for references: {cause}", folder.display())]
    Folder {
        /// Which.
        folder: PathBuf,
        /// Why.
        cause: std::io::Error,
    },
}

/// All variations that mean something for a plan: the default, each other value of each setting, profiles, fewer and more samples.
pub fn variations(scene: &Scene, plan: &Plan, samples: u32) -> Vec<Variation> {
    let default = Choices::default();
    let variation = |name: String, choices: Choices, samples: u32| Variation { name, choices, samples };
    let mut out = vec![variation("default".to_owned(), default, samples)];
    for row in TABLE {
        for value in tried(row.name, row.values, scene, plan) {
            let mut choices = default;
            if choices.set(row.name, &value).is_ok() && choices != default {
                out.push(variation(format!("{}={value}", row.name), choices, samples));
            }
        }
    }
    for (name, _) in PROFILES {
        if let Ok(choices) = Choices::profile(name)
            && choices != default
        {
            out.push(variation(format!("profile {name}"), choices, samples));
        }
    }
    if samples >= 4 {
        out.push(variation(format!("spp={}", samples / 4), default, samples / 4));
    }
    out.push(variation(format!("spp={}", samples.saturating_mul(4)), default, samples.saturating_mul(4)));
    out
}

/// The values of a setting that a scene can tell apart.
fn tried(name: &str, values: &[&str], scene: &Scene, plan: &Plan) -> Vec<String> {
    let list = |values: &[&str]| values.iter().map(|v| (*v).to_owned()).collect();
    match name {
        "lobes" if !plan.chooses_lobes() => Vec::new(),
        "lights" if !plan.has(Effect::Lights) => Vec::new(),
        "environment_map" if !plan.has(Effect::EnvironmentSampling) => Vec::new(),
        "environment_map" => list(&["64", "128", "256", "1024", "2048"]),
        "texture_filter" | "texture_mip_bias" if !plan.has(Effect::Textures) => Vec::new(),
        "texture_mip_bias" => list(&["-1", "1", "2"]),
        "intersection" if !plan.has(Effect::Surfaces) => Vec::new(),
        "follow" if !plan.follows() => Vec::new(),
        "tree" => list(&["fast", "medium"]),
        "depth" => {
            let shorter = [2, 3, 5, 8, 16].into_iter().filter(|d| *d < scene.integrator.max_depth);
            shorter.map(|d| d.to_string()).collect()
        }
        "roulette" => list(&["2", "5", "off"]),
        "adaptive" => list(&["0.2", "0.1", "0.05", "0.02"]),
        _ => list(values),
    }
}

/// Measures all variations. `watch` hears what is being done.
pub fn run(scene: &Scene, device: &Device, effort: &Effort, watch: &mut dyn FnMut(&str)) -> Result<Study, StudyError> {
    let failed = |name: &str| {
        let variation = name.to_owned();
        move |cause: Error| StudyError::Render { variation, cause: Box::new(cause) }
    };
    watch("reference");
    let reference = reference(scene, device, effort, watch)?;
    let mut plain = scene.clone();
    plain.integrator.samples = effort.samples;
    let (plan, _) = crate::render::plan(&plain, &Choices::default()).map_err(failed("plan"))?;
    let mut variations = variations(&plain, &plan, effort.samples);
    if !device.info.double {
        variations.retain(|v| v.choices.needs_double().is_none());
    }
    // Scenes that differ in depth, roulette or samples; the sessions borrow them.
    let scenes: Vec<Scene> = variations
        .iter()
        .map(|v| {
            let mut scene = plain.clone();
            scene.integrator.samples = v.samples;
            v.choices.apply(&mut scene.integrator);
            scene
        })
        .collect();
    let mut sessions = Vec::with_capacity(variations.len());
    for (v, scene) in variations.iter().zip(&scenes) {
        watch(&format!("preparing {}", v.name));
        let options = Options { choices: v.choices, ..Options::default() };
        sessions.push(Session::new(scene, device, &options).map_err(failed(&v.name))?);
    }
    // Once each before the first turn: drivers load kernels at their first launch.
    for (v, session) in variations.iter().zip(&mut sessions) {
        watch(&format!("first run: {}", v.name));
        session.set_seed(SEEDS);
        session.render(&mut |_| {}).map_err(failed(&v.name))?;
    }
    let mut runs: Vec<Vec<Run>> = vec![Vec::new(); variations.len()];
    let mut repaired = vec![0; variations.len()];
    for seed in 0..effort.seeds {
        for (i, session) in sessions.iter_mut().enumerate() {
            watch(&format!("seed {} of {}: {}", seed + 1, effort.seeds, variations[i].name));
            session.set_seed(SEEDS + u64::from(seed));
            let (picture, summary) = session.render(&mut |_| {}).map_err(failed(&variations[i].name))?;
            repaired[i] += u64::from(summary.counts.repaired);
            runs[i].push(Run { picture, seconds: summary.render_time.as_secs_f64() });
        }
    }
    let rows = variations.into_iter().zip(runs).zip(repaired).filter_map(|((variation, runs), repaired)| {
        let measured = measure(&runs, &reference.picture, reference.error)?;
        Some(Row { variation, measured, repaired })
    });
    Ok(Study {
        device: device.info.name.clone(),
        rows: rows.collect(),
        reference_error: reference.error,
        reference_was_kept: reference.kept,
        reference_is_double: device.info.double,
    })
}

/// Seeds of the variations, and of the reference's halves: far from each other and from those of users.
const SEEDS: u64 = 0x5eed_0000;
const REFERENCE_SEEDS: [u64; 2] = [0x000e_f000_0001, 0x000e_f000_0002];

struct Reference {
    picture: Picture,
    /// Its relative MSE.
    error: f64,
    kept: bool,
}

/// The reference: the mean of two halves with seeds of their own, from files or rendered.
fn reference(
    scene: &Scene,
    device: &Device,
    effort: &Effort,
    watch: &mut dyn FnMut(&str),
) -> Result<Reference, StudyError> {
    let failed = |cause: Error| StudyError::Render { variation: "reference".to_owned(), cause: Box::new(cause) };
    let mut scene = scene.clone();
    scene.integrator.samples = (effort.reference_samples / 2).max(1);
    let mut choices = Choices::profile("reference").unwrap_or_default();
    if !device.info.double {
        choices.precision = Choices::default().precision;
    }
    choices.apply(&mut scene.integrator);
    let mut session = Session::new(&scene, device, &Options { choices, ..Options::default() }).map_err(failed)?;
    let name = session.fingerprint().map_err(failed)?;
    std::fs::create_dir_all(&effort.references)
        .map_err(|cause| StudyError::Folder { folder: effort.references.clone(), cause })?;
    let mut kept = true;
    let mut half = |seed: u64| -> Result<Picture, StudyError> {
        let file = format!("{}-{}-{seed:x}.exr", &name.to_hex()[..32], scene.integrator.samples);
        let path = effort.references.join(file);
        if let Some(picture) = known(&path, &scene) {
            return Ok(picture);
        }
        kept = false;
        watch(&format!("reference, {} samples per pixel, half with seed {seed:x}", scene.integrator.samples));
        session.set_seed(seed);
        let (picture, _) = session.render(&mut |_| {}).map_err(failed)?;
        film::write(&path, &picture, 0.0)?;
        Ok(picture)
    };
    let (a, b) = (half(REFERENCE_SEEDS[0])?, half(REFERENCE_SEEDS[1])?);
    // Halves of variance s each differ by 2 s; their mean has s / 2.
    let error = film::compare::relative_mse(&a, &b).unwrap_or(0.0) / 4.0;
    let pixels = a.pixels.iter().zip(&b.pixels).map(|(p, q)| [0, 1, 2].map(|c| 0.5 * (p[c] + q[c]))).collect();
    Ok(Reference { picture: Picture { pixels, ..a }, error, kept })
}

/// A kept half, if it can be read and has the right size.
fn known(path: &Path, scene: &Scene) -> Option<Picture> {
    let picture = film::read_exr(path).ok()?;
    let size = (picture.width, picture.height);
    (size == (scene.film.width as usize, scene.film.height as usize)).then_some(picture)
}
