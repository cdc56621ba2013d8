//! Which function a back end writes, and which outputs a grid function has.
//!
//! In: a shader, names of outputs. Out: where each output's value comes from and where it goes. It must not know how code is
//! written.

use crate::builtins::{self, ClosureRole};
use crate::diag::Diagnostic;
use crate::ir::{Global, LobeSlot, LocalId, LocalKind, Shader, Ty};
use crate::types::{Extent, Type};
use serde::{Deserialize, Serialize};

/// Which function to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Entry {
    /// `void ENTRY(const ShaderGlobals *sg, real pick, ShadeResult *out)`, as kernels/lobe.h describes it.
    Material,
    /// `void ENTRY(const ShaderGlobals *sg, real *outputs)`: stores these output parameters (or `Ci`, the sum of all lobes'
    /// weights) one behind the other as reals.
    Grid(Vec<String>),
}

/// One requested output of a grid function.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    /// Flattened name of the parameter, or `Ci`.
    pub name: String,
    /// Its type in OSL's words, such as `color` or `float[4]`.
    #[serde(rename = "type")]
    pub ty: String,
    /// Index of its first real.
    pub offset: u32,
    /// How many reals.
    pub reals: u32,
}

/// The outputs of a grid function with these names, as it stores them.
pub fn listed(shader: &Shader, names: &[String]) -> Result<Vec<Output>, Vec<Diagnostic>> {
    Ok(outputs(shader, names)?.into_iter().map(|(_, output)| output).collect())
}

/// What a slot's closure is for.
pub(super) fn role(slot: &LobeSlot) -> ClosureRole {
    builtins::closure(slot.closure).role
}

/// The outputs with these names, one behind the other.
pub(super) fn outputs(shader: &Shader, names: &[String]) -> Result<Vec<(Source, Output)>, Vec<Diagnostic>> {
    let mut errors = Vec::new();
    let mut outputs: Vec<(Source, Output)> = Vec::new();
    let mut offset = 0;
    for name in names {
        let (source, ty, reals) = match output(shader, name) {
            Ok(found) => found,
            Err(d) => {
                errors.push(d);
                continue;
            }
        };
        outputs.push((source, Output { name: name.clone(), ty, offset, reals }));
        offset += reals;
    }
    if errors.is_empty() { Ok(outputs) } else { Err(errors) }
}

/// Where an output's value comes from.
pub(super) enum Source {
    /// A parameter, or a global that the shader writes.
    Local(LocalId),
    /// A global that the shader leaves alone.
    Field(Global),
    /// The sum of all weights.
    Ci,
}

/// Source, type and size of an output: a parameter, `Ci`, or what a displacement shader moves, `P` and `N`.
fn output(shader: &Shader, name: &str) -> Result<(Source, String, u32), Diagnostic> {
    if name == "Ci" {
        return Ok((Source::Ci, "color".to_owned(), 3));
    }
    if let Some(global) = [Global::P, Global::N].into_iter().find(|g| g.name() == name) {
        let local = shader.locals.iter().position(|l| l.kind == LocalKind::Global(global));
        let source = local.map_or(Source::Field(global), |i| Source::Local(LocalId(i as u32)));
        return Ok((source, if global == Global::P { "point" } else { "normal" }.to_owned(), 3));
    }
    let Some(param) = shader.params.iter().find(|p| p.output && p.name == name) else {
        let d = Diagnostic::global("E4203", format!("shader `{}` has no output parameter `{name}`", shader.name));
        let all: Vec<&str> = shader.params.iter().filter(|p| p.output).map(|p| p.name.as_str()).take(12).collect();
        return Err(match all.as_slice() {
            [] => d.help("it has none; `Ci` is always there"),
            all => d.help(format!("its outputs: {}", all.join(", "))),
        });
    };
    let local = &shader.locals[param.local.0 as usize];
    let width = match local.ty {
        Ty::Int | Ty::Float => 1,
        Ty::Triple => 3,
        Ty::Matrix => 16,
        Ty::Str | Ty::Closure => {
            let message = format!("output parameter `{name}` is no number");
            return Err(
                Diagnostic::error("E4204", param.span, message).help("ask for numbers, triples, matrices or `Ci`")
            );
        }
    };
    let Type { base, extent } = param.declared;
    let length = match (extent, local.len) {
        (Extent::Scalar, None) => String::new(),
        (_, len) => format!("[{}]", len.unwrap_or(0)),
    };
    Ok((Source::Local(param.local), format!("{}{length}", base.keyword()), width * local.len.unwrap_or(1)))
}
