//! What each effect of a plan costs: kernels, macros, buffers and bytes from the plan, time by rendering without it.
//!
//! In: a scene and its plan; for times a device. Out: [`Added`], [`Timing`]. It must not know how anything is printed.

mod timing;

pub use timing::{Change, Cost, Settings, Timing, measure};

use crate::choices::{Choices, Follow};
use crate::materials::Compiled;
use crate::plan::{Effect, Overrides, Plan, ProgramPlan, Stage};
use crate::programs;
use crate::scene::{MaterialId, Scene};
use crate::{assemble, plan};
use std::collections::BTreeSet;

/// What an effect that is on adds to a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Added {
    /// Which.
    pub effect: Effect,
    /// Macros that no program has without it.
    pub macros: Vec<String>,
    /// The kernels whose code asks for one of these macros, or that are there for it alone.
    pub kernels: Vec<Kernel>,
    /// Buffers that are there for it alone.
    pub buffers: Vec<&'static str>,
    /// Bytes of each path in flight that are there for it alone: its state, and its places in queues.
    pub bytes_per_path: u64,
}

/// A kernel of a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kernel {
    /// Its program.
    pub program: String,
    /// Whose code the program holds; `None`: the renderer's own.
    pub material: Option<MaterialId>,
    /// What it does.
    pub stage: Stage,
    /// Whether it is there for the effect alone.
    pub alone: bool,
}

/// A program as far as effects are concerned.
struct Program<'a> {
    plan: &'a ProgramPlan,
    /// The words in its code that may be macros of the plan.
    words: BTreeSet<String>,
}

/// What each effect that is on adds, in the order of the plan. `scene`: as it is written; `compiled`: what the plan was made of.
pub fn added(scene: &Scene, plan: &Plan, compiled: &Compiled) -> Result<Vec<Added>, assemble::Error> {
    let mut programs = Vec::with_capacity(plan.programs.len());
    for program in &plan.programs {
        programs.push(Program { plan: program, words: words(&programs::source(plan, program)?) });
    }
    let bytes = plan.choices.precision.real_bytes();
    let on: Vec<Effect> = plan.decisions.iter().filter(|d| d.is_on()).map(|d| d.effect).collect();
    let goes: Vec<Gone> = on.iter().map(|effect| Gone::of(scene, plan, compiled, *effect)).collect();
    let added = |(effect, gone): (&Effect, &Gone)| {
        // What goes with an effect that needs this one is that one's.
        let needing = Overrides::new([], [*effect]);
        let others: Vec<&Gone> =
            on.iter().zip(&goes).filter(|(e, _)| *e != effect && needing.removes(**e)).map(|(_, g)| g).collect();
        let macros: Vec<String> =
            gone.macros.iter().filter(|m| !others.iter().any(|o| o.macros.contains(*m))).cloned().collect();
        let mut kernels = Vec::new();
        for program in &programs {
            let ProgramPlan { label, material, stages, .. } = program.plan;
            let uses = macros.iter().any(|m| program.words.contains(m) && has(program.plan, m));
            for stage in stages {
                let key = (*material, *stage);
                let alone = gone.kernels.contains(&key) && !others.iter().any(|o| o.kernels.contains(&key));
                if uses || alone {
                    kernels.push(Kernel { program: label.clone(), material: *material, stage: *stage, alone });
                }
            }
        }
        Added {
            effect: *effect,
            macros,
            kernels,
            buffers: plan.layout.buffers_of(*effect),
            bytes_per_path: plan.layout.bytes_of(*effect, bytes),
        }
    };
    Ok(on.iter().zip(&goes).map(added).collect())
}

/// What a plan would not have without an effect and all that needs it.
struct Gone {
    macros: BTreeSet<String>,
    kernels: BTreeSet<(Option<MaterialId>, Stage)>,
}

impl Gone {
    fn of(scene: &Scene, plan: &Plan, compiled: &Compiled, effect: Effect) -> Gone {
        let without = without(scene, plan, compiled, effect);
        let kernels = |plan: &Plan| -> BTreeSet<(Option<MaterialId>, Stage)> {
            plan.programs.iter().flat_map(|p| p.stages.iter().map(|s| (p.material, *s))).collect()
        };
        Gone { macros: macros(plan, &without, effect), kernels: &kernels(plan) - &kernels(&without) }
    }
}

/// The plan of the same materials without an effect, and without what needs it.
fn without(scene: &Scene, plan: &Plan, compiled: &Compiled, effect: Effect) -> Plan {
    // The same kernels in both, but for what the effect has.
    let follow = if plan.follows() { Follow::On } else { Follow::Off };
    let choices = Choices { overrides: plan.choices.overrides.and_without(effect), follow, ..plan.choices };
    let left = choices.overrides.apply(scene);
    // A material that was there for an effect that was forced on is no more.
    let materials = &compiled.artifacts[..compiled.artifacts.len().min(left.materials.len())];
    plan::Plan::new(scene, &left, materials, &choices)
}

fn has(program: &ProgramPlan, name: &str) -> bool {
    program.macros.iter().any(|m| name_of(m) == name)
}

/// A macro's name without its value.
fn name_of(text: &str) -> &str {
    text.split(' ').next().unwrap_or(text)
}

/// The macros that go with an effect: its own, and those that the plan without it lacks, but for other effects' own.
fn macros(plan: &Plan, without: &Plan, effect: Effect) -> BTreeSet<String> {
    let names = |plan: &Plan| -> BTreeSet<String> {
        plan.programs.iter().flat_map(|p| &p.macros).map(|m| name_of(m).to_owned()).collect()
    };
    let (all, left) = (names(plan), names(without));
    let others: BTreeSet<String> = Effect::ALL.iter().filter(|e| **e != effect).map(|e| e.macro_name()).collect();
    // These tell a material's own code, whatever is in it.
    let is_name = |m: &str| matches!(m, "MATERIAL_ENTRY" | "MATERIAL_EMITS");
    let own = effect.macro_name();
    all.into_iter().filter(|m| *m == own || !left.contains(m) && !others.contains(m) && !is_name(m)).collect()
}

/// The words in capitals of a text, but where they are defined.
fn words(text: &str) -> BTreeSet<String> {
    let lines = text.lines().filter(|l| !l.trim_start().starts_with("#define"));
    let is_part = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    lines.flat_map(|l| l.split(|c| !is_part(c))).filter(|w| w.len() > 3).map(str::to_owned).collect()
}
