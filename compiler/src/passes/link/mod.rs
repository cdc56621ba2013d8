//! Joins the layers of a group into one shader.
//!
//! In: the layers' IR in order, values for their parameters, connections between them. Out: one [`Shader`] in which a
//! connected parameter starts as a conversion of its source's value. Its parameters are named `layer.param`; a group of one
//! layer keeps the shader's own names. It must not know the syntax tree or any target.
//!
//! Codes: `E4010` an unknown layer, `E4011` layers in the wrong order, `E4012` types that do not connect, `E4013` two layers of
//! one name, `E4014` a malformed path, `E4015` a group without layers; `E4001` an unknown parameter.

mod connect;
mod join;
mod path;

pub use join::shift_diagnostic;

use super::specialise::specialise;
use crate::diag::Diagnostic;
use crate::ir::{Arg, Block, Const, Inst, Shader, Stmt};

/// What a value says beside itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hints {
    /// `lockgeom`: whether geometry may not replace the value; `None`: as the shader says.
    pub lockgeom: Option<bool>,
    /// `interpolated`: geometry may replace the value.
    pub interpolated: bool,
    /// `interactive`: the value can be changed without compiling again.
    pub interactive: bool,
}

/// A value for a parameter of a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Flattened name.
    pub name: String,
    /// The value.
    pub value: Const,
    /// What else is said.
    pub hints: Hints,
}

/// A parameter that gets its value from an earlier layer. Paths are parameters, fields of them (`s.x`), elements (`a[2]`)
/// and components (`c[0]`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connection {
    /// The earlier layer.
    pub from_layer: String,
    /// What of it.
    pub from: String,
    /// The later layer.
    pub to_layer: String,
    /// What of it.
    pub to: String,
}

/// A layer to join.
#[derive(Clone, Debug)]
pub struct Part<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its shader as lowered.
    pub shader: &'a Shader,
    /// Added to the file of each of its spans.
    pub first_file: u32,
    /// Its parameters' values.
    pub settings: Vec<Setting>,
}

/// A layer after its values are bound.
struct Layer {
    name: String,
    shader: Shader,
}

/// Joins layers into one shader with this name.
pub fn link(name: &str, parts: &[Part<'_>], connections: &[Connection]) -> Result<Shader, Vec<Diagnostic>> {
    let _span = tracing::debug_span!("link", layers = parts.len()).entered();
    let mut errors = Vec::new();
    let mut layers = Vec::with_capacity(parts.len());
    for part in parts {
        let mut shader = part.shader.clone();
        join::shift_files(&mut shader, part.first_file);
        name_layer(&mut shader, part.name, name);
        let values: Vec<(String, Const)> = part.settings.iter().map(|s| (s.name.clone(), s.value.clone())).collect();
        if let Err(list) = specialise(&mut shader, &values) {
            errors.extend(list.into_iter().map(|d| in_layer(d, part.name)));
        }
        layers.push(Layer { name: part.name.to_owned(), shader });
    }
    for (i, layer) in layers.iter().enumerate() {
        if layers[..i].iter().any(|other| other.name == layer.name) {
            errors.push(Diagnostic::global("E4013", format!("two layers of the group are named `{}`", layer.name)));
        }
    }
    let wires = connect::resolve(&layers, connections, &mut errors);
    if !errors.is_empty() {
        return Err(errors);
    }
    let Some(last) = layers.pop() else {
        return Err(vec![Diagnostic::global("E4015", "the group has no layers")]);
    };
    if layers.is_empty() {
        return Ok(last.shader);
    }
    layers.push(last);
    Ok(join_all(name, layers, &wires))
}

/// One shader of several layers.
fn join_all(name: &str, layers: Vec<Layer>, wires: &[connect::Wire]) -> Shader {
    let kind = layers.last().map_or(String::new(), |l| l.shader.kind.clone());
    let mut joined = join::Joined::new(if name.is_empty() { "group" } else { name }, &kind);
    let mut blocks: Vec<Block> = Vec::new();
    for (index, layer) in layers.into_iter().enumerate() {
        let part = joined.add(&layer.name, layer.shader);
        let mut block = Block::default();
        for (param, init) in part.inits {
            let mine = wires.iter().filter(|w| w.to.layer == index && w.to.param == param);
            // A connection to all of a parameter stands for its default.
            if !mine.clone().any(|w| w.to.selection.is_empty()) {
                block.stmts.extend(init.stmts);
            }
            for wire in mine {
                connect::transfer(&mut joined, wire, &mut block);
            }
        }
        block.stmts.extend(part.body.stmts);
        blocks.push(block);
    }
    for block in blocks {
        joined.shader.body.stmts.extend(block.stmts);
    }
    joined.shader
}

/// Tells a layer's `getattribute` calls where they stand: their last two arguments are constants of their own.
fn name_layer(shader: &mut Shader, layer: &str, group: &str) {
    let Some(asks) = crate::builtins::find("attribute_get") else { return };
    let mut named = Vec::new();
    for block in shader.blocks() {
        block.walk(&mut |s| {
            if let Stmt::Call { func, args, .. } = s
                && *func == asks
                && let [.., Arg::Value(l), Arg::Value(g)] = args.as_slice()
            {
                named.extend([(*l, layer), (*g, group)]);
            }
        });
    }
    for (value, text) in named {
        shader.values[value.0 as usize].inst = Inst::Const(Const::Str(text.to_owned()));
    }
}

/// Says of a finding which layer it is about.
fn in_layer(mut d: Diagnostic, layer: &str) -> Diagnostic {
    if !layer.is_empty() {
        d.message = format!("layer `{layer}`: {}", d.message);
    }
    d
}
