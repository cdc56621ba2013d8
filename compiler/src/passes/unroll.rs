//! Unrolls loops that make closures: a lobe slot is one call site, so each turn needs its own. And short ones that make
//! texts of what they change: texts are made at compile time.
//!
//! Part of `fold`, which knows after each turn whether there is another. Where only the device knows, because of the condition or
//! of a jump, the turns that follow stand in a branch. A loop with closures whose number of turns has no bound that is known is a
//! diagnostic; one with texts stays a loop.

use super::fold::Folder;
use super::numbers::Numbers;
use crate::builtins::{self, Lowering};
use crate::diag::Diagnostic;
use crate::interp::ops;
use crate::ir::{Arg, Block, Const, Inst, LocalId, Loop, Shader, Stmt, Ty, UnaryOp, ValueId};
use crate::source::Span;
use std::collections::{HashMap, HashSet};

/// Most turns of an unrolled loop.
const MAX_TURNS: usize = 256;

/// Most branches around a turn: drivers' compilers nest no deeper than 256.
const MAX_BRANCHES: usize = 100;

/// Most values that unrolling may grow a shader to: loops inside each other multiply.
const MAX_VALUES: usize = 2_000_000;

/// Most values that unrolling a loop for its texts may add.
const MAX_TEXT_VALUES: usize = 4096;

/// Whether a closure is made inside. Loops that only load and add closures made before are fine.
pub(super) fn holds_closures(shader: &Shader, l: &Loop) -> bool {
    closure_call(shader, l).is_some()
}

fn closure_call(shader: &Shader, l: &Loop) -> Option<Span> {
    let mut found = None;
    for block in [&l.head, &l.body, &l.step] {
        block.walk(&mut |s| {
            if let Stmt::Let(id) = s {
                let value = &shader.values[id.0 as usize];
                if matches!(value.inst, Inst::Closure(..)) {
                    found.get_or_insert(value.span);
                }
            }
        });
    }
    found
}

/// What only the host answers without looking into a text.
const QUESTIONS: [&str; 4] = ["unknown_name", "is_constant", "is_connected", "array_length"];

/// Whether it holds a call that only the host can carry out, on something that the loop changes.
pub(super) fn makes_texts(shader: &Shader, l: &Loop) -> bool {
    let is_host = |func| {
        let row = builtins::row(func);
        matches!(row.lowering, Lowering::Host | Lowering::InternalHost) && !QUESTIONS.contains(&row.name)
    };
    let mut changed = HashSet::new();
    let mut varies = HashSet::new();
    let blocks = [&l.head, &l.body, &l.step];
    blocks.iter().for_each(|b| b.walk(&mut |s| s.written(&mut |local| _ = changed.insert(local))));
    let mut found = false;
    let of = |arg: &Arg, varies: &HashSet<ValueId>| match arg {
        Arg::Value(v) => varies.contains(v),
        Arg::Array(l) => changed.contains(l),
    };
    // Values have smaller operands, but a do-while has its head after its body: once more for what it missed.
    for _ in 0..2 {
        for block in blocks {
            block.walk(&mut |s| match s {
                Stmt::Let(id) => {
                    let inst = &shader.values[id.0 as usize].inst;
                    let mut touched = false;
                    inst.operands(&mut |v| touched |= varies.contains(&v));
                    inst.locals(&mut |local| touched |= changed.contains(&local));
                    if touched {
                        varies.insert(*id);
                        found |= matches!(inst, Inst::Call(func, _) if is_host(*func));
                    }
                }
                Stmt::Call { func, args, .. } if is_host(*func) => found |= args.iter().any(|a| of(a, &varies)),
                _ => {}
            });
        }
    }
    found
}

fn has_jump(block: &Block) -> bool {
    block.stmts.iter().any(|s| match s {
        Stmt::Break | Stmt::Continue => true,
        Stmt::If(_, a, b) => has_jump(a) || has_jump(b),
        _ => false,
    })
}

/// Why a loop cannot be unrolled.
enum Refusal {
    /// It would be too much.
    TooMany,
    /// The number of turns has no bound that is known.
    Unknown,
}

/// How a loop is unrolled.
#[derive(Clone, Copy)]
struct Way {
    /// Most values that the shader may have.
    limit: usize,
    /// Set by `break`, and by both jumps: the rest of the loop, and of the turn, is left out.
    flags: Option<(LocalId, LocalId)>,
    /// Whether turns may stand in branches, where only the device knows whether they come.
    branches: bool,
    span: Span,
}

impl Folder<'_> {
    /// Unrolls a loop with closures; where that cannot be, it is an error.
    pub(super) fn unroll(&mut self, l: &Loop, out: &mut Block) {
        if let Err(why) = self.turns(l, MAX_VALUES, true, out) {
            let span = closure_call(self.shader, l);
            self.refuse(span, matches!(why, Refusal::TooMany));
        }
    }

    /// Unrolls a loop with texts; whether that could be.
    pub(super) fn unroll_if_short(&mut self, l: &Loop, out: &mut Block) -> bool {
        let (values, stmts, errors) = (self.shader.values.len(), out.stmts.len(), self.errors.len());
        let state = self.state.clone();
        let limit = MAX_VALUES.min(values + MAX_TEXT_VALUES);
        let done = !has_jump(&l.body) && self.turns(l, limit, false, out).is_ok();
        if done && self.errors.len() == errors && self.shader.values.len() <= limit {
            return true;
        }
        self.shader.values.truncate(values);
        self.same.truncate(values);
        out.stmts.truncate(stmts);
        self.errors.truncate(errors);
        self.state = state;
        false
    }

    fn turns(&mut self, l: &Loop, limit: usize, branches: bool, out: &mut Block) -> Result<(), Refusal> {
        let span = self.shader.values[l.cond.0 as usize].span;
        let flags =
            has_jump(&l.body).then(|| ["left", "skipped"].map(|n| self.shader.add_variable(n.into(), Ty::Int, None)));
        let flags = flags.map(|[left, skipped]| (left, skipped));
        if let Some((left, _)) = flags {
            self.set_flag(left, 0, span, out);
        }
        self.turn(l, 0, 0, &Way { limit, flags, branches, span }, out)
    }

    /// The turns from this one on. `depth`: branches around it.
    fn turn(&mut self, l: &Loop, first: usize, depth: usize, way: &Way, out: &mut Block) -> Result<(), Refusal> {
        let mut turn = first;
        loop {
            if self.shader.values.len() > way.limit || turn > MAX_TURNS {
                return Err(Refusal::TooMany);
            }
            if !(l.tested_after && turn == 0) {
                let mut map = HashMap::new();
                let head = self.copy(&l.head, &mut map);
                self.stmts(head, out);
                let cond = self.resolve(map.get(&l.cond).copied().unwrap_or(l.cond));
                match self.truth(cond) {
                    Some(false) => return Ok(()),
                    Some(true) if turn < MAX_TURNS => {}
                    Some(true) => return Err(Refusal::TooMany),
                    None => {
                        return self.branch(cond, depth, way, out, |this, depth, then| {
                            if this.body(l, depth, turn, way, then)? {
                                Ok(())
                            } else {
                                this.turn(l, turn + 1, depth, way, then)
                            }
                        });
                    }
                }
            }
            if self.body(l, depth, turn, way, out)? {
                return Ok(());
            }
            turn += 1;
        }
    }

    /// The body of a turn and the step after it; whether that was all: what follows stands in a branch, or never comes.
    fn body(&mut self, l: &Loop, depth: usize, turn: usize, way: &Way, out: &mut Block) -> Result<bool, Refusal> {
        let mut map = HashMap::new();
        let mut body = self.copy(&l.body, &mut map);
        if let Some((left, skipped)) = way.flags {
            self.set_flag(skipped, 0, way.span, out);
            body = self.without_jumps(body, left, skipped, way.span);
        }
        self.stmts(body, out);
        if let Some((left, _)) = way.flags {
            let left = self.fresh(Inst::Load(left), way.span, out);
            match self.const_of(left).map(ops::is_true) {
                Some(true) => return Ok(true),
                Some(false) => {}
                None => {
                    let stays = self.fresh(Inst::Unary(UnaryOp::Not, left), way.span, out);
                    self.branch(stays, depth, way, out, |this, depth, then| {
                        this.step(l, then);
                        this.turn(l, turn + 1, depth, way, then)
                    })?;
                    return Ok(true);
                }
            }
        }
        self.step(l, out);
        Ok(false)
    }

    fn step(&mut self, l: &Loop, out: &mut Block) {
        let mut map = HashMap::new();
        let step = self.copy(&l.step, &mut map);
        self.stmts(step, out);
    }

    /// What stands in a branch.
    fn branch(
        &mut self,
        cond: ValueId,
        depth: usize,
        way: &Way,
        out: &mut Block,
        fill: impl FnOnce(&mut Self, usize, &mut Block) -> Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        if !way.branches || depth == MAX_BRANCHES {
            return Err(Refusal::Unknown);
        }
        self.state.enter();
        let mut then = Block::default();
        let done = fill(self, depth + 1, &mut then);
        let after = self.state.leave();
        self.state.meet(&[after, HashMap::new()]);
        out.stmts.push(Stmt::If(cond, then, Block::default()));
        done
    }

    /// Whether a condition holds, if that is known.
    fn truth(&self, cond: ValueId) -> Option<bool> {
        if let Some(c) = self.const_of(cond) {
            return Some(ops::is_true(c));
        }
        let can = Numbers::of_values().few(self.shader, cond)?;
        match (can.contains(&0), can.iter().any(|i| *i != 0)) {
            (true, false) => Some(false),
            (false, true) => Some(true),
            _ => None,
        }
    }

    fn fresh(&mut self, inst: Inst, span: Span, out: &mut Block) -> ValueId {
        let mut made = Block::default();
        let id = self.shader.emit(inst, Ty::Int, span, &mut made);
        self.same.push(id);
        self.stmts(made, out);
        self.resolve(id)
    }

    fn set_flag(&mut self, flag: LocalId, value: i32, span: Span, out: &mut Block) {
        let mut made = Block::default();
        self.flag(flag, value, span, &mut made);
        self.stmts(made, out);
    }

    fn flag(&mut self, flag: LocalId, value: i32, span: Span, out: &mut Block) {
        let value = self.shader.emit_constant(Const::Int(value), span, out);
        self.same.push(value);
        out.stmts.push(Stmt::Store(flag, value));
    }

    /// A body with flags in the place of jumps, not folded.
    fn without_jumps(&mut self, block: Block, left: LocalId, skipped: LocalId, span: Span) -> Block {
        let mut out = Block::default();
        let mut stmts = block.stmts.into_iter();
        while let Some(stmt) = stmts.next() {
            match stmt {
                Stmt::Break => {
                    self.flag(left, 1, span, &mut out);
                    self.flag(skipped, 1, span, &mut out);
                    return out;
                }
                Stmt::Continue => {
                    self.flag(skipped, 1, span, &mut out);
                    return out;
                }
                Stmt::If(cond, a, b) if has_jump(&a) || has_jump(&b) => {
                    let a = self.without_jumps(a, left, skipped, span);
                    let b = self.without_jumps(b, left, skipped, span);
                    out.stmts.push(Stmt::If(cond, a, b));
                    let rest = self.without_jumps(Block { stmts: stmts.collect() }, left, skipped, span);
                    if !rest.stmts.is_empty() {
                        let now = self.shader.emit(Inst::Load(skipped), Ty::Int, span, &mut out);
                        self.same.push(now);
                        let on = self.shader.emit(Inst::Unary(UnaryOp::Not, now), Ty::Int, span, &mut out);
                        self.same.push(on);
                        out.stmts.push(Stmt::If(on, rest, Block::default()));
                    }
                    return out;
                }
                other => out.stmts.push(other),
            }
        }
        out
    }

    fn refuse(&mut self, span: Option<Span>, too_many: bool) {
        let span = span.unwrap_or(Span { file: crate::source::FileId(0), start: 0, end: 0 });
        let what = if too_many {
            format!("a closure call inside a loop of more than {MAX_TURNS} turns")
        } else {
            "a closure call inside a loop whose number of turns has no bound that is known at compile time".to_string()
        };
        let d = Diagnostic::not_yet("E4003", span, what);
        if !self.errors.contains(&d) {
            self.errors.push(
                d.help("bound it, as in `i < min(n, 8)`, or sum the weights in the loop and call the closure after it"),
            );
        }
    }

    /// A copy with values of its own.
    fn copy(&mut self, block: &Block, map: &mut HashMap<ValueId, ValueId>) -> Block {
        let get = |map: &HashMap<ValueId, ValueId>, v: ValueId| map.get(&v).copied().unwrap_or(v);
        let mut out = Block::default();
        for stmt in &block.stmts {
            let copied = match stmt {
                Stmt::Let(id) => {
                    let mut value = self.shader.values[id.0 as usize].clone();
                    value.inst.operands_mut(&mut |v| *v = get(map, *v));
                    let new = ValueId(self.shader.values.len() as u32);
                    self.shader.values.push(value);
                    self.same.push(new);
                    map.insert(*id, new);
                    Stmt::Let(new)
                }
                Stmt::Store(l, v) => Stmt::Store(*l, get(map, *v)),
                Stmt::StoreElem(l, i, v) => Stmt::StoreElem(*l, get(map, *i), get(map, *v)),
                Stmt::Call { func, args, outputs, result, span } => {
                    let mut args = args.clone();
                    for arg in &mut args {
                        if let Arg::Value(v) = arg {
                            *v = get(map, *v);
                        }
                    }
                    Stmt::Call { func: *func, args, outputs: outputs.clone(), result: *result, span: *span }
                }
                Stmt::If(c, a, b) => {
                    let cond = get(map, *c);
                    let a = self.copy(a, map);
                    let b = self.copy(b, map);
                    Stmt::If(cond, a, b)
                }
                Stmt::Loop(l) => {
                    // In order of execution, so that operands are mapped before their uses.
                    let (head, body) = if l.tested_after {
                        let body = self.copy(&l.body, map);
                        (self.copy(&l.head, map), body)
                    } else {
                        (self.copy(&l.head, map), self.copy(&l.body, map))
                    };
                    let step = self.copy(&l.step, map);
                    Stmt::Loop(Box::new(Loop {
                        head,
                        cond: get(map, l.cond),
                        tested_after: l.tested_after,
                        body,
                        step,
                    }))
                }
                other => other.clone(),
            };
            out.stmts.push(copied);
        }
        out
    }
}
