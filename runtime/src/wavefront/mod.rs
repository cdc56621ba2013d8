//! The wavefront loop: uploads a scene, launches the stages until every sample is done.
//!
//! In: plan, geometry, kernels. Out: the picture's numbers and counts. It must not know files or shaders.
//!
//! A batch is as many pixels as there are slots for; each slot takes the samples of its pixel one after the other. Queue
//! lengths stay on the device; the host reads them now and then to see whether a batch is done.

mod settings;

use crate::accel::{AliasTable, Geometry};
use crate::device::{Arg, Buffer, Device, DeviceKind, Error, Kernel};
use crate::plan::{BufferId, Constant, Counter, Effect, Plan, Setting, Stage};
use crate::points;
use crate::precision::Precision;
use crate::programs::Kernels;
use crate::scene::{MaterialId, Scene};
use crate::shade::numbers;
use crate::textures::Packed;
use crate::traced::Traced;
use crate::vertex_data::Table;
use settings::{constants, folded, place, settings};
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Work-items of a group; fixed, since some drivers compile a kernel anew for each.
const GROUP: usize = 64;

/// Paths in flight: on a GPU so many that the launches of stages with little to do take a small part of the time; on a CPU few
/// enough for each core's cache.
const PATHS_PER_CORE: u32 = 1 << 13;
const PATHS_GPU: u32 = 1 << 22;

/// Stripes of a launch on a CPU, and groups of a stripe.
const MOST_STRIPES: u32 = 64;
const LEAST_STRIPE: u32 = 4;

/// Reals of a slot's film: sums of four channels, and what each has lost (kernels/stages/accumulate.h).
const FILM_REALS: u64 = 8;

/// Most lobes that a hit can offer (kernels/context.h).
const MOST_TURNS: u64 = 0xffff;

/// Rounds of stages between two looks at the queues.
const ROUNDS_CPU: u32 = 2;
const ROUNDS_GPU: u32 = 8;

/// Words for what shaders print: 4 MiB. What does not fit is lost, and counted.
pub(crate) const MESSAGE_WORDS: u32 = 1 << 20;

/// Largest share of the device's memory that paths in flight take.
const MEMORY_SHARE: u64 = 4;

/// Reals of screen, NDC and raster space.
const OTHER_SPACES: u64 = 3 * 32;

/// What shaders get beside the geometry.
pub struct Supplied<'a> {
    /// The texture files.
    pub textures: &'a Packed,
    /// Data of vertices, and attributes.
    pub(crate) userdata: &'a Table,
    /// The numbers of interactive parameters, and which are ints.
    pub(crate) interactive: &'a [(f64, bool)],
    /// What rays that shaders trace know of objects.
    pub(crate) traced: &'a Traced,
    /// The point clouds.
    pub clouds: &'a points::Packed,
}

/// How a scene is spread over a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spread {
    /// Slots for paths in flight.
    pub paths: u32,
    /// Slots that share a pixel.
    pub slots_per_pixel: u32,
    /// Binary logarithm of how many stripes a queue is read in, so that each core gets its share of a short one
    /// (kernels/context.h).
    pub stripe_bits: u32,
}

impl Spread {
    /// The spread for a picture of this many pixels and samples.
    pub fn new(device: &Device, plan: &Plan, pixels: u64, samples: u32) -> Spread {
        let most = match device.info.kind {
            DeviceKind::Gpu => PATHS_GPU,
            _ => PATHS_PER_CORE * device.info.units.clamp(1, 128),
        };
        let room = (device.info.memory / MEMORY_SHARE).min(device.info.largest_buffer);
        let fits = room / plan.layout.bytes_per_path(plan.choices.precision.real_bytes()).max(1);
        let wanted = (pixels * u64::from(samples)).clamp(GROUP as u64, u64::from(most));
        let paths = wanted.min(fits.max(GROUP as u64)).next_multiple_of(GROUP as u64) as u32;
        let slots_per_pixel = (u64::from(paths) / pixels.max(1)).clamp(1, u64::from(samples)) as u32;
        let stripe_bits = match device.info.kind {
            DeviceKind::Gpu => 0,
            _ => (paths / GROUP as u32 / LEAST_STRIPE).clamp(1, MOST_STRIPES).ilog2(),
        };
        Spread { paths, slots_per_pixel, stripe_bits }
    }
}

/// What was counted on the way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays that looked for the nearest surface.
    pub rays: u64,
    /// Rays that looked whether a light is free.
    pub shadow_rays: u64,
    /// Samples finished.
    pub samples: u64,
    /// Slots that a full queue did not take; always 0.
    pub dropped: u32,
    /// Samples that were not finite and count as black.
    pub repaired: u32,
    /// Numbers that were too large for 16 bits and became the largest there (`path_state = half`).
    pub clamped: u32,
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Counts) {
        self.rays += other.rays;
        self.shadow_rays += other.shadow_rays;
        self.samples += other.samples;
        self.dropped += other.dropped;
        self.repaired += other.repaired;
        self.clamped += other.clamped;
    }
}

/// A scene on a device, being rendered.
pub struct Wavefront<'a> {
    device: &'a Device,
    plan: &'a Plan,
    kernels: &'a Kernels,
    spread: Spread,
    pixels: u64,
    /// How many of them go on: those that the buffer of pixels lists.
    going_on: u64,
    /// Samples that the batches so far had to finish.
    due: u64,
    buffers: HashMap<BufferId, Buffer>,
    settings: [u32; Setting::ALL.len()],
    environment: Option<MaterialId>,
    varying_lights: Vec<MaterialId>,
    /// Every launch so far.
    launches: RefCell<BTreeMap<(Stage, Option<MaterialId>), u32>>,
    /// Time of each stage, when the log asks for it: every launch is waited for then.
    times: Option<RefCell<BTreeMap<Stage, Duration>>>,
}

impl<'a> Wavefront<'a> {
    /// Uploads a scene and prepares its lights.
    pub fn new(
        device: &'a Device,
        plan: &'a Plan,
        kernels: &'a Kernels,
        scene: &Scene,
        geometry: &mut Geometry,
        supplies: &Supplied<'_>,
        spread: Spread,
    ) -> Result<Wavefront<'a>, Error> {
        let _span = tracing::info_span!("upload").entered();
        let pixels = u64::from(scene.film.width) * u64::from(scene.film.height);
        let mut wavefront = Wavefront {
            device,
            plan,
            kernels,
            spread,
            pixels,
            going_on: pixels,
            due: 0,
            buffers: HashMap::new(),
            settings: settings(scene, plan, geometry, spread),
            environment: scene.environment,
            varying_lights: geometry.lights.varying_materials(),
            launches: RefCell::default(),
            times: tracing::enabled!(tracing::Level::DEBUG).then(RefCell::default),
        };
        for (id, name) in plan.layout.buffers() {
            let buffer = wavefront.make(id, name, scene, geometry, supplies)?;
            wavefront.buffers.insert(id, buffer);
        }
        wavefront.weigh_lights(geometry)?;
        wavefront.map_environment()?;
        Ok(wavefront)
    }

    /// Whether the device has room for all of a render, the picture at its end included: to be asked before anything is built.
    pub fn check_room(
        device: &Device,
        plan: &Plan,
        pixels: u64,
        geometry: &Geometry,
        supplies: &Supplied<'_>,
        spread: Spread,
    ) -> Result<(), Error> {
        let numbers = pixels * u64::from(plan.layout.film_channels());
        let real_bytes = plan.choices.precision.real_bytes();
        let mut sizes: Vec<(&str, u64)> = plan
            .layout
            .buffers()
            .map(|(id, name)| (name, size(id, plan, pixels, geometry, supplies, spread)))
            .collect();
        sizes.push(("picture", numbers * real_bytes));
        // `resolve` holds the picture as it came and in f64.
        device.check_room(&sizes, numbers * (real_bytes + 8))
    }

    fn precision(&self) -> Precision {
        self.plan.choices.precision
    }

    fn make(&self, id: BufferId, name: &str, scene: &Scene, g: &Geometry, s: &Supplied<'_>) -> Result<Buffer, Error> {
        let device = self.device;
        let empty = || device.buffer(name, size(id, self.plan, self.pixels, g, s, self.spread));
        let reals = |data: &[f64]| upload_reals(device, name, data, self.precision());
        match id {
            BufferId::Path | BufferId::PathUint | BufferId::Queues => empty(),
            BufferId::EnvironmentCells | BufferId::EnvironmentAlias => empty(),
            BufferId::Counters => device.upload(name, &vec![0u32; self.plan.layout.counter_words()]),
            BufferId::Settings => device.upload(name, &self.settings),
            BufferId::Constants => reals(&constants(scene, self.plan)),
            BufferId::Textures => device.upload(name, &s.textures.words),
            BufferId::OtherSpaces => reals(&scene.camera.other_spaces(scene.film)),
            BufferId::Userdata => device.upload(name, &s.userdata.values),
            BufferId::UserdataPlaces => device.upload(name, &s.userdata.places),
            BufferId::Interactive if self.precision().is_double() => {
                device.upload(name, &numbers::<f64>(s.interactive))
            }
            BufferId::Interactive => device.upload(name, &numbers::<f32>(s.interactive)),
            BufferId::TraceSets => device.upload(name, &s.traced.sets),
            BufferId::TraceNames => device.upload(name, &s.traced.names),
            BufferId::PointClouds => device.upload(name, &s.clouds.words),
            BufferId::Messages => {
                let mut messages = empty()?;
                device.write(&mut messages, &[0, MESSAGE_WORDS])?;
                Ok(messages)
            }
            BufferId::Film => {
                let mut film = empty()?;
                device.clear(&mut film)?;
                Ok(film)
            }
            BufferId::Pixels => device.upload(name, &(0..self.pixels as u32).collect::<Vec<u32>>()),
            BufferId::Nodes => device.upload(name, &g.nodes),
            BufferId::Triangles => reals(&g.triangles),
            BufferId::TriangleIds => device.upload(name, &g.triangle_ids),
            BufferId::Corners => device.upload(name, &g.corners),
            BufferId::Shapes => device.upload(name, &g.shapes),
            BufferId::Normals => device.upload(name, &g.normals),
            BufferId::Uvs => device.upload(name, &g.uvs),
            BufferId::Areas => reals(&g.areas),
            BufferId::ObjectSpaces => reals(&g.object_spaces),
            BufferId::Instances => reals(&g.instances),
            BufferId::InstanceRoots => device.upload(name, &g.instance_roots),
            BufferId::Lights => reals(&g.lights.reals),
            BufferId::LightWords => device.upload(name, &g.lights.words),
        }
    }

    fn args<'b>(&'b self, launch: u32, more: Option<&'b Buffer>) -> Vec<Arg<'b>> {
        let shared = self.plan.layout.buffers().filter_map(|(id, _)| self.buffers.get(&id)).map(Arg::Buffer);
        shared.chain([Arg::U32(launch)]).chain(more.map(Arg::Buffer)).collect()
    }

    fn launch(&self, kernel: &Kernel, launch: u32, more: Option<&Buffer>, items: u64) -> Result<(), Error> {
        let global = (items as usize).next_multiple_of(GROUP).max(GROUP);
        kernel.launch(self.device, &self.args(launch, more), global, GROUP)
    }

    /// Lets the shaders of varying lights say how bright they are, so that the choice among lights knows it.
    fn weigh_lights(&mut self, geometry: &mut Geometry) -> Result<(), Error> {
        if self.varying_lights.is_empty() {
            return Ok(());
        }
        let lights = &geometry.lights;
        let powers = upload_reals(self.device, "light powers", &lights.radiance(), self.precision())?;
        for (k, material) in self.varying_lights.iter().enumerate() {
            if let Some(kernel) = self.kernels.get(Stage::LightPower, Some(*material)) {
                let queue = self.plan.layout.light_queue(k as u32);
                self.launch(kernel, queue, Some(&powers), lights.len() as u64)?;
                self.note(Stage::LightPower, Some(*material));
            }
        }
        let radiance = read_reals(self.device, &powers, lights.len(), self.precision())?;
        geometry.lights.choose(&radiance, self.plan.choices.lights);
        self.buffers
            .insert(BufferId::Lights, upload_reals(self.device, "lights", &geometry.lights.reals, self.precision())?);
        self.buffers.insert(BufferId::LightWords, self.device.upload("light_words", &geometry.lights.words)?);
        Ok(())
    }

    /// Asks the environment's shader for its radiance in all directions, to sample the bright ones.
    fn map_environment(&mut self) -> Result<(), Error> {
        let Some(kernel) = self.kernels.get(Stage::EnvironmentMap, self.environment) else { return Ok(()) };
        let size = self.plan.environment_map();
        let cells = size.0 as usize * size.1 as usize;
        let map = self.device.buffer("environment map", 3 * cells as u64 * self.precision().real_bytes())?;
        self.launch(kernel, 0, Some(&map), cells as u64)?;
        self.note(Stage::EnvironmentMap, self.environment);
        let radiance = read_reals(self.device, &map, 3 * cells, self.precision())?;
        let table = AliasTable::new(&environment_weights(&radiance, size));
        let interleaved: Vec<f64> = table.probability.iter().zip(&table.share).flat_map(|(p, s)| [*p, *s]).collect();
        let cells = upload_reals(self.device, "environment_cells", &interleaved, self.precision())?;
        self.buffers.insert(BufferId::EnvironmentCells, cells);
        self.buffers.insert(BufferId::EnvironmentAlias, self.device.upload("environment_alias", &table.alias)?);
        Ok(())
    }

    /// Sets the seed of the random numbers, until then the scene's.
    pub fn set_seed(&mut self, seed: u64) {
        self.set(Setting::Seed, folded(seed));
    }

    /// Launches every stage with nothing to do: drivers that finish compiling a kernel at its first launch do so now, so that
    /// the first sample says how long the others take.
    pub fn warm_up(&mut self) -> Result<(), Error> {
        self.set(Setting::Slots, 0);
        self.write_settings()?;
        self.batch(&mut |_| {})?;
        self.device.finish()
    }

    /// From now on only these pixels get samples: for plans with the effect `adaptive`.
    pub fn go_on_with(&mut self, pixels: &[u32]) -> Result<(), Error> {
        if let Some(buffer) = self.buffers.get_mut(&BufferId::Pixels) {
            self.device.write(buffer, pixels)?;
            self.going_on = pixels.len() as u64;
        }
        Ok(())
    }

    /// Renders samples `first..end` of every pixel that goes on. `watch` hears now and then what is done so far.
    pub fn render(&mut self, first: u32, end: u32, watch: &mut dyn FnMut(&Counts)) -> Result<(), Error> {
        let per_batch = u64::from(self.spread.paths / self.spread.slots_per_pixel);
        let mut pixel = 0;
        while pixel < self.going_on {
            let count = per_batch.min(self.going_on - pixel);
            self.set(Setting::PixelFirst, pixel as u32);
            self.set(Setting::Slots, (count * u64::from(self.spread.slots_per_pixel)) as u32);
            self.set(Setting::SampleFirst, first);
            self.set(Setting::SampleEnd, end);
            self.write_settings()?;
            self.due += count * u64::from(end - first);
            self.batch(watch)?;
            pixel += count;
        }
        Ok(())
    }

    fn set(&mut self, setting: Setting, value: u32) {
        self.settings[place(setting)] = value;
    }

    fn write_settings(&mut self) -> Result<(), Error> {
        let settings = self.settings;
        match self.buffers.get_mut(&BufferId::Settings) {
            Some(buffer) => self.device.write(buffer, &settings),
            None => Ok(()),
        }
    }

    fn batch(&mut self, watch: &mut dyn FnMut(&Counts)) -> Result<(), Error> {
        let rounds = if self.device.info.kind == DeviceKind::Gpu { ROUNDS_GPU } else { ROUNDS_CPU };
        let samples = self.settings[place(Setting::SampleEnd)] - self.settings[place(Setting::SampleFirst)];
        let turns = if self.plan.is_asked(Effect::SplitLobes) { MOST_TURNS } else { 1 };
        let paths = u64::from(samples) * turns;
        let most = paths * u64::from(self.settings[place(Setting::MaxDepth)]) + u64::from(rounds);
        self.stage(Stage::RayGen, None, 0)?;
        for _ in 0..=most.div_ceil(u64::from(rounds)) {
            for _ in 0..rounds {
                self.round()?;
            }
            let words = self.counters()?;
            let counts = self.counts_of(&words);
            watch(&counts);
            if self.plan.layout.lasting_queues().all(|q| words[q as usize] == 0) {
                return if counts.samples == self.due {
                    Ok(())
                } else {
                    Err(self.device.lost("samples were lost on their way"))
                };
            }
        }
        // Each round takes every path one edge further: only a driver that loses work gets here.
        Err(self.device.lost("paths were left over when all should have ended"))
    }

    /// Every stage once. Then queues are empty but that of `trace`, and those of materials whose turn was over when another's path came.
    fn round(&mut self) -> Result<(), Error> {
        let plan = self.plan;
        self.stage(Stage::Trace, None, 0)?;
        self.empty(plan.layout.trace_queue())?;
        for (index, material) in plan.surface_materials.iter().enumerate() {
            self.stage(Stage::SelectBsdf, Some(*material), index as u32)?;
            self.stage(Stage::FollowPath, Some(*material), index as u32)?;
            if plan.follows() {
                self.empty(plan.layout.material_queues(index as u32..index as u32 + 1))?;
            }
        }
        if !plan.follows() {
            self.empty(plan.layout.material_queues(0..plan.surface_materials.len() as u32))?;
        }
        self.stage(Stage::Environment, self.environment, 0)?;
        self.stage(Stage::SampleLight, None, 0)?;
        self.stage(Stage::TraceShadow, None, 0)?;
        for (k, material) in self.varying_lights.iter().enumerate() {
            self.stage(Stage::ShadeLight, Some(*material), plan.layout.light_queue(k as u32))?;
        }
        self.stage(Stage::EnvironmentLight, self.environment, 0)?;
        self.stage(Stage::SampleNext, None, 0)?;
        self.stage(Stage::Accumulate, None, 0)?;
        self.empty(plan.layout.other_queues())
    }

    /// Empties queues between two launches: no launch may empty what it fills itself, since its groups run in any order.
    fn empty(&mut self, queues: Range<u32>) -> Result<(), Error> {
        match self.buffers.get_mut(&BufferId::Counters) {
            Some(counters) => self.device.clear_part(counters, 4 * u64::from(queues.start)..4 * u64::from(queues.end)),
            None => Ok(()),
        }
    }

    /// Launches a stage over all slots, if the plan has it.
    fn stage(&self, stage: Stage, material: Option<MaterialId>, launch: u32) -> Result<(), Error> {
        let Some(kernel) = self.kernels.get(stage, material) else { return Ok(()) };
        let start = Instant::now();
        // Stripes are of the same length.
        let items = u64::from(self.spread.paths).next_multiple_of((GROUP as u64) << self.spread.stripe_bits);
        self.launch(kernel, launch, None, items)?;
        self.note(stage, material);
        if let Some(times) = &self.times {
            self.device.finish()?;
            let mut times = times.borrow_mut();
            *times.entry(stage).or_default() += start.elapsed();
        }
        Ok(())
    }

    fn note(&self, stage: Stage, material: Option<MaterialId>) {
        *self.launches.borrow_mut().entry((stage, material)).or_default() += 1;
    }

    /// How often each stage was launched so far.
    pub fn launches(&self) -> BTreeMap<(Stage, Option<MaterialId>), u32> {
        self.launches.borrow().clone()
    }

    /// The buffers that all stages see, with their bytes.
    pub fn buffers(&self) -> Vec<(&'static str, u64)> {
        let bytes = |id| self.buffers.get(&id).map_or(0, Buffer::bytes);
        self.plan.layout.buffers().map(|(id, name)| (name, bytes(id))).collect()
    }

    fn counters(&self) -> Result<Vec<u32>, Error> {
        match self.buffers.get(&BufferId::Counters) {
            Some(buffer) => self.device.read(buffer, self.plan.layout.counter_words()),
            None => Ok(vec![0; self.plan.layout.counter_words()]),
        }
    }

    fn counts_of(&self, words: &[u32]) -> Counts {
        let word = |c: Counter| words[self.plan.layout.counter(c)];
        let wide = |c: Counter| {
            let at = self.plan.layout.counter(c);
            u64::from(words[at]) | u64::from(words[at + 1]) << 32
        };
        Counts {
            rays: wide(Counter::Rays),
            shadow_rays: wide(Counter::ShadowRays),
            // Turns behind a sample's first are paths of the same sample.
            samples: wide(Counter::Samples).saturating_sub(wide(Counter::Turns)),
            dropped: word(Counter::Dropped),
            repaired: word(Counter::Repaired),
            clamped: word(Counter::Clamped),
        }
    }

    /// What was counted so far.
    pub fn counts(&self) -> Result<Counts, Error> {
        Ok(self.counts_of(&self.counters()?))
    }

    /// The records of what shaders printed (kernels/osl/records.h; the points are numbers of materials), and how many words
    /// of them were lost. The last record may not have fit either.
    pub fn messages(&self) -> Result<(Vec<u32>, u64), Error> {
        let Some(buffer) = self.buffers.get(&BufferId::Messages) else { return Ok((Vec::new(), 0)) };
        let used = self.device.read::<u32>(buffer, 1)?[0];
        let words: Vec<u32> = self.device.read(buffer, used.min(MESSAGE_WORDS) as usize + 2)?;
        Ok((words[2..].to_vec(), u64::from(used.saturating_sub(MESSAGE_WORDS))))
    }

    /// Writes the stages' times to the log.
    pub fn log_times(&self) {
        for (stage, time) in self.times.iter().flat_map(|t| t.borrow().clone()) {
            let launches: u32 =
                self.launches.borrow().iter().filter(|((s, _), _)| *s == stage).map(|(_, count)| count).sum();
            tracing::debug!(stage = stage.name(), launches, ms = time.as_millis() as u64, "stage");
        }
    }

    /// The sums of each pixel's samples: rows from the top, channels interleaved.
    pub fn sums(&self) -> Result<Vec<f64>, Error> {
        self.resolve(1)
    }

    /// The picture, of which each pixel has had `samples` samples: rows from the top, channels interleaved.
    pub fn mean(&self, samples: u32) -> Result<Vec<f64>, Error> {
        self.resolve(samples)
    }

    /// The sums of each pixel's samples, divided by a number.
    fn resolve(&self, divisor: u32) -> Result<Vec<f64>, Error> {
        let numbers = self.pixels as usize * self.plan.layout.film_channels() as usize;
        let picture = self.device.buffer("picture", numbers as u64 * self.precision().real_bytes())?;
        if let Some(kernel) = self.kernels.get(Stage::Resolve, None) {
            self.launch(kernel, divisor, Some(&picture), self.pixels)?;
            self.note(Stage::Resolve, None);
        }
        read_reals(self.device, &picture, numbers, self.precision())
    }
}

/// Bytes of a buffer.
fn size(id: BufferId, plan: &Plan, pixels: u64, g: &Geometry, s: &Supplied<'_>, spread: Spread) -> u64 {
    let layout = &plan.layout;
    let paths = u64::from(spread.paths);
    let cells = u64::from(plan.environment_map().0) * u64::from(plan.environment_map().1);
    let reals = |count: u64| count * plan.choices.precision.real_bytes();
    let words = |count: usize| 4 * count as u64;
    match id {
        BufferId::Path => reals(paths * u64::from(layout.reals_per_path())),
        BufferId::PathUint => 4 * paths * u64::from(layout.uints_per_path()),
        BufferId::Queues => 4 * paths * u64::from(layout.queue_count()),
        BufferId::Counters => words(layout.counter_words()),
        BufferId::Settings => words(Setting::ALL.len()),
        BufferId::Constants => reals(Constant::total() as u64),
        // Sums and what their rounding lost.
        BufferId::Film => reals(FILM_REALS * pixels * u64::from(spread.slots_per_pixel)),
        BufferId::Pixels => 4 * pixels,
        BufferId::Nodes => words(g.nodes.len()),
        BufferId::Triangles => reals(g.triangles.len() as u64),
        BufferId::TriangleIds => words(g.triangle_ids.len()),
        BufferId::Corners => words(g.corners.len()),
        BufferId::Shapes => words(g.shapes.len()),
        BufferId::Normals => words(g.normals.len()),
        BufferId::Uvs => words(g.uvs.len()),
        BufferId::Areas => reals(g.areas.len() as u64),
        BufferId::ObjectSpaces => reals(g.object_spaces.len() as u64),
        BufferId::Instances => reals(g.instances.len() as u64),
        BufferId::InstanceRoots => words(g.instance_roots.len()),
        BufferId::Lights => reals(g.lights.reals.len() as u64),
        BufferId::LightWords => words(g.lights.words.len()),
        BufferId::EnvironmentCells => reals(2 * cells),
        BufferId::EnvironmentAlias => 4 * cells,
        BufferId::Messages => words(MESSAGE_WORDS as usize + 2),
        BufferId::Textures => words(s.textures.words.len()),
        BufferId::OtherSpaces => reals(OTHER_SPACES),
        BufferId::Userdata => words(s.userdata.values.len()),
        BufferId::UserdataPlaces => words(s.userdata.places.len()),
        BufferId::Interactive => reals(s.interactive.len() as u64),
        BufferId::TraceSets => words(s.traced.sets.len()),
        BufferId::TraceNames => words(s.traced.names.len()),
        BufferId::PointClouds => words(s.clouds.words.len()),
    }
}

fn upload_reals(device: &Device, name: &str, data: &[f64], precision: Precision) -> Result<Buffer, Error> {
    if precision.is_double() {
        device.upload(name, data)
    } else {
        let narrow: Vec<f32> = data.iter().map(|x| *x as f32).collect();
        device.upload(name, &narrow)
    }
}

fn read_reals(device: &Device, buffer: &Buffer, count: usize, precision: Precision) -> Result<Vec<f64>, Error> {
    if precision.is_double() {
        device.read(buffer, count)
    } else {
        Ok(device.read::<f32>(buffer, count)?.into_iter().map(f64::from).collect())
    }
}

/// Weights of the map's cells from their radiance. Each gets a part of its neighbours' as well: where the edge of something
/// bright runs through a cell that the map's few points call dark, paths would find it too rarely and too brightly.
fn environment_weights(radiance: &[f64], (width, height): (u32, u32)) -> Vec<f64> {
    let (width, height) = (width as usize, height as usize);
    let usable = |x: f64| if x.is_finite() && x > 0.0 { x } else { 0.0 };
    let own: Vec<f64> = radiance.chunks(3).map(|rgb| rgb.iter().map(|x| usable(*x)).sum()).collect();
    let around = |x: usize, y: usize| {
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        rows.map(|r| own[r * width + (x + width - 1) % width] + own[r * width + x] + own[r * width + (x + 1) % width])
            .sum::<f64>()
    };
    (0..own.len()).map(|i| own[i] + 0.1 * around(i % width, i / width)).collect()
}
