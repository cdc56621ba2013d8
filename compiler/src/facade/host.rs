//! Runs shaders and groups on the host, in f64: what they compute and what they say.
//!
//! In: optimised IR, outputs, points. Out: [`HostRun`]. It is the way for shaders that need strings which a device cannot
//! build, and the oracle for those that don't.

use crate::backend;
use crate::diag::Diagnostic;
use crate::interp::{self, Globals, Outcome};
use crate::ir::{Const, Global, LocalId, LocalKind, Shader};
use crate::messages::Message;

pub use crate::backend::Output;

/// What a run over many points leaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HostRun {
    /// The outputs asked for.
    pub outputs: Vec<Output>,
    /// The reals of each output: a point's stand together.
    pub data: Vec<Vec<f64>>,
    /// What was said, by points and in the order of the program.
    pub messages: Vec<Message>,
}

/// Runs an optimised shader on points `0..count`.
pub(super) fn run(
    shader: &Shader,
    names: &[String],
    count: u32,
    point: &dyn Fn(u32) -> Globals,
) -> Result<HostRun, Vec<Diagnostic>> {
    let outputs = backend::outputs(shader, names)?;
    let mut run = HostRun { data: vec![Vec::new(); outputs.len()], outputs, messages: Vec::new() };
    for number in 0..count {
        let globals = Globals { shading_index: number as i32, ..point(number) };
        let outcome = interp::run(shader, &globals).map_err(|e| vec![Diagnostic::global("E4297", e.to_string())])?;
        for (name, data) in names.iter().zip(&mut run.data) {
            reals(shader, (&globals, &outcome), name, data).map_err(|d| vec![d])?;
        }
        let said = outcome.messages.into_iter();
        run.messages.extend(said.map(|(kind, text)| Message { kind, point: number, text }));
    }
    Ok(run)
}

/// Appends the reals of an output: a parameter, `Ci`, or what a displacement shader moves.
pub(super) fn reals(
    shader: &Shader,
    (globals, outcome): (&Globals, &Outcome),
    name: &str,
    out: &mut Vec<f64>,
) -> Result<(), Diagnostic> {
    if name == "Ci" {
        out.extend(outcome.ci());
        return Ok(());
    }
    let moved = [(Global::P, globals.p), (Global::N, globals.n)].into_iter().find(|(g, _)| g.name() == name);
    let local = match moved {
        Some((global, _)) => {
            let at = shader.locals.iter().position(|l| l.kind == LocalKind::Global(global));
            at.map(|i| LocalId(i as u32))
        }
        None => shader.params.iter().find(|p| p.output && p.name == name).map(|p| p.local),
    };
    match (local.and_then(|l| outcome.local(l)), moved) {
        (Some(value), _) if flatten(value, out) => return Ok(()),
        (None, Some((_, value))) => {
            out.extend(value);
            return Ok(());
        }
        _ => {}
    }
    let message = format!("shader `{}` has no output parameter `{name}` of numbers", shader.name);
    Err(Diagnostic::global("E4203", message))
}

/// The reals that a constant is made of; false when it holds strings.
fn flatten(c: &Const, out: &mut Vec<f64>) -> bool {
    match c {
        Const::Int(v) => out.push(f64::from(*v)),
        Const::Float(v) => out.push(*v),
        Const::Triple(v) => out.extend(v),
        Const::Matrix(m) => out.extend(m),
        Const::Str(_) => return false,
        Const::Array(items) => return items.iter().all(|c| flatten(c, out)),
    }
    true
}
