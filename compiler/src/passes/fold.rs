//! Constant folding: through values, through locals along the flow of control, and of branches.
//!
//! One walk in order of execution carries what is known of each local: a constant, the value last stored, or the
//! constant elements of an array. Where branches meet, what both agree on stays; what a loop writes is forgotten before it.
//! Identities stand in [`identity`]; a closure scaled by the constant 0 is the null closure.

mod identity;

use super::unroll;
use crate::builtins;
use crate::diag::Diagnostic;
use crate::interp::{self, ops};
use crate::ir::{
    Arg, BinaryOp, Block, Const, Inst, LocalId, LocalKind, Loop, Shader, SlotArg, Stmt, Ty, UnaryOp, ValueId,
};
use crate::source::Span;
use std::collections::HashMap;

/// Folds the whole shader.
pub fn fold(shader: &mut Shader) -> Result<(), Vec<Diagnostic>> {
    fold_with(shader, false)
}

/// As [`fold`]; with `texts` short loops that make texts are unrolled.
pub(super) fn fold_with(shader: &mut Shader, texts: bool) -> Result<(), Vec<Diagnostic>> {
    let same: Vec<ValueId> = (0..shader.values.len() as u32).map(ValueId).collect();
    let mut folder = Folder { shader, same, state: State::default(), errors: Vec::new(), texts };
    folder.run();
    if folder.errors.is_empty() { Ok(()) } else { Err(folder.errors) }
}

/// What is known of a local that holds a single value.
#[derive(Clone, PartialEq)]
pub(super) enum Known {
    Const(Const),
    /// It equals this value, which is visible wherever the knowledge is.
    Value(ValueId),
}

/// What is known of one local; both `None`: nothing.
pub(super) type Facts = (Option<Known>, Option<Vec<Option<Const>>>);

/// What is known at a point. Branches are undone by what they changed, so that one costs what it does, not what is known.
#[derive(Clone, Default)]
pub(super) struct State {
    singles: HashMap<LocalId, Known>,
    arrays: HashMap<LocalId, Vec<Option<Const>>>,
    /// Per open branch: what was known, where it began, of the locals that it changed.
    branches: Vec<HashMap<LocalId, Facts>>,
}

impl State {
    fn facts(&self, local: LocalId) -> Facts {
        (self.singles.get(&local).cloned(), self.arrays.get(&local).cloned())
    }

    /// To be called before each change.
    fn note(&mut self, local: LocalId) {
        if self.branches.last().is_some_and(|b| !b.contains_key(&local)) {
            let facts = self.facts(local);
            if let Some(branch) = self.branches.last_mut() {
                branch.insert(local, facts);
            }
        }
    }

    fn set(&mut self, local: LocalId, known: Known) {
        self.note(local);
        self.singles.insert(local, known);
    }

    /// The elements of an array, to be changed.
    fn elements(&mut self, local: LocalId, len: usize) -> &mut Vec<Option<Const>> {
        self.note(local);
        self.arrays.entry(local).or_insert_with(|| vec![None; len])
    }

    fn forget(&mut self, local: LocalId) {
        self.note(local);
        self.singles.remove(&local);
        self.arrays.remove(&local);
    }

    pub(super) fn enter(&mut self) {
        self.branches.push(HashMap::new());
    }

    /// Ends a branch: what is known is as it was before; what it changed is the result.
    pub(super) fn leave(&mut self) -> HashMap<LocalId, Facts> {
        let mut changed = HashMap::new();
        for (local, (single, array)) in self.branches.pop().unwrap_or_default() {
            let after = (self.singles.remove(&local), self.arrays.remove(&local));
            if let Some(known) = single {
                self.singles.insert(local, known);
            }
            if let Some(elements) = array {
                self.arrays.insert(local, elements);
            }
            changed.insert(local, after);
        }
        changed
    }

    /// What holds after any of these ways here. A value that was known before is visible after; one made in a branch is
    /// not.
    pub(super) fn meet(&mut self, ways: &[HashMap<LocalId, Facts>]) {
        let mut changed: Vec<LocalId> = ways.iter().flat_map(|w| w.keys().copied()).collect();
        changed.sort_unstable();
        changed.dedup();
        for local in changed {
            let before = self.facts(local);
            let (mut single, mut array) = match ways.first().and_then(|w| w.get(&local)) {
                Some(facts) => facts.clone(),
                None => before.clone(),
            };
            for way in &ways[1..] {
                let other = way.get(&local).unwrap_or(&before);
                single = single.filter(|k| other.0.as_ref() == Some(k));
                array = array.filter(|a| other.1.as_ref() == Some(a));
            }
            let single = single.filter(|k| matches!(k, Known::Const(_)) || before.0.as_ref() == Some(k));
            self.forget(local);
            if let Some(known) = single {
                self.singles.insert(local, known);
            }
            if let Some(elements) = array {
                self.arrays.insert(local, elements);
            }
        }
    }
}

/// Longest array that is known to hold zeros at first.
const MAX_ZEROS: u32 = 1024;

/// Longest array whose elements are followed.
const MAX_ARRAY: u32 = 1 << 16;

pub(super) struct Folder<'a> {
    pub shader: &'a mut Shader,
    /// The value that each value is replaced by.
    pub same: Vec<ValueId>,
    pub state: State,
    pub errors: Vec<Diagnostic>,
    /// Whether loops are unrolled for the texts that they make.
    texts: bool,
}

impl Folder<'_> {
    fn run(&mut self) {
        // Variables hold zero until stored, and so does what the default of a parameter leaves out; globals come from outside.
        for (i, local) in self.shader.locals.iter().enumerate() {
            let held = match local.kind {
                LocalKind::Variable => true,
                LocalKind::Param(p) => self.shader.params.get(p as usize).is_some_and(|p| !p.varying),
                _ => false,
            };
            let Some(zero) = ops::zero(local.ty).filter(|_| held) else { continue };
            let id = LocalId(i as u32);
            match local.len {
                None => _ = self.state.singles.insert(id, Known::Const(zero)),
                Some(n) if n <= MAX_ZEROS => _ = self.state.arrays.insert(id, vec![Some(zero); n as usize]),
                Some(_) => {}
            }
        }
        for i in 0..self.shader.params.len() {
            let init = std::mem::take(&mut self.shader.params[i].init);
            self.shader.params[i].init = self.block(init);
            let param = &self.shader.params[i];
            if param.varying {
                let local = param.local;
                self.state.forget(local);
            } else if let Some(Known::Value(_)) = self.state.singles.get(&param.local) {
                // A value of the init block is not visible in the body.
                let local = param.local;
                self.state.forget(local);
            }
        }
        // Nothing but constants crosses from the inits to the body.
        self.state.singles.retain(|_, k| matches!(k, Known::Const(_)));
        let body = std::mem::take(&mut self.shader.body);
        self.shader.body = self.block(body);
        for slot in &mut self.shader.slots {
            for arg in &mut slot.args {
                if let SlotArg::Local(l) = arg
                    && let Some(Known::Const(c)) = self.state.singles.get(l)
                {
                    *arg = SlotArg::Const(c.clone());
                }
            }
        }
    }

    /// Folds a block; constant branches are spliced into it.
    pub(super) fn block(&mut self, block: Block) -> Block {
        let mut out = Block { stmts: Vec::with_capacity(block.stmts.len()) };
        self.stmts(block, &mut out);
        out
    }

    pub(super) fn stmts(&mut self, block: Block, out: &mut Block) {
        for stmt in block.stmts {
            let jumps = matches!(stmt, Stmt::Break | Stmt::Continue);
            self.stmt(stmt, out);
            // A spliced branch may have ended in a jump; nothing after it runs.
            if jumps || matches!(out.stmts.last(), Some(Stmt::Break | Stmt::Continue)) {
                return;
            }
        }
    }

    pub(super) fn resolve(&self, v: ValueId) -> ValueId {
        let mut v = v;
        while self.same[v.0 as usize] != v {
            v = self.same[v.0 as usize];
        }
        v
    }

    pub(super) fn const_of(&self, v: ValueId) -> Option<&Const> {
        match &self.shader.values[self.resolve(v).0 as usize].inst {
            Inst::Const(c) => Some(c),
            _ => None,
        }
    }

    fn stmt(&mut self, stmt: Stmt, out: &mut Block) {
        match stmt {
            Stmt::Let(id) => {
                self.inst(id);
                // What became another value needs no computing.
                if self.same[id.0 as usize] == id {
                    out.stmts.push(Stmt::Let(id));
                }
            }
            Stmt::Store(local, value) => {
                let value = self.resolve(value);
                let known = match self.const_of(value) {
                    Some(c) => Known::Const(c.clone()),
                    None => Known::Value(value),
                };
                self.state.set(local, known);
                out.stmts.push(Stmt::Store(local, value));
            }
            Stmt::StoreElem(local, index, value) => {
                let (index, value) = (self.resolve(index), self.resolve(value));
                self.store_element(local, index, value);
                out.stmts.push(Stmt::StoreElem(local, index, value));
            }
            Stmt::CopyArray(to, from) => {
                self.copy_array(to, from);
                out.stmts.push(Stmt::CopyArray(to, from));
            }
            Stmt::Call { func, mut args, outputs, result, span } => {
                for arg in &mut args {
                    if let Arg::Value(v) = arg {
                        *v = self.resolve(*v);
                    }
                }
                if let (Some(result), [output]) = (result, outputs.as_slice())
                    && self.fold_call(func, &args, *output, result, span, out)
                {
                    return;
                }
                outputs.iter().chain(&result).for_each(|l| self.state.forget(*l));
                out.stmts.push(Stmt::Call { func, args, outputs, result, span });
            }
            Stmt::If(cond, a, b) => self.if_(cond, a, b, out),
            Stmt::Loop(l) => self.loop_(*l, out),
            jump => out.stmts.push(jump),
        }
    }

    /// Carries out a call on constants that writes to an array and returns something.
    fn fold_call(
        &mut self,
        func: builtins::FuncId,
        args: &[Arg],
        output: LocalId,
        result: LocalId,
        span: Span,
        out: &mut Block,
    ) -> bool {
        let constant = |a: &Arg| match a {
            Arg::Value(v) => self.const_of(*v).cloned(),
            Arg::Array(_) => None,
        };
        let Some(args) = args.iter().map(constant).collect::<Option<Vec<_>>>() else { return false };
        let room = self.shader.locals[output.0 as usize].len.unwrap_or(0);
        let Some((elements, value)) = interp::fold_call_with_output(func, &args, room as usize) else { return false };
        for (i, element) in elements.into_iter().enumerate() {
            let [index, element] = [Const::Int(i as i32), element].map(|c| self.constant(c, span, out));
            self.store_element(output, index, element);
            out.stmts.push(Stmt::StoreElem(output, index, element));
        }
        let value = self.constant(value, span, out);
        self.stmt(Stmt::Store(result, value), out);
        true
    }

    fn constant(&mut self, c: Const, span: Span, out: &mut Block) -> ValueId {
        let id = self.shader.emit_constant(c, span, out);
        self.same.push(id);
        id
    }

    fn store_element(&mut self, local: LocalId, index: ValueId, value: ValueId) {
        let Some(len) = self.shader.locals[local.0 as usize].len.filter(|n| *n <= MAX_ARRAY) else { return };
        let value = self.const_of(value).cloned();
        match self.const_of(index) {
            Some(Const::Int(i)) => {
                let at = ops::clamp(*i, len as usize);
                self.state.elements(local, len as usize)[at] = value;
            }
            _ => self.state.forget(local),
        }
    }

    fn copy_array(&mut self, to: LocalId, from: LocalId) {
        let len = |l: LocalId, this: &Self| this.shader.locals[l.0 as usize].len.unwrap_or(0) as usize;
        let count = len(to, self).min(len(from, self));
        match self.state.arrays.get(&from).cloned() {
            Some(source) => {
                let size = len(to, self);
                self.state.elements(to, size)[..count].clone_from_slice(&source[..count]);
            }
            None => self.state.forget(to),
        }
    }

    fn if_(&mut self, cond: ValueId, a: Block, b: Block, out: &mut Block) {
        let cond = self.resolve(cond);
        if let Some(c) = self.const_of(cond) {
            let taken = if ops::is_true(c) { a } else { b };
            return self.stmts(taken, out);
        }
        self.state.enter();
        let a = self.block(a);
        let after_a = self.state.leave();
        self.state.enter();
        let b = self.block(b);
        let after_b = self.state.leave();
        // A branch that jumps away does not reach the meeting point.
        let leaves = |block: &Block| matches!(block.stmts.last(), Some(Stmt::Break | Stmt::Continue));
        match (leaves(&a), leaves(&b)) {
            (true, false) => self.state.meet(&[after_b]),
            (false, true) => self.state.meet(&[after_a]),
            _ => self.state.meet(&[after_a, after_b]),
        }
        match &self.shader.values[cond.0 as usize].inst {
            _ if a.stmts.is_empty() && b.stmts.is_empty() => {}
            // Turned round, it reads better.
            Inst::Unary(UnaryOp::Not, inner) if a.stmts.is_empty() => {
                out.stmts.push(Stmt::If(self.resolve(*inner), b, a));
            }
            _ => out.stmts.push(Stmt::If(cond, a, b)),
        }
    }

    fn loop_(&mut self, mut l: Loop, out: &mut Block) {
        if unroll::holds_closures(self.shader, &l) {
            return self.unroll(&l, out);
        }
        if self.texts && unroll::makes_texts(self.shader, &l) && self.unroll_if_short(&l, out) {
            return;
        }
        let mut written = Vec::new();
        for block in [&l.head, &l.body, &l.step] {
            block.walk(&mut |s| s.written(&mut |local| written.push(local)));
        }
        if !l.tested_after && self.never_runs(&l) {
            return self.stmts(l.head, out);
        }
        written.iter().for_each(|local| self.state.forget(*local));
        // `continue` may come from anywhere in the body: only what the loop never writes is sure in what follows it.
        self.state.enter();
        if l.tested_after {
            l.body = self.block(l.body);
            self.state.leave();
            self.state.enter();
            l.head = self.block(l.head);
            l.cond = self.resolve(l.cond);
        } else {
            l.head = self.block(l.head);
            l.cond = self.resolve(l.cond);
            l.body = self.block(l.body);
            self.state.leave();
            self.state.enter();
        }
        l.step = self.block(l.step);
        self.state.leave();
        out.stmts.push(Stmt::Loop(Box::new(l)));
    }

    /// Whether the condition is false at once: it is evaluated without rewriting anything.
    fn never_runs(&self, l: &Loop) -> bool {
        let plain = l.head.stmts.iter().all(|s| matches!(s, Stmt::Let(_)));
        plain && self.peek(l.cond, 32).is_some_and(|c| !ops::is_true(&c))
    }

    fn peek(&self, v: ValueId, depth: u32) -> Option<Const> {
        if depth == 0 {
            return None;
        }
        let value = &self.shader.values[self.resolve(v).0 as usize];
        match &value.inst {
            Inst::Load(l) => match self.state.singles.get(l)? {
                Known::Const(c) => Some(c.clone()),
                Known::Value(v) => self.const_of(*v).cloned(),
            },
            Inst::LoadElem(..) | Inst::Call(..) => None,
            inst => {
                let mut args = Vec::new();
                inst.operands(&mut |o| args.push(self.peek(o, depth - 1)));
                evaluate(inst, value.ty, &args.into_iter().collect::<Option<Vec<_>>>()?)
            }
        }
    }

    /// Folds the instruction of one value.
    fn inst(&mut self, id: ValueId) {
        let mut inst = self.shader.values[id.0 as usize].inst.clone();
        let ty = self.shader.values[id.0 as usize].ty;
        let same = &self.same;
        inst.operands_mut(&mut |v| {
            while same[v.0 as usize] != *v {
                *v = same[v.0 as usize];
            }
        });
        if let Some(simpler) = self.simplify(&inst, ty) {
            match simpler {
                Simpler::Const(c) => inst = Inst::Const(c),
                Simpler::Value(v) => self.same[id.0 as usize] = v,
                Simpler::Inst(i) => inst = i,
            }
        }
        self.shader.values[id.0 as usize].inst = inst;
    }

    fn simplify(&self, inst: &Inst, ty: Ty) -> Option<Simpler> {
        match inst {
            Inst::Const(_) => return None,
            Inst::Load(l) => {
                return Some(match self.state.singles.get(l)? {
                    Known::Const(c) => Simpler::Const(c.clone()),
                    Known::Value(v) => Simpler::Value(*v),
                });
            }
            Inst::LoadElem(l, i) => {
                let Some(Const::Int(i)) = self.const_of(*i) else { return None };
                let elements = self.state.arrays.get(l)?;
                return elements[ops::clamp(*i, elements.len())].clone().map(Simpler::Const);
            }
            _ => {}
        }
        let mut args = Vec::new();
        inst.operands(&mut |v| args.push(self.const_of(v).cloned()));
        let all = args.iter().cloned().collect::<Option<Vec<Const>>>();
        if let Some(all) = all.filter(|_| !matches!(inst, Inst::Call(..)))
            && let Some(c) = evaluate(inst, ty, &all)
        {
            return Some(Simpler::Const(c));
        }
        if let Inst::Call(func, list) = inst {
            if let Some(simpler) = self.mix(*func, list) {
                return Some(simpler);
            }
            let values = list.iter().map(|a| match a {
                Arg::Value(v) => self.const_of(*v).cloned(),
                Arg::Array(l) => {
                    self.state.arrays.get(l)?.iter().cloned().collect::<Option<Vec<_>>>().map(Const::Array)
                }
            });
            let values = values.collect::<Option<Vec<_>>>()?;
            return interp::fold_call(*func, ty, &values).map(Simpler::Const);
        }
        self.identity(inst, ty, &args)
    }
}

/// As [`ops::evaluate`]; but floats are compared as the device and the reference compare them, in 32 bits. What was computed
/// in two ways from constants is otherwise hardly ever equal.
fn evaluate(inst: &Inst, ty: Ty, args: &[Const]) -> Option<Const> {
    use BinaryOp::{Eq, Ge, Gt, Le, Lt, Ne};
    if !matches!(inst, Inst::Binary(Eq | Ne | Lt | Le | Gt | Ge, ..)) {
        return ops::evaluate(inst, ty, args);
    }
    let single = |x: f64| f64::from(x as f32);
    let args: Vec<Const> = args
        .iter()
        .map(|a| match a {
            Const::Float(x) => Const::Float(single(*x)),
            Const::Triple(v) => Const::Triple(v.map(single)),
            Const::Matrix(m) => Const::Matrix(m.map(single)),
            other => other.clone(),
        })
        .collect();
    ops::evaluate(inst, ty, &args)
}

/// What an instruction may be replaced by.
pub(super) enum Simpler {
    Const(Const),
    Value(ValueId),
    Inst(Inst),
}
