//! Puts the layers' statements in order, lazily: a layer runs where its outputs are first needed, or not at all.
//!
//! In: layers and wires. Out: one shader. Layers without effects run at the nearest place before all that needs them. For a
//! layer whose effects can be seen (`printf` and the like) the place is exact: where several branches need it, each has a
//! copy that runs unless another one ran.

use super::connect::{self, Wire};
use super::join::{self, Joined};
use super::place::{self, Needs};
use super::{Layer, Request, writes_others};
use crate::builtins;
use crate::ir::{Arg, Block, Const, Inst, Local, LocalId, LocalKind, Shader, Stmt, Ty, UnaryOp, Value, ValueId};
use crate::messages;
use crate::source::{FileId, Span};
use std::collections::HashMap;

/// Most copies of a layer with effects, and most statements of all of them.
const MAX_COPIES: usize = 8;
const MAX_COPIED: usize = 20_000;

/// What is known of a layer beside its statements.
struct Facts {
    has_effects: bool,
    writes_globals: bool,
    reports_errors: bool,
    traces: bool,
    feeds_others: bool,
    has_outputs: bool,
}

/// One shader of several layers. `outputs` are the parameters asked for, by layer and index.
pub(super) fn compose(
    request: &Request<'_>,
    layers: Vec<Layer>,
    wires: &[Wire],
    outputs: &[(usize, usize)],
    entries: &[usize],
) -> Shader {
    let kind = layers.last().map_or(String::new(), |l| l.shader.kind.clone());
    let count = layers.len();
    let mut joined = Joined::new(if request.name.is_empty() { "group" } else { request.name }, &kind);
    let mut facts = Vec::with_capacity(count);
    let mut blocks = Vec::with_capacity(count);
    for (index, layer) in layers.into_iter().enumerate() {
        let all_lazy = request.lazy.globals && request.lazy.errors && request.lazy.traces;
        // Whether a call or an assignment is there at all may hang on values: they are folded to see.
        let folded = if all_lazy { None } else { folded(&layer.shader) };
        let seen = folded.as_ref().unwrap_or(&layer.shader);
        facts.push(Facts {
            has_effects: has_effects(&layer.shader),
            writes_globals: writes_globals(seen),
            reports_errors: reports_errors(seen),
            traces: traces(seen),
            feeds_others: wires.iter().any(|w| w.from.layer == index),
            has_outputs: outputs.iter().any(|(l, _)| *l == index),
        });
        let kept: Vec<bool> = (0..layer.shader.params.len()).map(|p| writes_others(&layer.shader, p)).collect();
        let added = joined.add(&layer.name, layer.shader);
        blocks.push(layer_block(&mut joined, index, added, &kept, wires, outputs));
    }
    let lazy = request.lazy;
    let always = |k: usize| {
        let f = &facts[k];
        k + 1 == count
            || !lazy.layers
            || f.has_outputs
            || f.writes_globals && !lazy.globals
            || !f.feeds_others && !lazy.unconnected
            || f.reports_errors && !lazy.errors
            || f.traces && !lazy.traces
    };
    let roots: Vec<usize> =
        if entries.is_empty() { (0..count).filter(|k| always(*k)).collect() } else { entries.to_vec() };
    // A root is held by a statement that touches a local which is no layer's: its number follows those of all locals.
    let first_mark = joined.shader.locals.len() as u32;
    let mark = |k: usize| LocalId(first_mark + k as u32);
    let mut tree: Vec<Stmt> = roots.iter().map(|k| Stmt::CopyArray(mark(*k), mark(*k))).collect();
    let owner = owners(&joined);
    let mut flags = Vec::new();
    for k in (0..count).rev() {
        let block = std::mem::take(&mut blocks[k]);
        let is_needed = |l: LocalId| l == mark(k) || owner.get(l.0 as usize) == Some(&Some(k));
        let mut inserter = Inserter { joined: &mut joined, first_flag: first_mark + count as u32, flags: &mut flags };
        inserter.insert(&mut tree, block, &is_needed, facts[k].has_effects);
        tree.retain(|s| !matches!(s, Stmt::CopyArray(l, _) if *l == mark(k)));
    }
    // The marks are gone; the flags get their locals.
    let first_flag = LocalId(joined.shader.locals.len() as u32);
    joined.shader.locals.extend(flags);
    let moved = first_mark + count as u32;
    let local = |l: &mut LocalId| {
        if l.0 >= moved {
            l.0 = l.0 - moved + first_flag.0;
        }
    };
    for value in &mut joined.shader.values {
        if let Inst::Load(l) = &mut value.inst {
            local(l);
        }
    }
    let mut body = Block { stmts: tree };
    body.rename(&local, &|_| {});
    joined.shader.body = body;
    joined.shader
}

/// The layer of each local that is a parameter.
fn owners(joined: &Joined) -> Vec<Option<usize>> {
    let layer_of = |param: u32| joined.first_param.partition_point(|first| *first <= param as usize) - 1;
    let owner = |l: &Local| match l.kind {
        LocalKind::Param(p) => Some(layer_of(p)),
        _ => None,
    };
    joined.shader.locals.iter().map(owner).collect()
}

/// A copy that is folded; `None` when that is not possible, which is said later.
fn folded(shader: &Shader) -> Option<Shader> {
    let mut copy = shader.clone();
    crate::passes::fold(&mut copy).ok().map(|()| copy)
}

/// Whether it does what can be seen beside its outputs.
fn has_effects(shader: &Shader) -> bool {
    let mut found = false;
    for block in shader.blocks() {
        block.walk(&mut |s| {
            found |= matches!(s, Stmt::Call { outputs, result, .. } if outputs.is_empty() && result.is_none());
        });
    }
    found
}

/// Whether it may call `error`.
fn reports_errors(shader: &Shader) -> bool {
    let mut found = false;
    for block in shader.blocks() {
        block.walk(&mut |s| {
            if let Stmt::Call { func, args, .. } = s
                && builtins::row(*func).name == "print"
                && let Some(Arg::Value(code)) = args.first()
            {
                found |= shader.values[code.0 as usize].inst == Inst::Const(Const::Int(messages::code::ERROR));
            }
        });
    }
    found
}

/// Whether it may call `trace`.
fn traces(shader: &Shader) -> bool {
    let mut found = false;
    for block in shader.blocks() {
        block.walk(&mut |s| {
            if let Stmt::Call { func, .. } = s {
                found |= builtins::row(*func).name == "trace_call";
            }
        });
    }
    found
}

fn writes_globals(shader: &Shader) -> bool {
    let mut found = false;
    for block in shader.blocks() {
        block.walk(&mut |s| {
            s.written(&mut |l| found |= matches!(shader.locals[l.0 as usize].kind, LocalKind::Global(_)));
        });
    }
    found
}

/// A layer's statements: the inits of its parameters, its body, and what its wires bring, where it is first needed.
fn layer_block(
    joined: &mut Joined,
    layer: usize,
    added: join::Added,
    kept: &[bool],
    wires: &[Wire],
    outputs: &[(usize, usize)],
) -> Vec<Stmt> {
    let mut block = Vec::new();
    let mut units: Vec<(usize, Vec<Stmt>)> = Vec::new();
    for (param, init) in added.inits {
        let mine: Vec<&Wire> = wires.iter().filter(|w| w.to.layer == layer && w.to.param == param).collect();
        if mine.is_empty() {
            block.extend(init.stmts);
            continue;
        }
        let mut unit = Block::default();
        // A wire to all of a parameter stands for its default; that to a part needs the rest of it.
        if kept[param] {
            block.extend(init.stmts);
        } else if !mine.iter().any(|w| w.to.selection.is_empty()) {
            unit = init;
        }
        for wire in mine {
            connect::transfer(joined, wire, &mut unit);
        }
        units.push((param, unit.stmts));
    }
    block.extend(added.body.stmts);
    // Later parameters first: their defaults may read earlier ones.
    for (param, mut unit) in units.into_iter().rev() {
        let local = joined.shader.params[joined.param(layer, param)].local;
        let at_end =
            outputs.contains(&(layer, param)) || wires.iter().any(|w| w.from.layer == layer && w.from.param == param);
        let is_needed = |l: LocalId| l == local;
        let needs = Needs { values: &joined.shader.values, is_needed: &is_needed };
        place::insert(&mut block, &mut unit, &needs, at_end);
    }
    block
}

/// Puts layers into the tree.
struct Inserter<'a> {
    joined: &'a mut Joined,
    /// The number of the first flag, until the flags have locals.
    first_flag: u32,
    flags: &'a mut Vec<Local>,
}

impl Inserter<'_> {
    fn insert(
        &mut self,
        tree: &mut Vec<Stmt>,
        mut block: Vec<Stmt>,
        is_needed: &dyn Fn(LocalId) -> bool,
        has_effects: bool,
    ) {
        let needs = Needs { values: &self.joined.shader.values, is_needed };
        let copies = if has_effects && !place::is_exact(tree, &needs) { place::count_each(tree, &needs) } else { 0 };
        let size = copies * count(&block);
        if copies == 0 || copies > MAX_COPIES || size > MAX_COPIED {
            place::insert(tree, &mut block, &needs, false);
            return;
        }
        // The needs look at values of statements in the tree, while copies add more.
        let values = self.joined.shader.values.clone();
        let needs = Needs { values: &values, is_needed };
        let flag = LocalId(self.first_flag + self.flags.len() as u32);
        self.flags.push(Local { name: "ran".into(), ty: Ty::Int, len: None, kind: LocalKind::Variable });
        let mut original = Some(block);
        let mut spare = Vec::new();
        place::insert_each(
            tree,
            &mut || {
                let body = match original.take() {
                    Some(body) => {
                        spare = body.clone();
                        body
                    }
                    None => self.copy(&spare),
                };
                self.unless(flag, body)
            },
            &needs,
        );
    }

    /// `if (!flag) { flag = 1; body }`
    fn unless(&mut self, flag: LocalId, body: Vec<Stmt>) -> Vec<Stmt> {
        const NOWHERE: Span = Span { file: FileId(0), start: 0, end: 0 };
        let span = body.iter().find_map(|s| match s {
            Stmt::Let(v) => self.joined.shader.values.get(v.0 as usize).map(|v| v.span),
            Stmt::Call { span, .. } => Some(*span),
            _ => None,
        });
        let span = span.unwrap_or(NOWHERE);
        let mut out = Block::default();
        let ran = self.joined.shader.emit(Inst::Load(flag), Ty::Int, span, &mut out);
        let not = self.joined.shader.emit(Inst::Unary(UnaryOp::Not, ran), Ty::Int, span, &mut out);
        let mut then = Block::default();
        let one = self.joined.shader.emit_constant(Const::Int(1), span, &mut then);
        then.stmts.push(Stmt::Store(flag, one));
        then.stmts.extend(body);
        out.stmts.push(Stmt::If(not, then, Block::default()));
        out.stmts
    }

    /// The same statements with values of their own.
    fn copy(&mut self, stmts: &[Stmt]) -> Vec<Stmt> {
        let mut block = Block { stmts: stmts.to_vec() };
        let mut ids: Vec<ValueId> = Vec::new();
        block.walk(&mut |s| {
            if let Stmt::Let(v) = s {
                ids.push(*v);
            }
        });
        // Operands have smaller numbers than what is computed from them.
        ids.sort();
        let values = &mut self.joined.shader.values;
        let mut new: HashMap<ValueId, ValueId> = HashMap::new();
        for id in ids {
            let Value { mut inst, ty, span } = values[id.0 as usize].clone();
            inst.operands_mut(&mut |v| *v = new.get(v).copied().unwrap_or(*v));
            new.insert(id, ValueId(values.len() as u32));
            values.push(Value { inst, ty, span });
        }
        block.rename(&|_| {}, &|v| *v = new.get(v).copied().unwrap_or(*v));
        block.stmts
    }
}

fn count(stmts: &[Stmt]) -> usize {
    let mut n = stmts.len();
    for stmt in stmts {
        stmt.blocks(&mut |b| n += count(&b.stmts));
    }
    n
}
