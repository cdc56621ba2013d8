//! Parameters whose values come from outside: userdata of the geometry, and interactive ones.
//!
//! In: a layer after its values are bound, what the renderer supplies. Out: the layer with explicit reads of
//! [`Input`]s in the inits of such parameters; what nobody supplies keeps its default and is folded like any other.

use super::Request;
use crate::interp::{self, ops};
use crate::ir::{Block, Const, Global, Input, Inst, Local, LocalId, LocalKind, Shader, Source, Stmt, Ty, ValueId};
use crate::source::Span;
use crate::types::{Base, Extent, Type};
use std::collections::HashMap;

/// Data that geometry may have at a point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Userdata {
    /// Its name, which is that of the parameters that read it.
    pub name: String,
    /// Its type; triples are equal to each other.
    pub ty: Type,
    /// Some points are without it; there a parameter has its default.
    pub sometimes: bool,
    /// The global that it is equal to, such as `u`; `None`: the renderer supplies it (`Artifact::inputs`).
    pub same_as: Option<String>,
}

/// What a parameter reads, as its declaration and the hints of its value say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Reads {
    pub userdata: bool,
    pub interactive: bool,
}

/// Makes the reads of a layer's parameters explicit. `connected` tells which parameters need none.
pub(super) fn make_explicit(shader: &mut Shader, reads: &[Reads], connected: &[bool], request: &Request<'_>) {
    for index in 0..shader.params.len() {
        let known = request.userdata;
        shader.params[index].varying = known.is_none() && reads[index].userdata && request.parts.len() == 1;
        let local = shader.params[index].local;
        if connected[index] || shader.locals[local.0 as usize].ty == Ty::Closure {
            continue;
        }
        if reads[index].interactive && request.interactive {
            interactive(shader, index);
        }
        if reads[index].userdata
            && let Some(data) = supplied(shader, index, known.unwrap_or_default())
        {
            userdata(shader, index, data);
        }
    }
}

/// The userdata of a parameter's name and type.
fn supplied<'a>(shader: &Shader, index: usize, all: &'a [Userdata]) -> Option<&'a Userdata> {
    let param = &shader.params[index];
    let len = shader.locals[param.local.0 as usize].len;
    all.iter().rev().find(|data| {
        let same = data.ty.base == param.declared.base || data.ty.base.is_triple() && param.declared.base.is_triple();
        let fits = match data.ty.extent {
            Extent::Scalar => len.is_none(),
            Extent::Fixed(n) => len == Some(n),
            Extent::Unsized => false,
        };
        data.name == param.name && same && fits
    })
}

fn userdata(shader: &mut Shader, index: usize, data: &Userdata) {
    let ty = shader.locals[shader.params[index].local.0 as usize].ty;
    let named = |g: &Global| data.same_as.as_deref() == Some(g.name()) && g.ty() == ty;
    if let Some(global) = Global::ALL.into_iter().find(named) {
        let from = global_local(shader, global);
        return replace(shader, index, from);
    }
    let value = input(shader, index, Source::Userdata, None);
    if data.sometimes {
        let has = input(shader, index, Source::HasUserdata, None);
        guarded(shader, index, has, value);
    } else {
        replace(shader, index, value);
    }
}

fn interactive(shader: &mut Shader, index: usize) {
    match constant_init(shader, index) {
        Some(default) => {
            let value = input(shader, index, Source::Interactive, Some(default));
            replace(shader, index, value);
        }
        // The default has to be computed; it counts until a value is set.
        None => {
            let value = input(shader, index, Source::Interactive, None);
            let has = input(shader, index, Source::HasInteractive, None);
            guarded(shader, index, has, value);
        }
    }
}

/// The local of a global.
fn global_local(shader: &mut Shader, global: Global) -> LocalId {
    let kind = LocalKind::Global(global);
    let found = shader.locals.iter().position(|l| l.kind == kind);
    let index = found.unwrap_or_else(|| {
        shader.locals.push(Local { name: global.name().to_owned(), ty: global.ty(), len: None, kind });
        shader.locals.len() - 1
    });
    LocalId(index as u32)
}

/// A new local that holds an input of the parameter's type, or the flag beside it.
fn input(shader: &mut Shader, index: usize, source: Source, default: Option<Const>) -> LocalId {
    let param = &shader.params[index];
    let local = &shader.locals[param.local.0 as usize];
    let flag = matches!(source, Source::HasUserdata | Source::HasInteractive);
    let (declared, ty, len) = if flag {
        (Type::scalar(Base::Int), Ty::Int, None)
    } else {
        let extent = local.len.map_or(Extent::Scalar, Extent::Fixed);
        (Type { base: param.declared.base, extent }, local.ty, local.len)
    };
    let name = param.name.clone();
    shader.inputs.push(Input { name: name.clone(), source, declared, ty, len, default });
    let kind = LocalKind::Input(shader.inputs.len() as u32 - 1);
    shader.locals.push(Local { name, ty, len, kind });
    LocalId(shader.locals.len() as u32 - 1)
}

fn load(shader: &mut Shader, block: &mut Block, local: LocalId, span: Span) -> ValueId {
    let ty = shader.locals[local.0 as usize].ty;
    shader.emit(Inst::Load(local), ty, span, block)
}

/// Sets the parameter to an input.
fn set(shader: &mut Shader, block: &mut Block, index: usize, from: LocalId) {
    let (to, span) = (shader.params[index].local, shader.params[index].span);
    if shader.locals[to.0 as usize].len.is_some() {
        block.stmts.push(Stmt::CopyArray(to, from));
    } else {
        let value = load(shader, block, from, span);
        block.stmts.push(Stmt::Store(to, value));
    }
}

/// The parameter is the input, whatever its default.
fn replace(shader: &mut Shader, index: usize, from: LocalId) {
    let mut init = Block::default();
    if super::writes_others(shader, index) {
        init = std::mem::take(&mut shader.params[index].init);
    }
    set(shader, &mut init, index, from);
    shader.params[index].init = init;
}

/// The parameter is the input where the flag is set.
fn guarded(shader: &mut Shader, index: usize, flag: LocalId, from: LocalId) {
    let mut init = std::mem::take(&mut shader.params[index].init);
    let span = shader.params[index].span;
    let has = load(shader, &mut init, flag, span);
    let mut then = Block::default();
    set(shader, &mut then, index, from);
    init.stmts.push(Stmt::If(has, then, Block::default()));
    shader.params[index].init = init;
}

/// What a parameter's init stores when that needs nothing but constants.
fn constant_init(shader: &Shader, index: usize) -> Option<Const> {
    let param = &shader.params[index];
    let local = &shader.locals[param.local.0 as usize];
    let zero = ops::zero(local.ty)?;
    let mut result = local.len.map_or(zero.clone(), |n| Const::Array(vec![zero; n as usize]));
    let mut known: HashMap<ValueId, Const> = HashMap::new();
    for stmt in &param.init.stmts {
        match stmt {
            Stmt::Let(id) => {
                if let Some(c) = constant_value(shader, *id, &known) {
                    known.insert(*id, c);
                }
            }
            Stmt::Store(l, v) if *l == param.local => result = known.get(v)?.clone(),
            Stmt::StoreElem(l, i, v) if *l == param.local => {
                let (Const::Array(items), Const::Int(i)) = (&mut result, known.get(i)?) else { return None };
                let at = ops::clamp(*i, items.len());
                items[at] = known.get(v)?.clone();
            }
            _ => return None,
        }
    }
    Some(result)
}

fn constant_value(shader: &Shader, id: ValueId, known: &HashMap<ValueId, Const>) -> Option<Const> {
    let value = &shader.values[id.0 as usize];
    if let Inst::Const(c) = &value.inst {
        return Some(c.clone());
    }
    if let Inst::Load(_) | Inst::LoadElem(..) = value.inst {
        return None;
    }
    let mut args = Vec::new();
    value.inst.operands(&mut |v| args.push(known.get(&v).cloned()));
    let args = args.into_iter().collect::<Option<Vec<Const>>>()?;
    match &value.inst {
        Inst::Call(func, list) if list.len() == args.len() => interp::fold_call(*func, value.ty, &args),
        Inst::Call(..) => None,
        inst => ops::evaluate(inst, value.ty, &args),
    }
}
