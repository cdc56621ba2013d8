//! Statements and structured control flow.
//!
//! Each loop has a head, a body, a place to go on at and a place behind; each branch merges. What no path reaches is not
//! written.

use super::inst::MAX_ARGUMENTS;
use super::module::{Op, Type, Word};
use super::writer::{Jumps, Writer};
use crate::builtins;
use crate::diag::Diagnostic;
use crate::ir::{Block, LocalId, Loop, Stmt, ValueId};

/// Counted loops up to this length are written out.
const MAX_UNROLLED: u32 = 16;

/// More ids than SPIR-V allows in a module are more than anybody wants.
const MAX_IDS: Word = 4_000_000;

impl Writer<'_> {
    /// Writes a block's statements, as far as they are reached.
    pub(super) fn block(&mut self, block: &Block) {
        for stmt in &block.stmts {
            if !self.module.is_open() {
                return;
            }
            if self.module.ids() > MAX_IDS {
                if self.errors.is_empty() {
                    let message = format!("shader `{}` is too large for a SPIR-V module", self.shader.name);
                    self.errors.push(Diagnostic::global("E4303", message));
                }
                return;
            }
            self.stmt(stmt);
        }
    }

    fn stmt(&mut self, stmt: &Stmt) {
        if self.analysis.is_absorbed(stmt) {
            return;
        }
        match stmt {
            Stmt::Let(v) => self.compute(*v),
            Stmt::Store(l, v) => self.store(*l, self.value(*v)),
            Stmt::StoreElem(l, i, v) => {
                let len = self.shader.locals[l.0 as usize].len.unwrap_or(1);
                let index = self.index(*i, len);
                self.store_element(*l, index, self.value(*v));
            }
            Stmt::CopyArray(to, from) => {
                let len = |l: &LocalId| self.shader.locals[l.0 as usize].len.unwrap_or(0);
                let (to, from, count) = (*to, *from, len(to).min(len(from)));
                self.counted(count, |w, i| {
                    let value = w.element(from, i);
                    w.store_element(to, i, value);
                });
            }
            Stmt::Call { func, args, span, .. } if builtins::has_effect(*func) => self.print(stmt, args, *span),
            Stmt::Call { func, args, outputs, result, span } => {
                let ty = result.map(|l| self.shader.locals[l.0 as usize].ty);
                let value = self.builtin(*func, args, outputs, ty, *span);
                if let Some(l) = result {
                    self.store(*l, value);
                }
            }
            Stmt::If(c, a, b) => self.branch(*c, a, b),
            Stmt::Loop(l) => self.repeat(l),
            Stmt::Break => self.jump(|j| j.leave),
            Stmt::Continue => self.jump(|j| j.next),
        }
    }

    /// Ends the block, if it is open, with a jump.
    fn go(&mut self, to: Word) {
        if self.module.is_open() {
            self.module.end(Op::Branch, &[to]);
        }
    }

    fn jump(&mut self, to: impl FnOnce(&Jumps) -> Word) {
        // The verifier holds jumps inside loops.
        if let Some(to) = self.loops.last().map(to) {
            self.go(to);
        }
    }

    fn branch(&mut self, c: ValueId, a: &Block, b: &Block) {
        let condition = self.condition(c);
        let (then, other, merge) = (self.module.id(), self.module.id(), self.module.id());
        self.module.selection(merge);
        let has_other = !b.stmts.is_empty();
        self.module.end(Op::BranchConditional, &[condition, then, if has_other { other } else { merge }]);
        self.module.label(then);
        self.block(a);
        let mut reached = self.module.is_open() || !has_other;
        self.go(merge);
        if has_other {
            self.module.label(other);
            self.block(b);
            reached |= self.module.is_open();
            self.go(merge);
        }
        self.module.label(merge);
        if !reached {
            self.module.end(Op::Unreachable, &[]);
        }
    }

    fn repeat(&mut self, l: &Loop) {
        let ids = [0; 6].map(|_| self.module.id());
        let [start, head, body, next, step, leave] = ids;
        self.module.end(Op::Branch, &[start]);
        self.module.label(start);
        self.module.repetition(leave, next);
        self.module.end(Op::Branch, &[if l.tested_after { body } else { head }]);
        self.loops.push(Jumps { leave, next });
        if l.tested_after {
            self.module.label(body);
            self.block(&l.body);
            self.go(next);
            self.module.label(next);
            self.test(l, step, leave);
            self.module.label(step);
        } else {
            self.module.label(head);
            self.test(l, body, leave);
            self.module.label(body);
            self.block(&l.body);
            self.go(next);
            self.module.label(next);
        }
        self.block(&l.step);
        self.go(start);
        self.loops.pop();
        self.module.label(leave);
    }

    /// Computes a loop's condition and leaves if it does not hold.
    fn test(&mut self, l: &Loop, on: Word, leave: Word) {
        self.block(&l.head);
        if self.module.is_open() {
            let condition = self.condition(l.cond);
            self.module.end(Op::BranchConditional, &[condition, on, leave]);
        }
    }

    /// Does something for each index below a count.
    pub(super) fn counted(&mut self, count: u32, mut each: impl FnMut(&mut Self, Word)) {
        if count <= MAX_UNROLLED {
            for i in 0..count {
                let index = self.module.int(i as i32);
                each(self, index);
            }
            return;
        }
        let [start, head, body, next, leave] = [0; 5].map(|_| self.module.id());
        let (int, bool) = (self.module.ty(Type::Int), self.module.ty(Type::Bool));
        let (zero, one, end) = (self.module.int(0), self.module.int(1), self.module.int(count as i32));
        let counter = self.module.variable(int);
        self.module.effect(Op::Store, &[counter, zero]);
        self.module.end(Op::Branch, &[start]);
        self.module.label(start);
        self.module.repetition(leave, next);
        self.module.end(Op::Branch, &[head]);
        self.module.label(head);
        let index = self.module.inst(Op::Load, int, &[counter]);
        let more = self.module.inst(Op::SLessThan, bool, &[index, end]);
        self.module.end(Op::BranchConditional, &[more, body, leave]);
        self.module.label(body);
        each(self, index);
        self.module.end(Op::Branch, &[next]);
        self.module.label(next);
        let following = self.module.inst(Op::IAdd, int, &[index, one]);
        self.module.effect(Op::Store, &[counter, following]);
        self.module.end(Op::Branch, &[start]);
        self.module.label(leave);
    }

    /// Whether a function of the bridge can have so many arguments.
    pub(super) fn fits(count: usize) -> bool {
        count < MAX_ARGUMENTS
    }
}
