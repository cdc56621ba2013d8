//! Builds the programs of a plan for a device, several at a time.
//!
//! In: the plan. Out: a kernel per stage and material. It must not know scenes or buffers.

use crate::assemble::{self, assemble_with};
use crate::device::{self, Device, Kernel};
use crate::plan::{Plan, ProgramPlan, Stage};
use crate::roads::{self, Modules};
use crate::scene::MaterialId;
use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

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

/// Built kernels, by stage and, for generated ones, material.
pub struct Kernels {
    all: HashMap<(Stage, Option<MaterialId>), Kernel>,
}

impl Kernels {
    /// The kernel of a stage; `None` when the plan does without it.
    pub fn get(&self, stage: Stage, material: Option<MaterialId>) -> Option<&Kernel> {
        self.all.get(&(stage, material))
    }
}

/// The whole text of a program.
pub fn source(plan: &Plan, program: &ProgramPlan, paths: u32) -> Result<String, assemble::Error> {
    let mut text = String::new();
    for macro_text in &program.macros {
        text.push_str(&format!("#define {macro_text}\n"));
    }
    text.push_str(&program.code);
    for stage in &program.stages {
        text.push_str(&format!("#include \"stages/{}.cl\"\n", stage.name()));
    }
    // It stands in `#line` directives, and a material's name may have any character.
    let name: String = program.label.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    assemble_with(&name, &text, &[("layout.h", &plan.layout.header(paths))])
}

/// Builds all programs, those of materials with their modules, on as many threads as the host has cores.
pub fn build(device: &Device, plan: &Plan, paths: u32, modules: &Modules) -> Result<Kernels, Error> {
    let _span = tracing::info_span!("programs").entered();
    let next = AtomicUsize::new(0);
    let all = Mutex::new(HashMap::new());
    let failure = Mutex::new(None);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(plan.programs.len().max(1));
    let work = || {
        while let Some(program) = plan.programs.get(next.fetch_add(1, Ordering::Relaxed)) {
            match build_one(device, plan, program, paths, modules) {
                Ok(kernels) => all.lock().unwrap_or_else(|e| e.into_inner()).extend(kernels),
                Err(e) => {
                    failure.lock().unwrap_or_else(|e| e.into_inner()).get_or_insert(e);
                    next.store(plan.programs.len(), Ordering::Relaxed);
                }
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    match failure.into_inner().unwrap_or_else(|e| e.into_inner()) {
        Some(e) => Err(e),
        None => Ok(Kernels { all: all.into_inner().unwrap_or_else(|e| e.into_inner()) }),
    }
}

type Named = ((Stage, Option<MaterialId>), Kernel);

fn build_one(
    device: &Device,
    plan: &Plan,
    program: &ProgramPlan,
    paths: u32,
    modules: &Modules,
) -> Result<Vec<Named>, Error> {
    let _span = tracing::debug_span!("build", program = program.label).entered();
    let text = source(plan, program, paths)?;
    let module = program.material.and_then(|id| modules.get(&id).copied());
    let options = plan.choices.precision.build_options();
    let built = roads::build(device, &program.label, &text, options, module.as_slice())?;
    let mut out = Vec::new();
    for &stage in &program.stages {
        out.push(((stage, program.material), built.kernel(device, stage.name())?));
    }
    Ok(out)
}
