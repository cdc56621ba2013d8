//! Statements, and `return` as structured control flow.
//!
//! A `return` in tail position only stores the result. Any other sets the frame's flag, and leaves the loops of its body; what
//! follows is guarded by the flag.

use super::exit::is_exit;
use super::place::Place;
use super::{Frame, Lower};
use crate::check::typed::{Expr, Stmt as Typed};
use crate::ir::{Block, Const, Inst, LocalId, Loop, Stmt, Ty, UnaryOp, ValueId};
use crate::source::Span;

/// Whether control never comes out at the end.
fn always_returns(stmts: &[Typed]) -> bool {
    match stmts.last() {
        Some(Typed::Return(..)) => true,
        Some(Typed::Block(b)) => always_returns(b),
        Some(Typed::If(_, a, b)) => always_returns(a) && always_returns(b),
        Some(Typed::Expr(e)) => is_exit(e),
        _ => false,
    }
}

impl Lower<'_> {
    /// Whether a `return` or `exit` may happen inside.
    fn may_return(&self, stmts: &[Typed]) -> bool {
        stmts.iter().any(|s| match s {
            Typed::Return(..) => true,
            Typed::Block(b) => self.may_return(b),
            Typed::If(c, a, b) => self.may_return(a) || self.may_return(b) || self.calls_exit(c),
            Typed::Loop { cond, step, body, .. } => {
                self.may_return(body) || cond.iter().chain(step).any(|e| self.calls_exit(e))
            }
            Typed::Expr(e) => is_exit(e) || self.calls_exit(e),
            Typed::Declare(_, Some(e)) => self.calls_exit(e),
            _ => false,
        })
    }

    fn frame(&mut self) -> Option<&mut Frame> {
        self.frames.last_mut()
    }

    pub(super) fn in_loop(&self) -> bool {
        self.frames.last().is_some_and(|f| f.loops > 0)
    }

    pub(super) fn flag(&mut self) -> LocalId {
        if let Some(flag) = self.frames.last().and_then(|f| f.flag) {
            return flag;
        }
        let flag = self.local("returned", Ty::Int, None, crate::ir::LocalKind::Variable);
        if let Some(frame) = self.frame() {
            frame.flag = Some(flag);
        }
        flag
    }

    /// Lowers a list of statements; with `tail` nothing of the body runs after it.
    pub(super) fn stmts(&mut self, stmts: &[Typed], tail: bool) {
        for (i, stmt) in stmts.iter().enumerate() {
            if self.too_large {
                return;
            }
            let rest = &stmts[i + 1..];
            let last = rest.is_empty();
            if let (Typed::If(cond, a, b), false, false) = (stmt, last, self.in_loop()) {
                // `if (c) return x; rest` is `if (c) {...} else { rest }`.
                if tail && b.is_empty() && always_returns(a) && !self.calls_exit(cond) {
                    let cond = self.expr(cond);
                    let then = self.in_block(|l| l.stmts(a, true));
                    let otherwise = self.in_block(|l| l.stmts(rest, true));
                    self.push(Stmt::If(cond, then, otherwise));
                    return;
                }
            }
            self.stmt(stmt, tail && last);
            if matches!(stmt, Typed::Return(..) | Typed::Break | Typed::Continue)
                || always_returns(std::slice::from_ref(stmt))
            {
                return;
            }
            if !last && self.may_return(std::slice::from_ref(stmt)) {
                if self.in_loop() && matches!(stmt, Typed::Expr(_) | Typed::Declare(..)) {
                    // A call that may end the shader has left the loop already.
                } else if self.in_loop() {
                    // A plain `if` with a return inside left the loop already; an inner loop only left itself.
                    self.leave_loop_if_returned();
                } else {
                    let flag = self.flag();
                    let span = Span { file: crate::source::FileId(0), start: 0, end: 0 };
                    let returned = self.value(Inst::Load(flag), Ty::Int, span);
                    let cond = self.value(Inst::Unary(UnaryOp::Not, returned), Ty::Int, span);
                    let then = self.in_block(|l| l.stmts(rest, tail));
                    self.push(Stmt::If(cond, then, Block::default()));
                    return;
                }
            }
        }
    }

    pub(super) fn leave_loop_if_returned(&mut self) {
        let flag = self.flag();
        let span = Span { file: crate::source::FileId(0), start: 0, end: 0 };
        let returned = self.value(Inst::Load(flag), Ty::Int, span);
        self.push(Stmt::If(returned, Block { stmts: vec![Stmt::Break] }, Block::default()));
    }

    fn stmt(&mut self, stmt: &Typed, tail: bool) {
        match stmt {
            Typed::Declare(var, init) => {
                let declared = self.tree.var(*var).clone();
                // A fresh variable each time: a function inlined twice has two.
                let storage = self.storage(&declared.name, declared.ty, crate::ir::LocalKind::Variable);
                self.env.insert(*var, storage.clone());
                if init.is_none() {
                    self.declared_without_value(&declared.name, declared.ty, &storage);
                }
                // Without an initialiser the value is undefined, also at each turn of a loop: nothing is stored.
                if let Some(e) = init
                    && self.closing(e.span, |l| l.assign_expr(&Place::whole(storage), e))
                {
                    self.leave_if_exited(e.span, tail);
                }
            }
            Typed::Expr(e) if is_exit(e) => self.exit(e, tail),
            Typed::Expr(e) if self.calls_exit(e) => self.exiting_statement(e, tail),
            Typed::Expr(e) => self.effect(e),
            Typed::Block(b) => self.stmts(b, tail),
            Typed::If(cond, a, b) if self.calls_exit(cond) => self.exiting_if(cond, [a, b], tail),
            Typed::If(cond, a, b) => {
                let cond = self.expr(cond);
                let then = self.in_block(|l| l.stmts(a, tail));
                let otherwise = self.in_block(|l| l.stmts(b, tail));
                self.push(Stmt::If(cond, then, otherwise));
            }
            Typed::Loop { cond, after, step, body } => {
                self.loop_(cond.as_ref(), *after, step.as_ref(), body, tail);
            }
            Typed::Break => self.push(Stmt::Break),
            Typed::Continue => self.push(Stmt::Continue),
            Typed::Return(value, span) => {
                let result = self.frames.last().and_then(|f| f.result.clone());
                match (value, result) {
                    (Some(e), Some(result)) => {
                        self.closing(e.span, |l| l.assign_expr(&Place::whole(result), e));
                    }
                    (Some(e), None) => {
                        self.closing(e.span, |l| l.effect(e));
                    }
                    (None, _) => {}
                }
                self.returned(*span, tail);
            }
        }
    }

    pub(super) fn returned(&mut self, span: Span, tail: bool) {
        if tail {
            return;
        }
        let flag = self.flag();
        let one = self.constant(Const::Int(1), span);
        self.push(Stmt::Store(flag, one));
        if self.in_loop() {
            self.push(Stmt::Break);
        }
    }

    fn loop_(&mut self, cond: Option<&Expr>, after: bool, step: Option<&Expr>, body: &[Typed], tail: bool) {
        let exits = cond.into_iter().chain(step).find(|e| self.calls_exit(e)).map(|e| e.span);
        let mut value = ValueId(0);
        let head = self.in_block(|l| {
            value = match (exits, cond) {
                (Some(span), _) => l.exiting_head(cond, span),
                (None, Some(e)) => l.expr(e),
                (None, None) => {
                    let span = Span { file: crate::source::FileId(0), start: 0, end: 0 };
                    l.int(1, span)
                }
            };
        });
        if let Some(frame) = self.frame() {
            frame.loops += 1;
        }
        let body_block = self.in_block(|l| l.stmts(body, false));
        if let Some(frame) = self.frame() {
            frame.loops -= 1;
        }
        let step = self.in_block(|l| {
            if let Some(e) = step {
                l.closing(e.span, |l| l.effect(e));
            }
        });
        self.push(Stmt::Loop(Box::new(Loop { head, cond: value, tested_after: after, body: body_block, step })));
        if let Some(span) = exits {
            self.leave_if_exited(span, tail);
        }
    }
}
