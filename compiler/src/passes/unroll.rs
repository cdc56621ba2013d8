//! Unrolls loops that make closures: a lobe slot is one call site, so each turn needs its own.
//!
//! Part of `fold`, which knows after each turn whether there is another. A loop whose number of turns does not fold to a
//! constant, or that jumps out on a condition only the device knows, is a diagnostic.

use super::fold::Folder;
use crate::diag::Diagnostic;
use crate::interp::ops;
use crate::ir::{Block, Inst, Loop, Shader, Stmt, ValueId};
use crate::source::Span;
use std::collections::HashMap;

/// Most turns of an unrolled loop.
const MAX_TURNS: usize = 256;

/// Most values that unrolling may grow a shader to: loops inside each other multiply.
const MAX_VALUES: usize = 2_000_000;

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

fn has_jump(block: &Block) -> bool {
    block.stmts.iter().any(|s| match s {
        Stmt::Break | Stmt::Continue => true,
        Stmt::If(_, a, b) => has_jump(a) || has_jump(b),
        _ => false,
    })
}

impl Folder<'_> {
    pub(super) fn unroll(&mut self, l: Loop, out: &mut Block) {
        let span = closure_call(self.shader, &l);
        for turn in 0..=MAX_TURNS {
            if self.shader.values.len() > MAX_VALUES {
                return self.refuse(span, true);
            }
            if !(l.tested_after && turn == 0) {
                let mut map = HashMap::new();
                let head = self.copy(&l.head, &mut map);
                self.stmts(head, out);
                let cond = map.get(&l.cond).copied().unwrap_or(l.cond);
                match self.const_of(cond).map(ops::is_true) {
                    Some(false) => return,
                    Some(true) if turn < MAX_TURNS => {}
                    known => return self.refuse(span, known.is_some()),
                }
            }
            let mut map = HashMap::new();
            let body = self.copy(&l.body, &mut map);
            let mut folded = self.block(body);
            match folded.stmts.last() {
                Some(Stmt::Break) => {
                    folded.stmts.pop();
                    if has_jump(&folded) {
                        return self.refuse(span, false);
                    }
                    out.stmts.append(&mut folded.stmts);
                    return;
                }
                Some(Stmt::Continue) => {
                    folded.stmts.pop();
                }
                _ => {}
            }
            if has_jump(&folded) {
                return self.refuse(span, false);
            }
            out.stmts.append(&mut folded.stmts);
            let mut map = HashMap::new();
            let step = self.copy(&l.step, &mut map);
            self.stmts(step, out);
        }
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
                        if let crate::ir::Arg::Value(v) = arg {
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
