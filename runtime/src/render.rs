//! Renders a scene once. How the parts are put together stands in `session`.
//!
//! In: a scene, a device, settings. Out: a picture and a summary. It must not know the command line or picture files.

use crate::adaptive;
use crate::choices::Choices;
use crate::device::Device;
use crate::film::Picture;
use crate::materials::{self, Compiled};
use crate::plan::{Effect, Plan, Stage};
use crate::roads::Road;
use crate::scene::{self, MaterialId, Scene};
use crate::session::Session;
use crate::wavefront::Counts;
use crate::{accel, device, displace, package, points, programs, textures, told, traced, vertex_data};
use oslcl_compiler::Radiance;
use std::collections::BTreeMap;
use std::time::Duration;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene contradicts itself.
    #[error(transparent)]
    Scene(#[from] scene::Error),
    /// A material does not compile.
    #[error(transparent)]
    Material(#[from] materials::Error),
    /// A surface can't be displaced.
    #[error(transparent)]
    Displacement(#[from] displace::Error),
    /// The geometry can't be built.
    #[error(transparent)]
    Geometry(#[from] accel::Error),
    /// The device refuses.
    #[error(transparent)]
    Device(#[from] device::Error),
    /// A program does not build.
    #[error(transparent)]
    Program(#[from] programs::Error),
    /// What came back as messages is none.
    #[error(transparent)]
    Messages(#[from] oslcl_compiler::messages::Damaged),
    /// The point clouds can't be held.
    #[error(transparent)]
    Points(#[from] points::Error),
    /// The textures can't be held.
    #[error(transparent)]
    Textures(#[from] textures::Error),
    /// There is more userdata than can be numbered.
    #[error(transparent)]
    Userdata(#[from] vertex_data::TooMuch),
    /// A parameter that a session can't set.
    #[error("material `{material}`: {cause}")]
    Parameter {
        /// The material.
        material: String,
        /// What is wrong.
        cause: String,
    },
    /// Nothing to render.
    #[error("the scene has neither surfaces nor an environment: there is nothing to see")]
    Empty,
    /// Nothing to render but an environment that is black.
    #[error("the scene has no surfaces, and its environment is black: {}", dark(material))]
    Dark {
        /// The environment's material.
        material: String,
    },
    /// A picture too large for its pixels to be numbered.
    #[error("a picture of {width} x {height} pixels is too large: at most 2^30 pixels are possible")]
    TooLarge {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
}

/// Settings that are not the scene's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// What accuracy is bought with time. [`Choices::apply`] is for the caller: it changes the scene.
    pub choices: Choices,
    /// How materials' code gets into programs.
    pub road: Road,
    /// Stop after this long with the samples that are done, all pixels alike; at least one sample is taken.
    pub time_limit: Option<Duration>,
}

/// How far a render is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// Programs are built or loaded.
    Building(programs::Step),
    /// Rays are under way.
    Rendering {
        /// Counts so far.
        counts: Counts,
        /// Paths in all: pixels times samples.
        total: u64,
        /// Since the first ray.
        elapsed: Duration,
    },
}

/// What a render was.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Name of the device.
    pub device: String,
    /// Samples per pixel taken; where pixels may end early, the most.
    pub samples: u32,
    /// What came of that.
    pub adaptive: Option<adaptive::Outcome>,
    /// Compiling materials.
    pub compile_time: Duration,
    /// Building programs.
    pub build_time: Duration,
    /// Building and uploading geometry.
    pub geometry_time: Duration,
    /// Tracing.
    pub render_time: Duration,
    /// Rays and samples.
    pub counts: Counts,
    /// The plan that was carried out.
    pub plan: Plan,
    /// Bytes of state that each path in flight has.
    pub bytes_per_path: u64,
    /// How often each stage was launched, by stage and material.
    pub launches: BTreeMap<(Stage, Option<MaterialId>), u32>,
    /// The buffers that all stages see, by name, with their bytes.
    pub buffers: Vec<(&'static str, u64)>,
    /// How programs came about.
    pub programs: programs::Tally,
    /// How many shaders were compiled, and how many came compiled in packages.
    pub shaders: (u32, u32),
    /// Warnings of the materials.
    pub warnings: Vec<String>,
    /// What the materials printed.
    pub messages: told::Messages,
}

/// Compiles a scene's materials and plans it: all that is decided before a device is needed.
pub fn plan(scene: &Scene, choices: &Choices) -> Result<(Plan, Compiled), Error> {
    let purpose = Purpose { interactive: false, road: Road::default(), explain: false };
    plan_for(scene, &choices.overrides.apply(scene), choices, purpose)
}

/// As [`plan`], with the parameters that decide about each effect ([`crate::plan::ShaderPlace::deciders`]): materials are compiled several
/// times to find them.
pub fn explained_plan(scene: &Scene, choices: &Choices) -> Result<(Plan, Compiled), Error> {
    let purpose = Purpose { interactive: false, road: Road::default(), explain: true };
    plan_for(scene, &choices.overrides.apply(scene), choices, purpose)
}

/// What a plan is made for.
#[derive(Clone, Copy)]
pub(crate) struct Purpose {
    /// Interactive parameters can change between renders.
    pub interactive: bool,
    /// How materials' code gets into programs.
    pub road: Road,
    /// It says which parameters decide.
    pub explain: bool,
}

/// As [`plan`], of the scene as the choices leave what is `written`.
pub(crate) fn plan_for(
    written: &Scene,
    scene: &Scene,
    choices: &Choices,
    purpose: Purpose,
) -> Result<(Plan, Compiled), Error> {
    scene.check()?;
    let pixels = u64::from(scene.film.width) * u64::from(scene.film.height);
    if pixels > 1 << 30 {
        return Err(Error::TooLarge { width: scene.film.width, height: scene.film.height });
    }
    if scene.instances.is_empty() && scene.environment.is_none() {
        return Err(Error::Empty);
    }
    let mut compiled = materials::compile_for(scene, purpose.interactive, purpose.road, purpose.explain)?;
    if written.environment.is_some()
        && let Some(id) = scene.environment
        && let Some(artifact) = &compiled.artifacts[id.0 as usize]
        && artifact.background == Radiance::None
    {
        let material = scene.materials[id.0 as usize].name.clone();
        if scene.instances.is_empty() {
            return Err(Error::Dark { material });
        }
        compiled.warnings.push(format!("warning: the environment is black: {}\n", dark(&material)));
    }
    if choices.overrides.removes(Effect::Interactive) {
        always_open(scene, &compiled)?;
    }
    let plan = Plan::new(written, scene, &compiled.artifacts, choices);
    compiled.warnings.extend(plan.warnings());
    compiled.warnings.extend(traced::warnings(scene, &compiled.artifacts));
    Ok((plan, compiled))
}

/// Code that reads values of parameters at run time can't do without them.
fn always_open(scene: &Scene, compiled: &Compiled) -> Result<(), materials::Error> {
    for (material, artifact) in scene.materials.iter().zip(&compiled.artifacts) {
        let Some((artifact, from)) = artifact.as_ref().zip(material.package.as_ref()) else { continue };
        if !artifact.inputs.interactive.is_empty() {
            let names: Vec<&str> = artifact.inputs.interactive.iter().map(|s| s.name.as_str()).collect();
            let (shader, names) = (artifact.name.clone(), names.join(", "));
            let cause = Box::new(package::Error::MustBeInteractive { shader, names });
            return Err(materials::Error::Package { at: from.at.clone(), material: material.name.clone(), cause });
        }
    }
    Ok(())
}

/// Why an environment is black.
fn dark(material: &str) -> String {
    format!("material `{material}` puts no background() into Ci, or one of weight 0")
}

/// Renders a scene. `watch` hears of the progress each time that the device is asked for it.
///
/// ```no_run
/// use oslcl_runtime::{device::Device, render, scene};
///
/// let scene = scene::load("scenes/gallery.toml".as_ref())?;
/// let device = Device::open(None)?;
/// let (picture, summary) = render::render(&scene, &device, &render::Options::default(), &mut |_| {})?;
/// assert_eq!(picture.pixels.len(), picture.width * picture.height);
/// println!("{} rays in {:?}", summary.counts.rays, summary.render_time);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn render(
    scene: &Scene,
    device: &Device,
    options: &Options,
    watch: &mut dyn FnMut(&Progress),
) -> Result<(Picture, Summary), Error> {
    Session::build(scene, device, options, false, watch)?.render(watch)
}

/// The film's numbers as a picture.
pub(crate) fn picture(
    scene: &Scene,
    options: &Options,
    seed: u64,
    samples: u32,
    data: &[f64],
    channels: usize,
) -> Picture {
    // In f64 radiance can be what f32 calls infinite.
    let narrow = |x: f64| x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
    let pixels = data.chunks(channels).map(|p| [narrow(p[0]), narrow(p[1]), narrow(p[2])]).collect();
    let alpha = if channels > 3 { data.chunks(channels).map(|p| p[3] as f32).collect() } else { Vec::new() };
    let attributes = [
        ("oslcl:samples", samples.to_string()),
        ("oslcl:seed", seed.to_string()),
        ("oslcl:max_depth", scene.integrator.max_depth.to_string()),
        ("oslcl:precision", format!("{:?}", options.choices.precision).to_lowercase()),
    ];
    Picture {
        width: scene.film.width as usize,
        height: scene.film.height as usize,
        pixels,
        alpha,
        attributes: attributes.map(|(name, value)| (name.to_owned(), value)).to_vec(),
    }
}

/// Samples of the next pass under a time limit: as many as the speed so far lets hope for, at most as many again as are
/// done, so that a wrong guess costs little. 0: the time is up.
pub(crate) fn next_pass(done: u32, wanted: u32, elapsed: Duration, limit: Duration) -> u32 {
    if done == 0 {
        return 1;
    }
    let per_sample = elapsed.as_secs_f64() / f64::from(done);
    let left = limit.saturating_sub(elapsed).as_secs_f64();
    let fits = (left / per_sample.max(1e-9)) as u32;
    fits.min(done).min(wanted - done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_fit_the_time_limit() {
        let second = Duration::from_secs(1);
        assert_eq!(next_pass(0, 64, Duration::ZERO, second), 1);
        assert_eq!(next_pass(4, 64, second / 10, second), 4);
        assert_eq!(next_pass(8, 64, second * 9 / 10, second), 0);
        assert_eq!(next_pass(60, 64, second / 10, second), 4);
    }
}
