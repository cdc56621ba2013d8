//! Where a shader uses what a renderer has to provide, and which parameters decide that it does.
//!
//! In: IR after the passes. Out: what is used, with the places of the calls. It must not know why.

use crate::backend::lobes::{has_film, slot_has_film};
use crate::builtins::{self, ClosureRole};
use crate::ir::{Arg, Const, Inst, LocalId, LocalKind, Shader, Source, Stmt};
use crate::passes;
use crate::source::Span;
use serde::{Deserialize, Serialize};

/// A place in a shader where it uses something of the renderer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Use {
    /// What: `lobe_NAME`, `emission`, `background`, `holdout`, `volume NAME`, a field of [`super::State`], `messages`, `texture FILE`
    /// (`texture` alone where the file is chosen at run time), `global NAME`, `userdata NAME`, `interactive NAME`.
    pub what: String,
    /// The shader's file, or the file that its text stands in.
    pub file: String,
    /// The line, from 1.
    pub line: u32,
    /// The parameters that decide about it; only where [`crate::Options::explain`] asks for them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub controls: Vec<Control>,
}

/// A parameter that decides whether something is used, or how much.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// Its flattened name, in a group with its layer in front (`layer.param`).
    pub param: String,
    /// Its value as OSL writes it; `None`: it is an array, or not known before the shader runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<String>,
    /// The file of its declaration.
    pub file: String,
    /// The line of its declaration, from 1.
    pub line: u32,
    /// A value with which the use would not be there at all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub off_at: Option<String>,
}

/// What is used where.
pub(crate) type Found = (String, Span);

/// Everything that a shader uses, in the order of the code, each place once.
pub(crate) fn of(shader: &Shader) -> Vec<Found> {
    let mut out: Vec<Found> = Vec::new();
    for slot in &shader.slots {
        let row = builtins::closure(slot.closure);
        out.push((closure(row), slot.span));
        if slot_has_film(slot) {
            out.push(("lobe_thin_film".to_owned(), slot.span));
        }
    }
    for block in shader.blocks() {
        block.walk(&mut |s| match s {
            Stmt::Let(v) => {
                let value = &shader.values[v.0 as usize];
                inst(shader, &value.inst, value.span, &mut out);
            }
            Stmt::Call { func, args, span, .. } => {
                call(shader, *func, args, *span, &mut out);
                if builtins::has_effect(*func) {
                    out.push(("messages".to_owned(), *span));
                }
            }
            _ => {}
        });
    }
    // Derivatives that are zero whatever happens are none that a renderer provides.
    let reads = |g: &LocalKind| matches!(g, LocalKind::Global(g) if g.is_derivative());
    if shader.locals.iter().any(|l| reads(&l.kind)) {
        out.extend(shader.derivative_uses.iter().map(|span| ("derivatives".to_owned(), *span)));
    }
    let mut seen = std::collections::HashSet::new();
    out.retain(|found| seen.insert(found.clone()));
    out
}

fn closure(row: &builtins::ClosureRow) -> String {
    match row.role {
        ClosureRole::Lobe(name) => format!("lobe_{name}"),
        ClosureRole::Transparent => "lobe_transparent".to_owned(),
        ClosureRole::Emission => "emission".to_owned(),
        ClosureRole::Background => "background".to_owned(),
        ClosureRole::Holdout => "holdout".to_owned(),
        ClosureRole::Volume => format!("volume {}", row.name),
        ClosureRole::Debug | ClosureRole::Layer => row.name.to_owned(),
    }
}

fn inst(shader: &Shader, inst: &Inst, span: Span, out: &mut Vec<Found>) {
    inst.locals(&mut |l| local(shader, l, span, out));
    match inst {
        Inst::Call(func, args) => call(shader, *func, args, span, out),
        // A covering lobe's albedo: the lobe's code is there for it alone, too.
        Inst::Albedo(id, args) => {
            out.push((closure(builtins::closure(*id)), span));
            let is_zero = |at: usize| matches!(&shader.values[args[at].0 as usize].inst, Inst::Const(Const::Float(x)) if *x == 0.0);
            if has_film(*id, is_zero) {
                out.push(("lobe_thin_film".to_owned(), span));
            }
        }
        _ => {}
    }
}

fn local(shader: &Shader, l: LocalId, span: Span, out: &mut Vec<Found>) {
    match shader.locals[l.0 as usize].kind {
        LocalKind::Global(global) => out.push((format!("global {}", global.base().name()), span)),
        LocalKind::Input(index) => {
            let input = &shader.inputs[index as usize];
            let kind = match input.source {
                Source::Userdata | Source::HasUserdata => "userdata",
                Source::Interactive | Source::HasInteractive => "interactive",
            };
            out.push((format!("{kind} {}", input.name), span));
        }
        _ => {}
    }
}

fn call(shader: &Shader, func: builtins::FuncId, args: &[Arg], span: Span, out: &mut Vec<Found>) {
    let constant = |at: usize| match args.get(at) {
        Some(Arg::Value(v)) => match &shader.values[v.0 as usize].inst {
            Inst::Const(c) => Some(c),
            _ => None,
        },
        _ => None,
    };
    let mut found = |what: &str| out.push((what.to_owned(), span));
    match builtins::row(func).name {
        "space_matrix" | "space_matrix_inverse" => match constant(0) {
            Some(Const::Int(0)) => {}
            Some(Const::Int(3)) => found("camera_space"),
            Some(Const::Int(4..)) => found("other_spaces"),
            Some(_) => found("object_space"),
            None => ["object_space", "camera_space", "other_spaces"].into_iter().for_each(found),
        },
        "surfacearea" => found("surface_area"),
        "raytype_bit" => found("raytype"),
        _ if passes::is_lookup(func) => match constant(0) {
            Some(Const::Str(file)) => found(&format!("texture {file}")),
            _ => found("texture"),
        },
        _ => {}
    }
}
