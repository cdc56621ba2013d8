//! Joins the layers of a group into one shader.
//!
//! In: the layers' IR in order, values for their parameters, connections between them. Out: one [`Shader`] in which a
//! connected parameter starts as a conversion of its source's value. Its parameters are named `layer.param`; a group of one
//! layer keeps the shader's own names. It must not know the syntax tree or any target.
//!
//! Codes: `E4010` an unknown layer, `E4011` layers in the wrong order, `E4012` types that do not connect, `E4013` two layers of
//! one name, `E4014` a malformed path, `E4015` a group without layers; `E4001` an unknown parameter.

mod compose;
mod connect;
mod inputs;
mod join;
mod path;
mod place;
mod queries;

pub use inputs::Userdata;

pub use join::shift_diagnostic;

use super::specialise::specialise;
use crate::diag::Diagnostic;
use crate::ir::{Arg, Const, Inst, LocalKind, Shader, Source, Stmt};
use crate::messages::{GROUP, LAYER};

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

/// When layers run. In each case `true` is the default, and the word of the reference implementation's option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lazy {
    /// `lazylayers`: layers run when they are needed; otherwise all run in order.
    pub layers: bool,
    /// `lazyglobals`: also those that write globals.
    pub globals: bool,
    /// `lazyunconnected`: also those that feed no other layer, which then do not run.
    pub unconnected: bool,
    /// `lazyerror`: also those that call `error`.
    pub errors: bool,
    /// `lazytrace`: also those that call `trace`.
    pub traces: bool,
}

impl Default for Lazy {
    fn default() -> Lazy {
        Lazy { layers: true, globals: true, unconnected: true, errors: true, traces: true }
    }
}

/// What is joined.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// The shader's name.
    pub name: &'a str,
    /// The layers in order.
    pub parts: Vec<Part<'a>>,
    /// The connections in order.
    pub connections: &'a [Connection],
    /// When not empty, these layers run in this order, with what they need, and no others.
    pub entry_layers: &'a [String],
    /// Outputs that are asked for: `layer.param`, `param` of the last layer that has it, or `Ci`.
    pub outputs: &'a [String],
    /// What geometry may have; `None`: nobody knows.
    pub userdata: Option<&'a [Userdata]>,
    /// Whether interactive parameters are read at run time.
    pub interactive: bool,
    /// Parameters that are interactive whatever their declaration says: `layer.param`, or `param` of a shader alone.
    pub interactive_names: &'a [String],
    /// Whether `isconnected` says that a parameter which may read userdata is connected.
    pub userdata_is_connected: bool,
    /// When layers run.
    pub lazy: Lazy,
}

/// A layer after its values are bound.
struct Layer {
    name: String,
    shader: Shader,
    reads: Vec<inputs::Reads>,
}

/// Joins layers into one shader, and the names that the outputs have in it; a name that means none stays, for the message
/// of who looks for it.
pub fn link(request: &Request<'_>) -> Result<(Shader, Vec<String>), Vec<Diagnostic>> {
    let _span = tracing::debug_span!("link", layers = request.parts.len()).entered();
    let mut errors = Vec::new();
    let mut layers: Vec<Layer> = Vec::with_capacity(request.parts.len());
    for part in &request.parts {
        if layers.iter().any(|other| other.name == part.name) {
            errors.push(Diagnostic::global("E4013", format!("two layers of the group are named `{}`", part.name)));
        }
        match bind(part, layers.len(), request.name) {
            Ok(mut layer) => {
                for (reads, param) in layer.reads.iter_mut().zip(&layer.shader.params) {
                    let is = |name: &String| match layer.name.as_str() {
                        "" => *name == param.name,
                        layer => name.strip_prefix(layer).and_then(|n| n.strip_prefix('.')) == Some(&param.name),
                    };
                    if request.interactive_names.iter().any(is) {
                        *reads = inputs::Reads { userdata: false, interactive: true };
                    }
                }
                layers.push(layer);
            }
            Err(list) => errors.extend(list.into_iter().map(|d| in_layer(d, part.name))),
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    if layers.is_empty() {
        return Err(vec![Diagnostic::global("E4015", "the group has no layers")]);
    }
    let wires = connect::resolve(&mut layers, request.connections, &mut errors);
    let mut entries = Vec::new();
    for name in request.entry_layers {
        match connect::layer(&layers, name) {
            Ok(index) if entries.contains(&index) => {}
            Ok(index) => entries.push(index),
            Err(d) => errors.push(d),
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let outputs: Vec<Option<(usize, usize)>> = request.outputs.iter().map(|name| output(&layers, name)).collect();
    let found: Vec<(usize, usize)> = outputs.iter().flatten().copied().collect();
    for (index, layer) in layers.iter_mut().enumerate() {
        let up: Vec<bool> = (0..layer.shader.params.len())
            .map(|p| wires.iter().any(|w| w.to.layer == index && w.to.param == p))
            .collect();
        let whole: Vec<bool> = (0..layer.shader.params.len())
            .map(|p| wires.iter().any(|w| w.to.layer == index && w.to.param == p && w.to.selection.is_empty()))
            .collect();
        let connected = |p: usize| {
            let up = up[p] || request.userdata_is_connected && layer.reads[p].userdata;
            let down = found.contains(&(index, p)) || wires.iter().any(|w| w.from.layer == index && w.from.param == p);
            i32::from(up) + 2 * i32::from(down)
        };
        queries::settle(&mut layer.shader, &connected);
        inputs::make_explicit(&mut layer.shader, &layer.reads, &whole, request);
    }
    let one = layers.len() == 1;
    let names = outputs.iter().zip(request.outputs).map(|(found, asked)| match found {
        Some((layer, param)) if one => layers[*layer].shader.params[*param].name.clone(),
        Some((layer, param)) => format!("{}.{}", layers[*layer].name, layers[*layer].shader.params[*param].name),
        None => asked.clone(),
    });
    let names = names.collect();
    let shader = match layers.pop() {
        Some(mut only) if layers.is_empty() => {
            // A layer's name is part of its interactive parameters' names even where it is the only one.
            let interactive = only
                .shader
                .inputs
                .iter_mut()
                .filter(|i| matches!(i.source, Source::Interactive | Source::HasInteractive));
            for input in interactive.filter(|_| !only.name.is_empty()) {
                input.name = format!("{}.{}", only.name, input.name);
            }
            only.shader
        }
        last => {
            layers.extend(last);
            compose::compose(request, layers, &wires, &found, &entries)
        }
    };
    Ok((shader, names))
}

/// A layer's own shader with its values.
fn bind(part: &Part<'_>, index: usize, group: &str) -> Result<Layer, Vec<Diagnostic>> {
    let mut shader = part.shader.clone();
    join::shift_files(&mut shader, part.first_file);
    name_layer(&mut shader, part.name, group);
    name_in_reports(&mut shader, index, part.name, group);
    let values: Vec<(String, Const)> = part.settings.iter().map(|s| (s.name.clone(), s.value.clone())).collect();
    specialise(&mut shader, &values)?;
    let reads = shader.params.iter().map(|param| {
        let mut reads = inputs::Reads {
            userdata: param.varying && !param.traits.interactive,
            interactive: param.traits.interactive,
        };
        // Of several values the last counts.
        if let Some(setting) = part.settings.iter().rev().find(|s| s.name == param.name) {
            let hints = setting.hints;
            reads.userdata = hints.interpolated || hints.lockgeom.map_or(reads.userdata, |locked| !locked);
            reads.interactive |= hints.interactive;
        }
        reads
    });
    Ok(Layer { name: part.name.to_owned(), reads: reads.collect(), shader })
}

/// Answers what a shader that was not linked asks about its group.
pub(super) fn settle_alone(shader: &mut Shader) {
    queries::settle(shader, &|_| 0);
}

/// The output that a name means: its layer and parameter.
fn output(layers: &[Layer], name: &str) -> Option<(usize, usize)> {
    let find = |layer: usize, name: &str| {
        let params = &layers[layer].shader.params;
        params.iter().position(|p| p.output && p.name == name).map(|p| (layer, p))
    };
    if name == "Ci" {
        return None;
    }
    let split = name.match_indices('.').find_map(|(at, _)| {
        let layer = layers.iter().rposition(|l| l.name == name[..at])?;
        find(layer, &name[at + 1..])
    });
    split.or_else(|| (0..layers.len()).rev().find_map(|layer| find(layer, name)))
}

/// Whether a parameter's init sets other parameters too, as that of a struct's first field may.
pub(super) fn writes_others(shader: &Shader, index: usize) -> bool {
    let own = shader.params[index].local;
    let mut found = false;
    shader.params[index].init.walk(&mut |s| {
        s.written(&mut |l| found |= l != own && matches!(shader.locals[l.0 as usize].kind, LocalKind::Param(_)));
    });
    found
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

/// Puts the group's and the layer's names where reports have [`GROUP`] and [`LAYER`].
fn name_in_reports(shader: &mut Shader, index: usize, layer: &str, group: &str) {
    // What the reference implementation calls a group without a name.
    let group = if group.is_empty() { "unnamed_group_1" } else { group };
    let escaped = |name: &str| name.replace('%', "%%");
    for value in &mut shader.values {
        if let Inst::Const(Const::Str(text)) = &mut value.inst
            && text.contains(GROUP)
        {
            let layer = format!("{index} {}", escaped(layer));
            *text = text.replace(GROUP, &escaped(group)).replace(LAYER, &layer);
        }
    }
}

/// Says of a finding which layer it is about.
fn in_layer(mut d: Diagnostic, layer: &str) -> Diagnostic {
    if !layer.is_empty() {
        d.message = format!("layer `{layer}`: {}", d.message);
    }
    d
}
