//! A scene made ready once and rendered as often as one likes, with other values of interactive parameters each time.
//!
//! In: a scene, a device, settings; then values. Out: pictures and summaries. It must not know the command line.
//!
//! Interactive are parameters declared with `[[ int interactive = 1 ]]` and those that [`crate::scene::Material::interactive`]
//! names, of materials on surfaces and around them; [`crate::render::render`] binds them like all others.

use crate::accel::{self, Geometry};
use crate::adaptive::Adaptive;
use crate::device::Device;
use crate::film::Picture;
use crate::materials::{Compiled, binding};
use crate::plan::{Effect, Plan};
use crate::programs::{self, Kernels};
use crate::render::{self, Error, Options, Progress, Summary};
use crate::scene::{MaterialId, ParamValue, Scene};
use crate::supplies::Supplies;
use crate::told::{self, Heard};
use crate::traced::{self, Traced};
use crate::vertex_data::{self, Table};
use crate::wavefront::{Counts, Spread, Supplied, Wavefront};
use crate::{attributes, device, displace, points, roads, textures};
use std::borrow::Cow;
use std::time::{Duration, Instant};

/// Compiled materials, built programs, geometry: all that does not change between renders.
///
/// ```no_run
/// use oslcl_runtime::scene::{self, MaterialId, ParamValue};
/// use oslcl_runtime::{device::Device, render, session::Session};
///
/// let scene = scene::load("scenes/gallery.toml".as_ref())?;
/// let device = Device::open(None)?;
/// let mut session = Session::new(&scene, &device, &render::Options::default())?;
/// let (before, _) = session.render(&mut |_| {})?;
/// session.set(MaterialId(0), "Kd", &ParamValue::Float(0.5))?;
/// let (after, _) = session.render(&mut |_| {})?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Session<'a> {
    device: &'a Device,
    options: Options,
    /// After displacement.
    scene: Cow<'a, Scene>,
    plan: Plan,
    compiled: Compiled,
    geometry: Geometry,
    kernels: Kernels,
    textures: textures::Packed,
    userdata: Table,
    traced: Traced,
    clouds: points::Packed,
    /// By material.
    values: Vec<Supplies>,
    spread: Spread,
    seed: u64,
    samples: u32,
    heard: Heard,
    compile_time: Duration,
    build_time: Duration,
    geometry_time: Duration,
}

impl<'a> Session<'a> {
    /// Makes a scene ready.
    pub fn new(scene: &'a Scene, device: &'a Device, options: &Options) -> Result<Session<'a>, Error> {
        Session::build(scene, device, options, true, &mut |_| {})
    }

    /// `interactive`: whether values can be set. `watch` hears of the programs.
    pub(crate) fn build(
        scene: &'a Scene,
        device: &'a Device,
        options: &Options,
        interactive: bool,
        watch: &mut dyn FnMut(&Progress),
    ) -> Result<Session<'a>, Error> {
        let written = scene;
        let asked = options.choices;
        let options = Options { choices: asked.settled(), ..*options };
        let interactive = interactive && !asked.overrides.removes(Effect::Interactive);
        let scene = asked.overrides.apply(written);
        if let Some(needs) = options.choices.needs_double().filter(|_| !device.info.double) {
            return Err(device::Error::NoDouble { device: device.info.name.clone(), needs }.into());
        }
        // Better to hear of it now than after the work.
        roads::check(device, options.road).map_err(programs::Error::from)?;
        let start = Instant::now();
        let purpose = render::Purpose { interactive, road: options.road, explain: false };
        let (plan, compiled) = render::plan_for(written, &scene, &asked, purpose)?;
        let compile_time = start.elapsed();

        let start = Instant::now();
        let mut heard = Heard::default();
        let scene = match displace::apply(&scene, &compiled, device, options.choices.precision, &mut heard)? {
            Cow::Owned(displaced) => Cow::Owned(displaced),
            Cow::Borrowed(_) => scene,
        };
        let geometry = accel::build(&scene, &plan.materials, &options.choices)?;
        let has_userdata = plan.has(Effect::Userdata) || plan.has(Effect::Attributes);
        let userdata = match has_userdata {
            true => vertex_data::table(&scene, &compiled.artifacts, &geometry.first_vertices)?,
            false => Table::default(),
        };
        let geometry_time = start.elapsed();

        let pixels = u64::from(scene.film.width) * u64::from(scene.film.height);
        let (seed, samples) = (scene.integrator.seed, scene.integrator.samples);
        let spread = Spread::new(device, &plan, pixels, scene.integrator.samples);
        let textures = match plan.has(Effect::Textures) {
            true => textures::pack(&compiled.textures, compiled.texture_files())?,
            false => textures::Packed::default(),
        };
        let clouds = points::pack(compiled.textures.points(), compiled.cloud_names())?;
        let traced = traced::build(&scene, &compiled.artifacts);
        let values = compiled.values.clone();
        let interactive = interactive_numbers(&compiled, &values);
        let supplied = Supplied {
            textures: &textures,
            userdata: &userdata,
            interactive: &interactive,
            traced: &traced,
            clouds: &clouds,
        };
        Wavefront::check_room(device, &plan, pixels, &geometry, &supplied, spread)?;
        let start = Instant::now();
        let modules = roads::modules(&compiled.artifacts, options.choices.precision);
        let mut told = |step| watch(&Progress::Building(step));
        let kernels = programs::build(device, &plan, &modules, &mut told)?;
        let build_time = start.elapsed();
        Ok(Session {
            device,
            options,
            scene,
            plan,
            compiled,
            geometry,
            kernels,
            textures,
            userdata,
            traced,
            clouds,
            values,
            spread,
            seed,
            samples,
            heard,
            compile_time,
            build_time,
            geometry_time,
        })
    }

    /// The plan that is carried out.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Sets an interactive parameter of a material; in a group its name is `layer.param`.
    pub fn set(&mut self, material: MaterialId, name: &str, value: &ParamValue) -> Result<(), Error> {
        let index = material.0 as usize;
        let called = self.scene.materials.get(index).map_or_else(|| format!("number {index}"), |m| m.name.clone());
        let refuse = |cause: String| Err(Error::Parameter { material: called, cause });
        let Some(artifact) = self.compiled.artifacts.get(index).and_then(Option::as_ref) else {
            return refuse("it is on no surface and not around the scene".into());
        };
        let slots = &artifact.inputs.interactive;
        let Some(slot) = slots.iter().find(|s| s.name == name) else {
            let known: Vec<&str> = slots.iter().map(|s| s.name.as_str()).collect();
            let known =
                if known.is_empty() { "none is".to_owned() } else { format!("these are: {}", known.join(", ")) };
            return refuse(format!("`{name}` is no interactive parameter; {known}"));
        };
        let value = binding(value);
        if value.numbers(slot).is_none() {
            return refuse(format!("the value does not fit `{name}`, which is of type {}", slot.ty));
        }
        let list = &mut self.values[index].interactive;
        list.retain(|(other, _)| other != name);
        list.push((name.to_owned(), value));
        Ok(())
    }

    /// Takes other random numbers for the next renders than the scene's seed gives.
    pub fn set_seed(&mut self, seed: u64) {
        self.seed = seed;
    }

    /// Takes another number of samples per pixel in the next renders than the scene's, at least 1.
    pub fn set_samples(&mut self, samples: u32) {
        self.samples = samples.max(1);
    }

    /// A name for all that decides the picture but the seed and the number of samples: programs, geometry, textures, values of
    /// interactive parameters, camera.
    pub fn fingerprint(&self) -> Result<blake3::Hash, Error> {
        let mut hasher = blake3::Hasher::new();
        let scene = self.scene.as_ref();
        let small = (&scene.camera, scene.film, scene.integrator.max_depth, scene.integrator.roulette_from);
        hasher
            .update(format!("{small:?} {:?} {:?} {:?}", scene.filter, scene.conventions, self.plan.choices).as_bytes());
        for program in &self.plan.programs {
            hasher.update(programs::source(&self.plan, program).map_err(programs::Error::from)?.as_bytes());
        }
        self.geometry.visit_bytes(&mut |bytes| _ = hasher.update(bytes));
        for (value, int) in interactive_numbers(&self.compiled, &self.values) {
            hasher.update(&value.to_le_bytes()).update(&[u8::from(int)]);
        }
        let words = self.textures.words.iter().chain(&self.userdata.places);
        let words = words.chain(&self.traced.sets).chain(&self.traced.names);
        let words = words.chain(&self.clouds.words);
        words.for_each(|w| _ = hasher.update(&w.to_le_bytes()));
        self.userdata.values.iter().for_each(|x| _ = hasher.update(&x.to_le_bytes()));
        Ok(hasher.finalize())
    }

    /// Renders with the present values. `watch` hears of the progress each time that the device is asked for it.
    pub fn render(&mut self, watch: &mut dyn FnMut(&Progress)) -> Result<(Picture, Summary), Error> {
        let (device, scene, plan) = (self.device, self.scene.as_ref(), &self.plan);
        let start = Instant::now();
        let interactive = interactive_numbers(&self.compiled, &self.values);
        let supplied = Supplied {
            textures: &self.textures,
            userdata: &self.userdata,
            interactive: &interactive,
            traced: &self.traced,
            clouds: &self.clouds,
        };
        let mut wavefront =
            Wavefront::new(device, plan, &self.kernels, scene, &mut self.geometry, &supplied, self.spread)?;
        wavefront.set_seed(self.seed);
        device.finish()?;
        let geometry_time = self.geometry_time + start.elapsed();

        let start = Instant::now();
        wavefront.warm_up()?;
        self.kernels.keep(device);
        let build_time = self.build_time + start.elapsed();

        let start = Instant::now();
        let wanted = self.samples;
        let channels = plan.layout.film_channels() as usize;
        let (width, height) = (scene.film.width as usize, scene.film.height as usize);
        let threshold = plan.choices.adaptive.filter(|_| plan.is_asked(Effect::Adaptive));
        let mut adaptive = threshold.map(|t| Adaptive::new(t.error(), width, height, channels));
        // Samples that are done of each pixel that goes on, and how many pixels that is.
        let (mut done, mut pixels) = (0, (width * height) as u64);
        let mut taken = 0;
        while done < wanted && pixels > 0 {
            let end = adaptive.as_ref().map_or(wanted, |a| a.next_look().min(wanted));
            let next = match self.options.time_limit {
                None => end - done,
                Some(limit) => render::next_pass(done, end, start.elapsed(), limit),
            };
            if next == 0 {
                break;
            }
            let total = taken + pixels * u64::from(wanted - done);
            let mut report = |counts: &Counts| {
                watch(&Progress::Rendering { counts: *counts, total, elapsed: start.elapsed() });
            };
            wavefront.render(done, done + next, &mut report)?;
            done += next;
            taken += pixels * u64::from(next);
            if let Some(adaptive) = adaptive.as_mut().filter(|_| done == end && done < wanted) {
                adaptive.look(done, &wavefront.sums()?);
                let going_on = adaptive.going_on();
                wavefront.go_on_with(&going_on)?;
                pixels = going_on.len() as u64;
            }
        }
        let (data, adaptive) = match adaptive {
            Some(adaptive) => {
                let (data, outcome) = adaptive.finish(done, wanted, &wavefront.sums()?);
                (data, Some(outcome))
            }
            None => (wavefront.mean(done)?, None),
        };
        let render_time = start.elapsed();
        let counts = wavefront.counts()?;
        let (words, lost) = wavefront.messages()?;
        let mut strings = self.textures.messages.clone();
        if !words.is_empty() {
            strings.extend(attributes::strings(scene));
            strings.extend(traced::names(scene));
            strings.extend(self.clouds.strings.iter().cloned());
            strings.extend(self.values.iter().flat_map(Supplies::strings));
        }
        let mut messages = told::collect(&words, 4 * lost, scene, &self.compiled, &strings)?;
        self.heard.give(&mut messages);
        wavefront.log_times();
        let bytes_per_path = plan.layout.bytes_per_path(self.options.choices.precision.real_bytes());
        let mut picture = render::picture(scene, &self.options, self.seed, done, &data, channels);
        if !plan.is_asked(Effect::Holdout) {
            // Full everywhere.
            picture.alpha.clear();
        }
        let (launches, buffers) = (wavefront.launches(), wavefront.buffers());
        drop(wavefront);
        let summary = Summary {
            device: device.info.name.clone(),
            samples: done,
            adaptive,
            compile_time: self.compile_time,
            build_time,
            geometry_time,
            render_time,
            counts,
            plan: plan.clone(),
            bytes_per_path,
            launches,
            buffers,
            programs: self.kernels.tally(),
            shaders: (self.compiled.compiled, self.compiled.from_packages),
            warnings: self.compiled.warnings.clone(),
            messages,
        };
        Ok((picture, summary))
    }
}

/// The numbers of all materials' interactive parameters, one behind the other as `Plan::interactive` says.
fn interactive_numbers(compiled: &Compiled, values: &[Supplies]) -> Vec<(f64, bool)> {
    let artifacts = compiled.artifacts.iter().zip(values);
    artifacts.filter_map(|(a, v)| Some(v.interactive(a.as_ref()?))).flatten().collect()
}
