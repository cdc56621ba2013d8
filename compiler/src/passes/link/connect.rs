//! Connections: from paths to wires between single parameters, and what a wire computes.
//!
//! In: layers and connections as written. Out: [`Wire`]s, or what does not fit. The rules (specification ch. 9, and ch. 2):
//! equal types; triples among each other; int to float; int and float to a triple, replicated; a component of an aggregate
//! from and to a float; whole structs whose fields connect one by one; arrays of equal length, or unsized.

use super::join::Joined;
use super::{Connection, Layer, path};
use crate::diag::Diagnostic;
use crate::ir::{Block, Const, Inst, LocalId, Stmt, Ty, ValueId};
use crate::source::Span;
use crate::types::Base;

/// One end of a wire.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct End {
    /// Index of the layer.
    pub layer: usize,
    /// Index of its parameter.
    pub param: usize,
    /// Element of an array and component of a triple or matrix, as the path says; empty for all of it.
    pub selection: Vec<u32>,
}

/// A connection between two flattened parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Wire {
    pub from: End,
    pub to: End,
}

/// Resolves connections in order. A later one to the same parameter replaces an earlier one.
pub(super) fn resolve(layers: &mut [Layer], connections: &[Connection], errors: &mut Vec<Diagnostic>) -> Vec<Wire> {
    let mut wires: Vec<Wire> = Vec::new();
    // Earlier layers first: an unsized array takes its length from its source, which may be one itself.
    let rank = |c: &Connection| layers.iter().position(|l| l.name == c.to_layer);
    let mut ordered: Vec<(Option<usize>, &Connection)> = connections.iter().map(|c| (rank(c), c)).collect();
    ordered.sort_by_key(|(rank, _)| *rank);
    for (_, connection) in ordered {
        match wires_of(layers, connection) {
            Ok(new) => {
                for wire in new {
                    take_length(layers, &wire);
                    wires.retain(|w| w.to != wire.to);
                    wires.push(wire);
                }
            }
            Err(d) => errors.push(d),
        }
    }
    wires
}

/// An unsized array gets the length of what is connected to it.
fn take_length(layers: &mut [Layer], wire: &Wire) {
    if !wire.to.selection.is_empty() || !wire.from.selection.is_empty() {
        return;
    }
    let from = &layers[wire.from.layer].shader;
    let len = from.locals[from.params[wire.from.param].local.0 as usize].len;
    let to = &mut layers[wire.to.layer].shader;
    if to.params[wire.to.param].traits.open {
        to.locals[to.params[wire.to.param].local.0 as usize].len = len;
    }
}

/// `layer.path` for messages.
fn shown(layer: &str, path: &str) -> String {
    format!("`{layer}.{path}`")
}

fn wires_of(layers: &[Layer], c: &Connection) -> Result<Vec<Wire>, Diagnostic> {
    let from_layer = layer(layers, &c.from_layer)?;
    let to_layer = layer(layers, &c.to_layer)?;
    let what = format!("{} to {}", shown(&c.from_layer, &c.from), shown(&c.to_layer, &c.to));
    if from_layer >= to_layer {
        let d = Diagnostic::global("E4011", format!("cannot connect {what}: the source is not an earlier layer"));
        let help = format!("put layer `{}` before layer `{}`", c.from_layer, c.to_layer);
        return Err(if from_layer == to_layer { d } else { d.help(help) });
    }
    let from = ends(layers, from_layer, &c.from)?;
    let to = ends(layers, to_layer, &c.to)?;
    let refuse = |why: String, span: Option<Span>| {
        let d = Diagnostic::global("E4012", format!("cannot connect {what}: {why}"));
        match span {
            Some(span) => d.label(span, "declared here"),
            None => d,
        }
    };
    if from.len() != to.len() {
        return Err(refuse("the two structs differ in their fields".into(), None));
    }
    // Fields connect in order, whatever their names.
    let mut wires = Vec::with_capacity(from.len());
    for ((_, from), (_, to)) in from.into_iter().zip(to) {
        let (a, b) = (type_of(layers, &from), type_of(layers, &to));
        let span = layers[to.layer].shader.params[to.param].span;
        let (a, b) = match (a, b) {
            (Ok(a), Ok(b)) => (a, b),
            (Err(why), _) | (_, Err(why)) => return Err(refuse(why, Some(span))),
        };
        if layers[to.layer].shader.params[to.param].traits.unconnectable {
            let why = "its metadata says `allowconnect = 0`";
            return Err(
                Diagnostic::global("E4016", format!("cannot connect {what}: {why}")).label(span, "declared here")
            );
        }
        if !connects(a, b) {
            return Err(refuse(format!("{} does not convert to {}", show(a), show(b)), Some(span)));
        }
        wires.push(Wire { from, to });
    }
    Ok(wires)
}

/// The layer with this name; of several the last, as the reference implementation has it.
pub(super) fn layer(layers: &[Layer], name: &str) -> Result<usize, Diagnostic> {
    let found = layers.iter().rposition(|l| l.name == name);
    found.ok_or_else(|| {
        let d = Diagnostic::global("E4010", format!("the group has no layer `{name}`"));
        let names = layers.iter().map(|l| l.name.as_str());
        match crate::suggest::closest(name, names.clone()) {
            Some(near) => d.help(format!("did you mean `{near}`?")),
            None => d.help(format!("its layers: {}", names.take(12).collect::<Vec<_>>().join(", "))),
        }
    })
}

/// The flattened parameters that a path names, each with its name behind the path.
fn ends(layers: &[Layer], index: usize, text: &str) -> Result<Vec<(String, End)>, Diagnostic> {
    let layer = &layers[index];
    let path = path::parse(text)
        .map_err(|why| Diagnostic::global("E4014", format!("{} is no parameter: {why}", shown(&layer.name, text))))?;
    let params = &layer.shader.params;
    let end = |param| End { layer: index, param, selection: path.indices.clone() };
    if let Some(param) = params.iter().position(|p| p.name == path.name) {
        return Ok(vec![(String::new(), end(param))]);
    }
    let prefix = format!("{}.", path.name);
    let fields =
        params.iter().enumerate().filter_map(|(i, p)| Some((p.name.strip_prefix(&prefix)?.to_owned(), end(i))));
    let fields: Vec<_> = fields.collect();
    if !fields.is_empty() {
        return Ok(fields);
    }
    let message = format!("layer `{}` (shader `{}`) has no parameter `{}`", layer.name, layer.shader.name, path.name);
    let d = Diagnostic::global("E4001", message);
    Err(match crate::suggest::closest(&path.name, params.iter().map(|p| p.name.as_str())) {
        Some(near) => d.help(format!("did you mean `{near}`?")),
        None if params.is_empty() => d.help("it has no parameters"),
        None => {
            let all: Vec<&str> = params.iter().map(|p| p.name.as_str()).take(12).collect();
            d.help(format!("its parameters: {}", all.join(", ")))
        }
    })
}

/// A type with the length that it has now.
#[derive(Clone, Copy, PartialEq)]
struct Found {
    base: Base,
    len: Option<u32>,
    unsized_: bool,
}

fn show(t: Found) -> String {
    match t.len {
        _ if t.unsized_ => format!("{}[]", t.base.keyword()),
        Some(n) => format!("{}[{n}]", t.base.keyword()),
        None => t.base.keyword().to_owned(),
    }
}

/// The type at an end, its element and component taken.
fn type_of(layers: &[Layer], end: &End) -> Result<Found, String> {
    let shader = &layers[end.layer].shader;
    let param = &shader.params[end.param];
    let base = param.declared.base;
    let mut found = Found { base, len: shader.locals[param.local.0 as usize].len, unsized_: param.traits.open };
    for &index in &end.selection {
        let (base, limit) = match (found.len, found.base) {
            (Some(len), base) => (base, len),
            (None, base) if base.is_triple() => (Base::Float, 3),
            // A row, of which the next index takes an element.
            (None, Base::Matrix) => (Base::Matrix, 4),
            _ => return Err(format!("{} has no elements", show(found))),
        };
        if index >= limit {
            return Err(format!("index {index} is outside {}", show(found)));
        }
        found = Found { base, len: None, unsized_: false };
    }
    if found.base == Base::Matrix && found.len.is_none() {
        let into = end.selection.len()
            - usize::from(shader.locals[param.local.0 as usize].len.is_some() && !end.selection.is_empty());
        found.base = match into {
            0 => Base::Matrix,
            2 => Base::Float,
            _ => return Err("a matrix has elements by row and column".into()),
        };
    }
    Ok(found)
}

/// Whether a value of one type can set the other.
fn connects(from: Found, to: Found) -> bool {
    let same = from.base == to.base || from.base.is_triple() && to.base.is_triple();
    match (from.len, to.len) {
        (None, None) => {
            same || matches!((from.base, to.base), (Base::Int, Base::Float))
                || matches!(from.base, Base::Int | Base::Float) && to.base.is_triple()
        }
        (Some(a), Some(b)) => same && (to.unsized_ || from.unsized_ || a == b),
        _ => false,
    }
}

/// Writes what a wire does: the destination gets the source's value.
pub(super) fn transfer(joined: &mut Joined, wire: &Wire, block: &mut Block) {
    let end = |end: &End| {
        let param = &joined.shader.params[joined.param(end.layer, end.param)];
        (param.local, joined.shader.locals[param.local.0 as usize].len.is_some(), param.span)
    };
    let (from, from_array, _) = end(&wire.from);
    let (to, to_array, span) = end(&wire.to);
    if from_array && to_array && wire.from.selection.is_empty() && wire.to.selection.is_empty() {
        block.stmts.push(Stmt::CopyArray(to, from));
        return;
    }
    let value = read(joined, block, from, from_array, &wire.from.selection, span);
    write(joined, block, to, to_array, &wire.to.selection, value, span);
}

fn int(joined: &mut Joined, block: &mut Block, i: u32, span: Span) -> ValueId {
    joined.shader.emit_constant(Const::Int(i as i32), span, block)
}

fn read(joined: &mut Joined, block: &mut Block, l: LocalId, array: bool, selection: &[u32], span: Span) -> ValueId {
    let ty = joined.shader.locals[l.0 as usize].ty;
    let (whole, rest) = match selection.split_first() {
        Some((i, rest)) if array => {
            let i = int(joined, block, *i, span);
            (joined.shader.emit(Inst::LoadElem(l, i), ty, span, block), rest)
        }
        _ => (joined.shader.emit(Inst::Load(l), ty, span, block), selection),
    };
    match *rest {
        [i] => {
            let i = int(joined, block, i, span);
            joined.shader.emit(Inst::Component(whole, i), Ty::Float, span, block)
        }
        [r, c] => {
            let (r, c) = (int(joined, block, r, span), int(joined, block, c, span));
            joined.shader.emit(Inst::MatrixElement(whole, r, c), Ty::Float, span, block)
        }
        _ => whole,
    }
}

/// Converts along `int -> float -> triple`.
fn convert(joined: &mut Joined, block: &mut Block, value: ValueId, to: Ty, span: Span) -> ValueId {
    let from = joined.shader.values[value.0 as usize].ty;
    match (from, to) {
        (Ty::Int, Ty::Float) | (Ty::Float, Ty::Triple) => joined.shader.emit(Inst::Convert(value), to, span, block),
        (Ty::Int, Ty::Triple) => {
            let float = joined.shader.emit(Inst::Convert(value), Ty::Float, span, block);
            joined.shader.emit(Inst::Convert(float), to, span, block)
        }
        _ => value,
    }
}

fn write(
    joined: &mut Joined,
    block: &mut Block,
    l: LocalId,
    array: bool,
    selection: &[u32],
    value: ValueId,
    span: Span,
) {
    let ty = joined.shader.locals[l.0 as usize].ty;
    let (element, rest) = match selection.split_first() {
        Some((i, rest)) if array => (Some(int(joined, block, *i, span)), rest),
        _ => (None, selection),
    };
    let value = if rest.is_empty() {
        convert(joined, block, value, ty, span)
    } else {
        let value = convert(joined, block, value, Ty::Float, span);
        let inst = element.map_or(Inst::Load(l), |i| Inst::LoadElem(l, i));
        let old = joined.shader.emit(inst, ty, span, block);
        match *rest {
            [r, c] => {
                let (r, c) = (int(joined, block, r, span), int(joined, block, c, span));
                joined.shader.emit(Inst::WithMatrixElement(old, r, c, value), ty, span, block)
            }
            [i, ..] => {
                let i = int(joined, block, i, span);
                joined.shader.emit(Inst::WithComponent(old, i, value), ty, span, block)
            }
            [] => value,
        }
    };
    block.stmts.push(match element {
        Some(i) => Stmt::StoreElem(l, i, value),
        None => Stmt::Store(l, value),
    });
}
