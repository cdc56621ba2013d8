//! Unrolls loops that make closures: a lobe slot is one call site, so each turn needs its own. And short ones that make
//! texts of what they change: texts are made at compile time.
//!
//! Part of `fold`, which knows after each turn whether there is another. A loop with closures whose number of turns does not
//! fold to a constant, or that jumps out on a condition only the device knows, is a diagnostic; one with texts stays a loop.

use super::fold::Folder;
use crate::builtins::{self, Lowering};
use crate::diag::Diagnostic;
use crate::interp::ops;
use crate::ir::{Arg, Block, Inst, Loop, Shader, Stmt, ValueId};
use crate::source::Span;
use std::collections::{HashMap, HashSet};

/// Most turns of an unrolled loop.
const MAX_TURNS: usize = 256;

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

/// Whether it holds a call that only the host can carry out, on something that the loop changes.
pub(super) fn makes_texts(shader: &Shader, l: &Loop) -> bool {
    let is_host = |func| builtins::row(func).lowering == Lowering::Host;
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
    /// The number of turns is not known.
    Unknown,
}

impl Folder<'_> {
    /// Unrolls a loop with closures; where that cannot be, it is an error.
    pub(super) fn unroll(&mut self, l: &Loop, out: &mut Block) {
        if let Err(why) = self.turns(l, MAX_VALUES, out) {
            let span = closure_call(self.shader, l);
            self.refuse(span, matches!(why, Refusal::TooMany));
        }
    }

    /// Unrolls a loop with texts; whether that could be.
    pub(super) fn unroll_if_short(&mut self, l: &Loop, out: &mut Block) -> bool {
        let (values, stmts, errors) = (self.shader.values.len(), out.stmts.len(), self.errors.len());
        let state = self.state.clone();
        let limit = MAX_VALUES.min(values + MAX_TEXT_VALUES);
        if self.turns(l, limit, out).is_ok() && self.errors.len() == errors && self.shader.values.len() <= limit {
            return true;
        }
        self.shader.values.truncate(values);
        self.same.truncate(values);
        out.stmts.truncate(stmts);
        self.errors.truncate(errors);
        self.state = state;
        false
    }

    fn turns(&mut self, l: &Loop, limit: usize, out: &mut Block) -> Result<(), Refusal> {
        for turn in 0..=MAX_TURNS {
            if self.shader.values.len() > limit {
                return Err(Refusal::TooMany);
            }
            if !(l.tested_after && turn == 0) {
                let mut map = HashMap::new();
                let head = self.copy(&l.head, &mut map);
                self.stmts(head, out);
                let cond = map.get(&l.cond).copied().unwrap_or(l.cond);
                match self.const_of(cond).map(ops::is_true) {
                    Some(false) => return Ok(()),
                    Some(true) if turn < MAX_TURNS => {}
                    Some(true) => return Err(Refusal::TooMany),
                    None => return Err(Refusal::Unknown),
                }
            }
            let mut map = HashMap::new();
            let body = self.copy(&l.body, &mut map);
            let mut folded = self.block(body);
            match folded.stmts.last() {
                Some(Stmt::Break) => {
                    folded.stmts.pop();
                    if has_jump(&folded) {
                        return Err(Refusal::Unknown);
                    }
                    out.stmts.append(&mut folded.stmts);
                    return Ok(());
                }
                Some(Stmt::Continue) => {
                    folded.stmts.pop();
                }
                _ => {}
            }
            if has_jump(&folded) {
                return Err(Refusal::Unknown);
            }
            out.stmts.append(&mut folded.stmts);
            let mut map = HashMap::new();
            let step = self.copy(&l.step, &mut map);
            self.stmts(step, out);
        }
        Err(Refusal::TooMany)
    }

    fn refuse(&mut self, span: Option<Span>, too_many: bool) {
        let span = span.unwrap_or(Span { file: crate::source::FileId(0), start: 0, end: 0 });
        let what = if too_many {
            format!("a closure call inside a loop of more than {MAX_TURNS} turns")
        } else {
            "a closure call inside a loop whose number of turns is not known at compile time".to_string()
        };
        let d = Diagnostic::not_yet("E4003", span, what);
        if !self.errors.contains(&d) {
            self.errors.push(d.help("sum the weights in the loop and call the closure after it"));
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
