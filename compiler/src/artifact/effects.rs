//! What a shader can do to the renderer and asks of it, read off its IR.

use crate::backend::lobes::{has_film, slot_has_film};
use crate::builtins::{self, ClosureRole};
use crate::ir::{Arg, Const, Inst, LocalId, LocalKind, Shader, Stmt, ValueId};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashMap};

/// Radiance that a shader gives, W / (m^2 sr) per channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Radiance {
    /// None at all.
    None,
    /// Always this.
    Constant([f64; 3]),
    /// Depends on the point.
    Varying,
}

impl Radiance {
    fn add(self, other: Radiance) -> Radiance {
        use Radiance::*;
        match (self, other) {
            (None, r) | (r, None) => r,
            (Constant(a), Constant(b)) => Constant([a[0] + b[0], a[1] + b[1], a[2] + b[2]]),
            _ => Varying,
        }
    }
}

/// Fields of `ShaderGlobals` (kernels/globals.h) beyond OSL's globals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct State {
    /// `object_space`.
    pub object_space: bool,
    /// `camera_space`.
    pub camera_space: bool,
    /// `surfacearea`.
    pub surface_area: bool,
    /// `backfacing`.
    pub backfacing: bool,
    /// `flip_handedness`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub flip_handedness: bool,
    /// `raytype`.
    pub raytype: bool,
    /// The derivatives (`HAS_DERIVATIVES`).
    pub derivatives: bool,
    /// `other_spaces`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub other_spaces: bool,
}

/// The findings.
#[derive(Debug)]
pub(super) struct Effects {
    pub lobes: Vec<String>,
    pub volumes: Vec<String>,
    pub globals: Vec<&'static str>,
    pub state: State,
    pub noise: Vec<String>,
    pub emission: Radiance,
    pub background: Radiance,
    pub transparent: bool,
    pub holdout: bool,
}

/// Reads a shader after `passes`.
pub(super) fn of(shader: &Shader) -> Effects {
    let mut lobes = BTreeSet::new();
    let mut volumes = BTreeSet::new();
    let mut effects = Effects {
        lobes: Vec::new(),
        volumes: Vec::new(),
        globals: Vec::new(),
        state: State::default(),
        noise: Vec::new(),
        emission: Radiance::None,
        background: Radiance::None,
        transparent: false,
        holdout: false,
    };
    let known = constants_at_end(shader);
    let radiance = |l: LocalId| match known.get(&l) {
        Some(Some(c)) if *c == [0.0; 3] => Radiance::None,
        Some(Some(c)) => Radiance::Constant(*c),
        Some(None) => Radiance::Varying,
        // Never stored: zero.
        None => Radiance::None,
    };
    for slot in &shader.slots {
        let row = builtins::closure(slot.closure);
        effects.state.backfacing |= row.state.contains(&"backfacing");
        match row.role {
            ClosureRole::Lobe(name) => {
                lobes.insert(name.to_owned());
                if slot_has_film(slot) {
                    lobes.insert("thin_film".to_owned());
                }
            }
            ClosureRole::Transparent => {
                lobes.insert("transparent".to_owned());
                effects.transparent = true;
            }
            ClosureRole::Emission => effects.emission = effects.emission.add(radiance(slot.weight)),
            ClosureRole::Background => effects.background = effects.background.add(radiance(slot.weight)),
            ClosureRole::Holdout => effects.holdout = true,
            ClosureRole::Volume => {
                volumes.insert(row.name.to_owned());
            }
            ClosureRole::Debug | ClosureRole::Layer => {}
        }
    }
    albedos(shader, &mut |id, args| {
        let row = builtins::closure(id);
        effects.state.backfacing |= row.state.contains(&"backfacing");
        if let ClosureRole::Lobe(name) = row.role {
            lobes.insert(name.to_owned());
        }
        let is_zero =
            |at: usize| matches!(&shader.values[args[at].0 as usize].inst, Inst::Const(Const::Float(x)) if *x == 0.0);
        if has_film(id, is_zero) {
            lobes.insert("thin_film".to_owned());
        }
    });
    effects.lobes = lobes.into_iter().collect();
    effects.volumes = volumes.into_iter().collect();
    let read = globals(shader);
    effects.state.derivatives = read.iter().any(|g| g.is_derivative());
    // A global is asked for by its derivative alone, too.
    let bases: BTreeSet<crate::ir::Global> = read.iter().map(|g| g.base()).collect();
    effects.globals = bases.into_iter().map(|g| g.name()).collect();
    calls(shader, &mut effects);
    // The generated code itself asks which side emits, and from where the lobes are seen.
    effects.state.backfacing |= effects.emission != Radiance::None;
    effects
}

/// The globals that are read, in declaration order.
fn globals(shader: &Shader) -> Vec<crate::ir::Global> {
    let mut read = BTreeSet::new();
    for block in shader.blocks() {
        block.walk(&mut |s| {
            if let Stmt::Let(v) = s {
                shader.values[v.0 as usize].inst.locals(&mut |l| {
                    read.insert(l);
                });
            }
        });
    }
    for slot in &shader.slots {
        read.insert(slot.weight);
        read.extend(slot.args.iter().filter_map(|a| match a {
            crate::ir::SlotArg::Local(l) => Some(*l),
            crate::ir::SlotArg::Const(_) => None,
        }));
    }
    let mut found: Vec<crate::ir::Global> = read
        .into_iter()
        .filter_map(|l| match shader.locals[l.0 as usize].kind {
            LocalKind::Global(g) => Some(g),
            _ => None,
        })
        .collect();
    found.sort();
    found.dedup();
    found
}

/// Calls `f` on every lobe whose albedo is asked for.
fn albedos(shader: &Shader, f: &mut dyn FnMut(builtins::ClosureId, &[ValueId])) {
    for block in shader.blocks() {
        block.walk(&mut |s| {
            if let Stmt::Let(v) = s
                && let Inst::Albedo(id, args) = &shader.values[v.0 as usize].inst
            {
                f(*id, args);
            }
        });
    }
}

/// State and noise that calls ask for.
fn calls(shader: &Shader, effects: &mut Effects) {
    let mut noise = BTreeSet::new();
    let mut call = |func: builtins::FuncId, args: &[Arg]| {
        let name = builtins::row(func).name;
        match name {
            "space_matrix" | "space_matrix_inverse" => {
                if let Some(Arg::Value(v)) = args.first() {
                    match &shader.values[v.0 as usize].inst {
                        Inst::Const(Const::Int(0)) => {}
                        Inst::Const(Const::Int(3)) => effects.state.camera_space = true,
                        Inst::Const(Const::Int(4..)) => effects.state.other_spaces = true,
                        Inst::Const(_) => effects.state.object_space = true,
                        _ => {
                            effects.state.other_spaces = true;
                            effects.state.camera_space = true;
                            effects.state.object_space = true;
                        }
                    }
                }
            }
            "surfacearea" => effects.state.surface_area = true,
            "backfacing" => effects.state.backfacing = true,
            "flip_handedness" => effects.state.flip_handedness = true,
            "raytype_bit" => effects.state.raytype = true,
            _ => {}
        }
        if let Some(kind) = name.strip_prefix("noise_").or_else(|| name.strip_prefix("pnoise_")) {
            let kind = kind.split("_slopes").next().unwrap_or(kind);
            noise.insert(kind.to_owned());
        }
    };
    for block in shader.blocks() {
        block.walk(&mut |s| match s {
            Stmt::Let(v) => {
                if let Inst::Call(func, args) = &shader.values[v.0 as usize].inst {
                    call(*func, args);
                }
            }
            Stmt::Call { func, args, .. } => call(*func, args),
            _ => {}
        });
    }
    effects.noise = noise.into_iter().collect();
}

/// For every single triple local that is written: the constant that it always ends with, if there is one.
///
/// Only what happens on the way straight through the shader counts; a store under a condition makes it unknown.
fn constants_at_end(shader: &Shader) -> HashMap<LocalId, Option<[f64; 3]>> {
    let mut known = HashMap::new();
    let constant = |v: ValueId| match &shader.values[v.0 as usize].inst {
        Inst::Const(Const::Triple(t)) => Some(*t),
        _ => None,
    };
    for block in shader.blocks() {
        for stmt in &block.stmts {
            stmt.blocks(&mut |inner| {
                inner.walk(&mut |s| s.written(&mut |l| _ = known.insert(l, None)));
            });
            match stmt {
                Stmt::Store(l, v) => _ = known.insert(*l, constant(*v)),
                other => other.written(&mut |l| _ = known.insert(l, None)),
            }
        }
    }
    known
}
