//! `exit()` inside functions and expressions, as structured control flow.
//!
//! In: the typed tree. Out: which functions may end the shader, and statements that call them. `exit()` there sets one flag
//! for the whole shader and returns. What follows such a call in the same statement is guarded by the flag, wherever in an
//! expression the call stands; the statement then leaves its own body as a `return` would. Defaults of parameters may end the
//! shader, too.

use super::Lower;
use super::place::Place;
use crate::check::typed::{Callee, Expr, ExprKind, FunctionId, Shader, Stmt as Typed, expressions, visit};
use crate::ir::{Block, Inst, LocalId, LocalKind, Stmt, Ty, UnaryOp, ValueId};
use crate::source::Span;

pub(super) fn is_exit(e: &Expr) -> bool {
    matches!(&e.kind, ExprKind::Call(Callee::Builtin { id, .. }, _) if crate::builtins::row(*id).name == "exit")
}

/// Whether an expression is made of literals alone.
fn is_constant(e: &Expr) -> bool {
    let mut all = true;
    visit(e, &mut |e| {
        all &= matches!(
            e.kind,
            ExprKind::Int(_)
                | ExprKind::Float(_)
                | ExprKind::Str(_)
                | ExprKind::Convert(_)
                | ExprKind::Neg(_)
                | ExprKind::Construct(_)
                | ExprKind::List(_)
        );
    });
    all
}

/// For each function whether it may end the shader; `None` when the only calls of `exit()` are statements of the shader's own body.
pub(super) fn exiting(tree: &Shader) -> Option<Vec<bool>> {
    let mut exits = vec![false; tree.functions.len()];
    let mut callers: Vec<Vec<FunctionId>> = vec![Vec::new(); tree.functions.len()];
    let mut todo = Vec::new();
    for (i, function) in tree.functions.iter().enumerate() {
        let id = FunctionId(i as u32);
        expressions(function.body.as_deref().unwrap_or_default(), &mut |e| {
            visit(e, &mut |e| match &e.kind {
                ExprKind::Call(Callee::User(callee), _) => callers[callee.0 as usize].push(id),
                _ if is_exit(e) => todo.push(id),
                _ => {}
            });
        });
    }
    let mut inside = false;
    for init in tree.params.iter().filter_map(|p| p.init.as_ref()) {
        visit(init, &mut |e| inside |= is_exit(e));
    }
    expressions(&tree.body, &mut |e| {
        if !is_exit(e) {
            visit(e, &mut |e| inside |= is_exit(e));
        }
    });
    if todo.is_empty() && !inside {
        return None;
    }
    while let Some(id) = todo.pop() {
        if !std::mem::replace(&mut exits[id.0 as usize], true) {
            todo.extend(&callers[id.0 as usize]);
        }
    }
    Some(exits)
}

impl Lower<'_> {
    fn function_exits(&self, id: FunctionId) -> bool {
        self.exiting.as_ref().and_then(|e| e.get(id.0 as usize)).copied().unwrap_or(false)
    }

    fn is_exiting(&self, e: &Expr) -> bool {
        is_exit(e) || matches!(&e.kind, ExprKind::Call(Callee::User(id), _) if self.function_exits(*id))
    }

    /// Whether evaluating the expression may end the shader.
    pub(super) fn calls_exit(&self, e: &Expr) -> bool {
        let mut found = false;
        if self.exiting.is_some() {
            visit(e, &mut |e| found |= self.is_exiting(e));
        }
        found
    }

    fn exited(&mut self) -> LocalId {
        if let Some(local) = self.exited {
            return local;
        }
        // It starts as 0, as all variables do, and is never reset.
        let local = self.local("exited", Ty::Int, None, LocalKind::Variable);
        self.exited = Some(local);
        local
    }

    /// A parameter's default. One that ends the shader keeps later ones that compute and the body from running; it is not run,
    /// and ends nothing, where the parameter has a value.
    pub(super) fn default_of(&mut self, target: &Place, e: &Expr) {
        let work = |l: &mut Self| _ = l.closing(e.span, |l| l.assign_expr(target, e));
        let runs = self.defaults_exit.is_some() && !is_constant(e);
        if runs {
            self.unless_exited(e.span, work)
        } else {
            work(self)
        }
        if self.calls_exit(e) {
            self.defaults_exit = Some(e.span);
        }
    }

    /// The shader's body, behind the defaults.
    pub(super) fn body(&mut self, stmts: &[Typed]) {
        match self.defaults_exit {
            Some(span) => self.unless_exited(span, |l| l.stmts(stmts, true)),
            None => self.stmts(stmts, true),
        }
    }

    /// What follows in the present statement runs only when the shader goes on: it goes into a block of its own, which
    /// [`Lower::closing`] closes where the statement ends.
    pub(super) fn open_guard(&mut self) {
        self.blocks.push(Block::default());
        self.guards += 1;
    }

    /// Runs the work of a statement, or of a branch inside one, and closes the guards that were opened in it. Whether there were any.
    pub(super) fn closing(&mut self, span: Span, work: impl FnOnce(&mut Self)) -> bool {
        let outer = std::mem::take(&mut self.guards);
        work(self);
        let opened = std::mem::replace(&mut self.guards, outer);
        for _ in 0..opened {
            let guarded = self.blocks.pop().unwrap_or_default();
            if !guarded.stmts.is_empty() {
                self.unless_exited(span, |l| l.push_all(guarded));
            }
        }
        opened > 0
    }

    /// A branch inside an expression: an `exit()` in it keeps the rest of the statement from running, too, once the caller has
    /// pushed the branch and calls [`Lower::guard_rest`].
    pub(super) fn branch(&mut self, span: Span, work: impl FnOnce(&mut Self)) -> Block {
        let mut left = false;
        let block = self.in_block(|l| left = l.closing(span, work));
        self.left_branch |= left;
        block
    }

    /// After branches of an expression.
    pub(super) fn guard_rest(&mut self) {
        if std::mem::take(&mut self.left_branch) {
            self.open_guard();
        }
    }

    fn push_all(&mut self, block: Block) {
        if let Some(at) = self.blocks.last_mut() {
            at.stmts.extend(block.stmts);
        }
    }

    /// `exit()` in the midst of an expression.
    pub(super) fn exit_inside(&mut self, span: Span) {
        let exited = self.exited();
        let one = self.int(1, span);
        self.push(Stmt::Store(exited, one));
        self.open_guard();
    }

    /// After inlining a function: what follows runs only when it did not end the shader.
    pub(super) fn guard_call(&mut self, id: FunctionId) {
        if self.function_exits(id) {
            self.open_guard();
        }
    }

    /// `exit()` ends the shader: a return of its body, through all functions on the way.
    pub(super) fn exit(&mut self, e: &Expr, tail: bool) {
        if self.frames.last().is_some_and(|f| f.function.is_some()) {
            let exited = self.exited();
            let one = self.int(1, e.span);
            self.push(Stmt::Store(exited, one));
        }
        self.returned(e.span, tail);
    }

    /// After a call that may have ended the shader: leaves this body too.
    pub(super) fn leave_if_exited(&mut self, span: Span, tail: bool) {
        if tail {
            return;
        }
        let exited = self.exited();
        let flag = self.flag();
        let value = self.value(Inst::Load(exited), Ty::Int, span);
        self.push(Stmt::Store(flag, value));
        if self.in_loop() {
            self.leave_loop_if_returned();
        }
    }

    /// What runs only when the shader goes on.
    fn unless_exited(&mut self, span: Span, then: impl FnOnce(&mut Self)) {
        let exited = self.exited();
        let value = self.value(Inst::Load(exited), Ty::Int, span);
        let goes_on = self.value(Inst::Unary(UnaryOp::Not, value), Ty::Int, span);
        let then = self.in_block(then);
        self.push(Stmt::If(goes_on, then, Block::default()));
    }

    /// A statement that is an expression in which the shader may end.
    pub(super) fn exiting_statement(&mut self, e: &Expr, tail: bool) {
        self.closing(e.span, |l| l.effect(e));
        self.leave_if_exited(e.span, tail);
    }

    /// A condition in which the shader may end; false then.
    pub(super) fn exiting_condition(&mut self, cond: &Expr) -> ValueId {
        let result = self.temp(Ty::Int);
        let zero = self.int(0, cond.span);
        self.push(Stmt::Store(result, zero));
        self.closing(cond.span, |l| {
            let value = l.expr(cond);
            l.push(Stmt::Store(result, value));
        });
        self.value(Inst::Load(result), Ty::Int, cond.span)
    }

    /// The condition of a loop, of which it or the step may end the shader.
    pub(super) fn exiting_head(&mut self, cond: Option<&Expr>, span: Span) -> ValueId {
        let result = self.temp(Ty::Int);
        let zero = self.int(0, span);
        self.push(Stmt::Store(result, zero));
        self.unless_exited(span, |l| {
            l.closing(span, |l| {
                let value = match cond {
                    Some(e) => l.expr(e),
                    None => l.int(1, span),
                };
                l.push(Stmt::Store(result, value));
            });
        });
        self.value(Inst::Load(result), Ty::Int, span)
    }

    /// An `if` in whose condition the shader may end.
    pub(super) fn exiting_if(&mut self, cond: &Expr, branches: [&[Typed]; 2], tail: bool) {
        let value = self.exiting_condition(cond);
        self.leave_if_exited(cond.span, tail);
        self.unless_exited(cond.span, |l| {
            let [then, otherwise] = branches.map(|b| l.in_block(|l| l.stmts(b, tail)));
            l.push(Stmt::If(value, then, otherwise));
        });
    }
}
