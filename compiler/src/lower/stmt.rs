//! Statements, and `return` as structured control flow.
//!
//! A `return` in tail position only stores the result. Any other sets the frame's flag, and leaves the loops of its body; what
//! follows is guarded by the flag.

use super::place::Place;
use super::{Frame, Lower};
use crate::check::typed::{Callee, Expr, ExprKind, Stmt as Typed};
use crate::ir::{Block, Const, Inst, LocalId, Loop, Stmt, Ty, UnaryOp, ValueId};
use crate::source::Span;

/// Whether a `return` (or `exit`) may happen inside, functions called aside.
fn may_return(stmts: &[Typed]) -> bool {
    stmts.iter().any(|s| match s {
        Typed::Return(..) => true,
        Typed::Block(b) => may_return(b),
        Typed::If(_, a, b) => may_return(a) || may_return(b),
        Typed::Loop { body, .. } => may_return(body),
        Typed::Expr(e) => is_exit(e),
        _ => false,
    })
}

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

fn is_exit(e: &Expr) -> bool {
    matches!(&e.kind, ExprKind::Call(Callee::Builtin { id, .. }, _) if crate::builtins::row(*id).name == "exit")
}

impl Lower<'_> {
    fn frame(&mut self) -> Option<&mut Frame> {
        self.frames.last_mut()
    }

    fn in_loop(&self) -> bool {
        self.frames.last().is_some_and(|f| f.loops > 0)
    }

    fn flag(&mut self) -> LocalId {
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
                if tail && b.is_empty() && always_returns(a) {
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
            if !last && may_return(std::slice::from_ref(stmt)) {
                if self.in_loop() {
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

    fn leave_loop_if_returned(&mut self) {
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
                // Without an initialiser the value is undefined, also at each turn of a loop: nothing is stored.
                if let Some(e) = init {
                    self.assign_expr(&Place::whole(storage), e);
                }
            }
            Typed::Expr(e) if is_exit(e) => self.exit(e, tail),
            Typed::Expr(e) => self.effect(e),
            Typed::Block(b) => self.stmts(b, tail),
            Typed::If(cond, a, b) => {
                let cond = self.expr(cond);
                let then = self.in_block(|l| l.stmts(a, tail));
                let otherwise = self.in_block(|l| l.stmts(b, tail));
                self.push(Stmt::If(cond, then, otherwise));
            }
            Typed::Loop { cond, after, step, body } => self.loop_(cond.as_ref(), *after, step.as_ref(), body),
            Typed::Break => self.push(Stmt::Break),
            Typed::Continue => self.push(Stmt::Continue),
            Typed::Return(value, span) => {
                let result = self.frames.last().and_then(|f| f.result.clone());
                if let (Some(e), Some(result)) = (value, result) {
                    self.assign_expr(&Place::whole(result), e);
                }
                self.returned(*span, tail);
            }
        }
    }

    fn returned(&mut self, span: Span, tail: bool) {
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

    /// `exit()` ends the shader: a return of its body.
    fn exit(&mut self, e: &Expr, tail: bool) {
        if self.frames.last().is_some_and(|f| f.function.is_some()) {
            self.error(crate::diag::Diagnostic::not_yet("E3005", e.span, "exit() inside a function"));
        }
        self.returned(e.span, tail);
    }

    fn loop_(&mut self, cond: Option<&Expr>, after: bool, step: Option<&Expr>, body: &[Typed]) {
        let mut value = ValueId(0);
        let head = self.in_block(|l| {
            value = match cond {
                Some(e) => l.expr(e),
                None => {
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
                l.effect(e);
            }
        });
        self.push(Stmt::Loop(Box::new(Loop { head, cond: value, tested_after: after, body: body_block, step })));
    }
}
