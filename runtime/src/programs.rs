//! Builds the programs of a plan for a device, several at a time, each at most once: what the device's cache has is loaded,
//! equal programs are one.
//!
//! In: the plan. Out: a kernel per stage and material. It must not know scenes or buffers.

use crate::assemble::{self, assemble_with};
use crate::builders::{self, Builder, Recipe, Request};
use crate::cache::{Key, Parts};
use crate::device::{self, Device, Kernel, Program};
use crate::plan::{Plan, ProgramPlan, Stage};
use crate::roads::{self, Modules};
use crate::scene::MaterialId;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};
use std::time::{Duration, Instant};

/// Why there is no program.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No program comes out.
    #[error(transparent)]
    Road(#[from] roads::Error),
    /// The device refuses.
    #[error(transparent)]
    Device(#[from] device::Error),
    /// A text includes what is not there.
    #[error(transparent)]
    Assemble(#[from] assemble::Error),
}

/// A program, and where it came from.
pub struct Built {
    /// The program.
    pub program: Program,
    /// The driver built it from its text now.
    pub is_new: bool,
    /// What the device's cache will know it by; `None` when it is there already, or there is no cache.
    unkept: Option<Key>,
}

impl Built {
    /// Puts it into the device's cache if it is not there. Some drivers finish a program at its first launch: keep it after.
    pub fn keep(&mut self, device: &Device) {
        let (Some(cache), Some(key)) = (device.cache(), self.unkept.take()) else { return };
        match self.program.binary(device) {
            Ok(binary) if !binary.is_empty() => cache.put(&key, &binary),
            Ok(_) => {}
            // A driver that gives no binaries has no use for a cache.
            Err(error) => tracing::debug!("no binary is kept: {error}"),
        }
    }
}

/// Builds a program from its text and the modules that it calls, or loads it from the device's cache.
pub fn load_or_build(
    device: &Device,
    label: &str,
    source: &str,
    options: &str,
    modules: &[&[u32]],
) -> Result<Built, roads::Error> {
    let options = &device.options(options);
    let Some(cache) = device.cache() else {
        let program = roads::build(device, label, source, options, modules)?;
        return Ok(Built { program, is_new: true, unkept: None });
    };
    let key = key(device, source, options, modules)?;
    if let Some(binary) = cache.get(&key) {
        match Program::load(device, label, &binary, options) {
            Ok(program) => return Ok(Built { program, is_new: false, unkept: None }),
            // The key has all that is known to matter; a driver may still know better.
            Err(error) => tracing::debug!("a kept binary is refused and built again: {error}"),
        }
    }
    let program = roads::build(device, label, source, options, modules)?;
    Ok(Built { program, is_new: true, unkept: Some(key) })
}

/// As [`load_or_build`], for programs that are kept at once.
pub fn build_one(
    device: &Device,
    label: &str,
    source: &str,
    options: &str,
    modules: &[&[u32]],
) -> Result<Program, roads::Error> {
    let mut built = load_or_build(device, label, source, options, modules)?;
    built.keep(device);
    Ok(built.program)
}

/// Whether the device's cache has a program already.
fn is_kept(device: &Device, source: &str, options: &str, modules: &[&[u32]]) -> bool {
    let options = &device.options(options);
    device.cache().is_some_and(|cache| key(device, source, options, modules).is_ok_and(|key| cache.has(&key)))
}

fn key(device: &Device, source: &str, options: &str, modules: &[&[u32]]) -> Result<Key, roads::Error> {
    let road = roads::describe(device, modules)?;
    let (road, identity) = (road.as_str(), device.identity());
    let version = env!("CARGO_PKG_VERSION");
    Ok(Key::new(&Parts { source, options, road, modules, device: &identity, version }))
}

/// How programs came about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Built by the driver from their texts.
    pub built: u32,
    /// Loaded from the cache.
    pub loaded: u32,
    /// Equal to another one of the same plan.
    pub shared: u32,
}

/// Built kernels, by stage and, for generated ones, material.
pub struct Kernels {
    all: HashMap<(Stage, Option<MaterialId>), Kernel>,
    /// Those that the cache has not got yet.
    new: Mutex<Vec<Built>>,
    tally: Tally,
}

impl Kernels {
    /// The kernel of a stage; `None` when the plan does without it.
    pub fn get(&self, stage: Stage, material: Option<MaterialId>) -> Option<&Kernel> {
        self.all.get(&(stage, material))
    }

    /// How their programs came about.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// Puts new programs into the device's cache, once every kernel was launched.
    pub fn keep(&self, device: &Device) {
        let new = std::mem::take(&mut *self.new.lock().unwrap_or_else(PoisonError::into_inner));
        if !new.is_empty() {
            let _span = tracing::debug_span!("keep programs").entered();
            new.into_iter().for_each(|mut built| built.keep(device));
        }
    }
}

/// The whole text of a program.
pub fn source(plan: &Plan, program: &ProgramPlan) -> Result<String, assemble::Error> {
    let mut text = String::new();
    for macro_text in &program.macros {
        text.push_str(&format!("#define {macro_text}\n"));
    }
    text.push_str(&program.code);
    for stage in &program.stages {
        text.push_str(&format!("#include \"stages/{}.cl\"\n", stage.name()));
    }
    // Materials that are equal have equal texts, whatever their names.
    let name = if program.material.is_some() { "material" } else { &program.label };
    assemble_with(name, &text, &[("layout.h", &plan.layout.header())])
}

/// How far [`build`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Programs that are there.
    pub done: u32,
    /// Programs in all, equal ones counted once.
    pub total: u32,
}

/// A program to build, and the places in the plan that want it.
struct Job<'a> {
    first: &'a ProgramPlan,
    text: String,
    modules: Vec<&'a [u32]>,
    wanted: Vec<&'a ProgramPlan>,
}

/// Builds all programs, those of materials with their modules, on as many threads as the host has cores.
pub fn build<'a>(
    device: &Device,
    plan: &'a Plan,
    modules: &Modules<'a>,
    watch: &mut dyn FnMut(Step),
) -> Result<Kernels, Error> {
    let _span = tracing::info_span!("programs").entered();
    let jobs = jobs(plan, modules)?;
    let next = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(jobs.len().max(1));
    let options = plan.choices.precision.build_options();
    let missing = || jobs.iter().filter(|job| !is_kept(device, &job.text, options, &job.modules)).count();
    let recipe = device.builders().filter(|_| missing() >= builders::WORTH_IT);
    let threads = if recipe.is_some() { threads.min(builders::MOST) } else { threads };
    let total = jobs.len() as u32;
    let mut all = HashMap::new();
    let mut new = Vec::new();
    let mut tally = Tally { shared: plan.programs.len() as u32 - total, ..Tally::default() };
    let mut failure = None;
    watch(Step { done: 0, total });
    std::thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        for _ in 0..threads {
            let (send, jobs, next) = (send.clone(), &jobs, &next);
            scope.spawn(move || {
                let mut elsewhere = Elsewhere { recipe, builder: None };
                while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let is_new = elsewhere.build(device, job, options);
                    let result = run(device, job, options, is_new);
                    if result.is_err() {
                        next.store(jobs.len(), Ordering::Relaxed);
                    }
                    // The other end waits until all are done.
                    let _ = send.send(result);
                }
            });
        }
        drop(send);
        for (done, result) in (1..).zip(receive) {
            match result {
                Ok((built, named)) => {
                    all.extend(named);
                    if built.is_new {
                        tally.built += 1;
                        new.push(built);
                    } else {
                        tally.loaded += 1;
                    }
                }
                Err(e) => _ = failure.get_or_insert(e),
            }
            watch(Step { done, total });
        }
    });
    match failure {
        Some(e) => Err(e),
        None => Ok(Kernels { all, new: Mutex::new(new), tally }),
    }
}

/// What is to be built. What takes longest comes first: nothing else may be left to do beside the last.
fn jobs<'a>(plan: &'a Plan, modules: &Modules<'a>) -> Result<Vec<Job<'a>>, Error> {
    let mut jobs: Vec<Job> = Vec::new();
    let mut known = HashMap::new();
    for program in &plan.programs {
        let text = source(plan, program)?;
        let modules: Vec<&[u32]> = program.material.and_then(|id| modules.get(&id).copied()).into_iter().collect();
        match known.get(&(text.clone(), modules.clone())) {
            Some(&index) => {
                let job: &mut Job = &mut jobs[index];
                job.wanted.push(program);
            }
            None => {
                known.insert((text.clone(), modules.clone()), jobs.len());
                jobs.push(Job { first: program, text, modules, wanted: vec![program] });
            }
        }
    }
    jobs.sort_by_key(|job| std::cmp::Reverse(effort(job.first)));
    Ok(jobs)
}

/// How much a driver has to compile: a material's code, or each lobe, some 2,000 characters, of the stages that sample and evaluate
/// them. Of the headers a program mostly uses little, so that the length of its whole text says nothing.
fn effort(program: &ProgramPlan) -> usize {
    let has_lobes = program.stages.iter().any(|s| matches!(s, Stage::SampleNext | Stage::SampleLight));
    let lobes = program.macros.iter().filter(|m| m.starts_with("HAS_LOBE_")).count();
    program.code.len() + if has_lobes { 2000 * lobes } else { 0 }
}

type Named = Vec<((Stage, Option<MaterialId>), Kernel)>;

/// A process that builds what the cache has not got, for as long as it does.
struct Elsewhere<'a> {
    recipe: Option<&'a Recipe>,
    builder: Option<Builder>,
}

impl Elsewhere<'_> {
    /// Gets a program into the cache if it is not there and there may be processes; says whether. Whatever fails, [`run`] does it.
    fn build(&mut self, device: &Device, job: &Job, options: &str) -> bool {
        let Some(recipe) = self.recipe else { return false };
        if is_kept(device, &job.text, options, &job.modules) {
            return false;
        }
        let builder = match &mut self.builder {
            Some(builder) => Ok(builder),
            none => Builder::start(recipe).map(|new| none.insert(new)),
        };
        let modules = job.modules.iter().map(|m| m.to_vec()).collect();
        let label = &job.first.label;
        let request = Request { label: label.into(), source: (&job.text).into(), options: options.into(), modules };
        let done = builder.and_then(|b| b.build(&request));
        if let Err(error) = &done {
            tracing::debug!("no process builds {label}: {error}");
            *self = Elsewhere { recipe: None, builder: None };
        }
        done.is_ok()
    }
}

/// Builds or loads a program. `is_new`: a process has just built it.
fn run(device: &Device, job: &Job, options: &str, is_new: bool) -> Result<(Built, Named), Error> {
    let start = Instant::now();
    let label = &job.first.label;
    let mut built = load_or_build(device, label, &job.text, options, &job.modules)?;
    built.is_new |= is_new;
    let mut out = Vec::new();
    for program in &job.wanted {
        for &stage in &program.stages {
            out.push(((stage, program.material), built.program.kernel(device, stage.name())?));
        }
    }
    log(label, &built, start.elapsed());
    Ok((built, out))
}

fn log(label: &str, built: &Built, time: Duration) {
    let how = if built.is_new { "built" } else { "loaded" };
    tracing::debug!("{how} {label} in {:.1} ms", 1e3 * time.as_secs_f64());
}
