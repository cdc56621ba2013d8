//! Checks at run time that variables are assigned before they are read, for those who ask for them: in the reference
//! implementation's words, but for the number of its operation.
//!
//! In: a lowered shader, and the variables that were declared without a value. Out: the same with a shadow for each that tells
//! which components are assigned, and statements that report. Arrays that functions take as a whole are not looked into.

use super::Lower;
use super::place::Storage;
use crate::builtins;
use crate::ir::{Arg, BinaryOp, Block, Const, Inst, LocalId, Rewriter, Shader, Stmt, Ty, UnaryOp, ValueId};
use crate::messages::{GROUP, LAYER, PLACE, code};
use crate::source::Span;
use crate::types::{Base, Type};
use std::collections::{HashMap, HashSet};

/// A variable that starts without a value: its type and name in OSL's words.
pub(super) type Unassigned = (LocalId, String);

impl Lower<'_> {
    /// A variable is declared without a value.
    pub(super) fn declared_without_value(&mut self, name: &str, ty: Type, storage: &Storage) {
        // Compiled shaders have variables of the compiler's own, too.
        if !self.settings.unassigned_checks || name.starts_with('$') {
            return;
        }
        match (storage, ty.base) {
            (Storage::Local(local), base) => {
                let len = self.out.locals[local.0 as usize].len.map_or(String::new(), |n| format!("[{n}]"));
                self.unassigned.push((*local, format!("{}{len} {name}", base.keyword())));
            }
            (Storage::Struct(fields), Base::Struct(id)) => {
                let types = self.tree.structure(id).fields.clone();
                for (field, (field_name, ty)) in fields.iter().zip(types) {
                    self.declared_without_value(&format!("{name}.{field_name}"), ty, field);
                }
            }
            _ => {}
        }
    }
}

/// Puts the checks in.
pub(super) fn check(shader: &mut Shader, unassigned: Vec<Unassigned>) {
    let mut watched = HashMap::new();
    for (local, what) in unassigned {
        let declared = shader.locals[local.0 as usize].clone();
        let parts = match declared.ty {
            Ty::Closure => continue,
            Ty::Triple => 3,
            Ty::Matrix => 16,
            _ => 1,
        };
        let shadow = shader.add_variable(format!("{}_assigned", declared.name), Ty::Int, declared.len);
        watched.insert(local, Watch { shadow, all: (1 << parts) - 1, what, len: declared.len });
    }
    if watched.is_empty() {
        return;
    }
    let by_parts = read_by_parts(shader);
    Checks { shader, watched, by_parts }.rewrite();
}

/// Loads of which nothing but components is taken, or replaced.
fn read_by_parts(shader: &Shader) -> HashSet<ValueId> {
    let loads = |v: ValueId| matches!(shader.values[v.0 as usize].inst, Inst::Load(_) | Inst::LoadElem(..));
    let (mut parts, mut whole) = (HashSet::new(), HashSet::new());
    for value in &shader.values {
        let base = match &value.inst {
            Inst::Component(v, _)
            | Inst::MatrixElement(v, ..)
            | Inst::WithComponent(v, ..)
            | Inst::WithMatrixElement(v, ..) => Some(*v).filter(|v| loads(*v)),
            _ => None,
        };
        parts.extend(base);
        value.inst.operands(&mut |v| {
            if Some(v) != base {
                whole.insert(v);
            }
        });
    }
    for block in shader.blocks() {
        block.walk(&mut |s| match s {
            Stmt::Store(_, v) | Stmt::If(v, ..) => _ = whole.insert(*v),
            Stmt::StoreElem(_, i, v) => whole.extend([*i, *v]),
            Stmt::Loop(l) => _ = whole.insert(l.cond),
            Stmt::Call { args, .. } => whole.extend(args.iter().filter_map(|a| match a {
                Arg::Value(v) => Some(*v),
                Arg::Array(_) => None,
            })),
            _ => {}
        });
    }
    parts.difference(&whole).copied().collect()
}

/// What is known of a variable.
#[derive(Clone)]
struct Watch {
    /// A bit per component; of an array an int per element.
    shadow: LocalId,
    all: i32,
    what: String,
    len: Option<u32>,
}

struct Checks<'a> {
    shader: &'a mut Shader,
    watched: HashMap<LocalId, Watch>,
    by_parts: HashSet<ValueId>,
}

impl Rewriter for Checks<'_> {
    fn shader(&mut self) -> &mut Shader {
        self.shader
    }

    fn stmt(&mut self, stmt: Stmt, out: &mut Block) {
        match &stmt {
            Stmt::Let(id) => self.read(*id, out),
            Stmt::Store(local, value) => self.wrote(*local, None, *value, out),
            Stmt::StoreElem(local, index, value) => self.wrote(*local, Some(*index), *value, out),
            Stmt::CopyArray(to, from) => {
                let from = self.watched.get(from).map(|w| (w.shadow, w.len));
                if let Some(to) = self.watched.get(to).cloned() {
                    match from {
                        Some((shadow, len)) if len == to.len => out.stmts.push(Stmt::CopyArray(to.shadow, shadow)),
                        _ => self.fill(&to, out),
                    }
                }
            }
            Stmt::Call { outputs, result, .. } => {
                for local in outputs.iter().chain(result) {
                    if let Some(watch) = self.watched.get(local).cloned() {
                        self.fill(&watch, out);
                    }
                }
            }
            _ => {}
        }
        out.stmts.push(stmt);
    }
}

impl Checks<'_> {
    fn inst(&self, v: ValueId) -> &Inst {
        &self.shader.values[v.0 as usize].inst
    }

    /// The variable and the index of a load.
    fn loaded(&self, v: ValueId) -> Option<(Watch, Option<ValueId>)> {
        let (local, index) = match self.inst(v) {
            Inst::Load(local) => (local, None),
            Inst::LoadElem(local, index) => (local, Some(*index)),
            _ => return None,
        };
        Some((self.watched.get(local)?.clone(), index))
    }

    /// An index as it is used: one beyond the ends is the last.
    fn within(&mut self, index: ValueId, last: i32, span: Span, out: &mut Block) -> ValueId {
        let [low, high] = [0, last].map(|end| self.shader.emit_constant(Const::Int(end), span, out));
        let beyond = self.shader.emit(Inst::Binary(BinaryOp::Gt, index, high), Ty::Int, span, out);
        let index = self.shader.emit(Inst::Select(beyond, high, index), Ty::Int, span, out);
        let before = self.shader.emit(Inst::Binary(BinaryOp::Lt, index, low), Ty::Int, span, out);
        self.shader.emit(Inst::Select(before, low, index), Ty::Int, span, out)
    }

    /// The bit of a component.
    fn bit(&mut self, place: &[ValueId], span: Span, out: &mut Block) -> ValueId {
        let last = if place.len() == 2 { 3 } else { 2 };
        let place: Vec<ValueId> = place.iter().map(|i| self.within(*i, last, span, out)).collect();
        let mut at = place[0];
        if let [row, column] = place[..] {
            let four = self.shader.emit_constant(Const::Int(4), span, out);
            let first = self.shader.emit(Inst::Binary(BinaryOp::Mul, row, four), Ty::Int, span, out);
            at = self.shader.emit(Inst::Binary(BinaryOp::Add, first, column), Ty::Int, span, out);
        }
        let one = self.shader.emit_constant(Const::Int(1), span, out);
        self.shader.emit(Inst::Binary(BinaryOp::Shl, one, at), Ty::Int, span, out)
    }

    fn shadow(&mut self, watch: &Watch, index: Option<ValueId>, span: Span, out: &mut Block) -> ValueId {
        let inst = match index {
            None => Inst::Load(watch.shadow),
            Some(index) => Inst::LoadElem(watch.shadow, index),
        };
        self.shader.emit(inst, Ty::Int, span, out)
    }

    fn read(&mut self, id: ValueId, out: &mut Block) {
        let span = self.shader.values[id.0 as usize].span;
        let (from, place) = match self.inst(id) {
            Inst::Load(_) | Inst::LoadElem(..) if !self.by_parts.contains(&id) => (id, Vec::new()),
            Inst::Component(v, index) if self.by_parts.contains(v) => (*v, vec![*index]),
            Inst::MatrixElement(v, row, column) if self.by_parts.contains(v) => (*v, vec![*row, *column]),
            _ => return,
        };
        let Some((watch, index)) = self.loaded(from) else { return };
        let wanted = match place.as_slice() {
            [] => self.shader.emit_constant(Const::Int(watch.all), span, out),
            place => self.bit(place, span, out),
        };
        let now = self.shadow(&watch, index, span, out);
        let there = self.shader.emit(Inst::Binary(BinaryOp::BitAnd, now, wanted), Ty::Int, span, out);
        let whole = self.shader.emit(Inst::Binary(BinaryOp::Eq, there, wanted), Ty::Int, span, out);
        let missing = self.shader.emit(Inst::Unary(UnaryOp::Not, whole), Ty::Int, span, out);
        let mut then = Block::default();
        self.report(&watch, span, &mut then);
        out.stmts.push(Stmt::If(missing, then, Block::default()));
    }

    fn report(&mut self, watch: &Watch, span: Span, out: &mut Block) {
        let Some(func) = builtins::find("print") else { return };
        // Names are no formats.
        let [what, name] = [&watch.what, &self.shader.name].map(|t| t.replace('%', "%%"));
        let format = format!(
            "Detected possible use of uninitialized value in {what} at {PLACE} (group {GROUP}, layer {LAYER}, shader {name})"
        );
        let code = self.shader.emit_constant(Const::Int(code::ERROR), span, out);
        let [owner, format] = [String::new(), format].map(|t| self.shader.emit_constant(Const::Str(t), span, out));
        let args = [code, owner, format].map(Arg::Value).to_vec();
        out.stmts.push(Stmt::Call { func, args, outputs: Vec::new(), result: None, span });
    }

    fn wrote(&mut self, local: LocalId, index: Option<ValueId>, value: ValueId, out: &mut Block) {
        let Some(watch) = self.watched.get(&local).cloned() else { return };
        let span = self.shader.values[value.0 as usize].span;
        let place = match self.inst(value) {
            Inst::WithComponent(v, at, _) if self.by_parts.contains(v) => Some((*v, vec![*at])),
            Inst::WithMatrixElement(v, row, column, _) if self.by_parts.contains(v) => Some((*v, vec![*row, *column])),
            _ => None,
        };
        let mut mask = self.shader.emit_constant(Const::Int(watch.all), span, out);
        if let Some((from, place)) = place
            && self.loaded(from).is_some_and(|(w, _)| w.shadow == watch.shadow)
        {
            let bit = self.bit(&place, span, out);
            let now = self.shadow(&watch, index, span, out);
            mask = self.shader.emit(Inst::Binary(BinaryOp::BitOr, now, bit), Ty::Int, span, out);
        }
        out.stmts.push(match index {
            None => Stmt::Store(watch.shadow, mask),
            Some(index) => Stmt::StoreElem(watch.shadow, index, mask),
        });
    }

    /// All of it is assigned.
    fn fill(&mut self, watch: &Watch, out: &mut Block) {
        let span = Span { file: crate::source::FileId(0), start: 0, end: 0 };
        let all = self.shader.emit_constant(Const::Int(watch.all), span, out);
        match watch.len {
            None => out.stmts.push(Stmt::Store(watch.shadow, all)),
            Some(len) => {
                for i in 0..len as i32 {
                    let index = self.shader.emit_constant(Const::Int(i), span, out);
                    out.stmts.push(Stmt::StoreElem(watch.shadow, index, all));
                }
            }
        }
    }
}
