//! `exit()` inside functions, as structured control flow.
//!
//! In: the typed tree. Out: which functions may end the shader, and statements that call them. `exit()` there sets one flag
//! for the whole shader and returns; each statement with such a call then leaves its own body as a `return` would.

use super::Lower;
use super::place::Place;
use crate::check::typed::{Callee, Expr, ExprKind, FunctionId, Shader, Stmt as Typed};
use crate::diag::Diagnostic;
use crate::ir::{Block, Inst, LocalId, LocalKind, Stmt, Ty, UnaryOp, ValueId};
use crate::source::Span;

/// Visits an expression and all inside it; without recursion, since chains of operators may be long.
fn visit<'e>(e: &'e Expr, see: &mut dyn FnMut(&'e Expr)) {
    let mut todo = vec![e];
    while let Some(e) = todo.pop() {
        see(e);
        match &e.kind {
            ExprKind::Int(_) | ExprKind::Float(_) | ExprKind::Str(_) | ExprKind::Var(_) => {}
            ExprKind::Field(a, _)
            | ExprKind::Convert(a)
            | ExprKind::Truth(a)
            | ExprKind::Neg(a)
            | ExprKind::Not(a)
            | ExprKind::Compl(a)
            | ExprKind::IncDec(_, a) => todo.push(a),
            ExprKind::Index(a, b)
            | ExprKind::Component(a, b)
            | ExprKind::Binary(_, a, b)
            | ExprKind::Assign(a, b)
            | ExprKind::AssignOp(_, a, b) => todo.extend([&**a, &**b]),
            ExprKind::Element(a, b, c) | ExprKind::Ternary(a, b, c) => todo.extend([&**a, &**b, &**c]),
            ExprKind::Call(_, list) | ExprKind::Construct(list) | ExprKind::List(list) | ExprKind::Comma(list) => {
                todo.extend(list);
            }
        }
    }
}

/// The expressions of statements, outermost.
fn expressions<'e>(stmts: &'e [Typed], see: &mut dyn FnMut(&'e Expr)) {
    for stmt in stmts {
        match stmt {
            Typed::Declare(_, Some(e)) | Typed::Expr(e) | Typed::Return(Some(e), _) => see(e),
            Typed::Block(b) => expressions(b, see),
            Typed::If(c, a, b) => {
                see(c);
                expressions(a, see);
                expressions(b, see);
            }
            Typed::Loop { cond, step, body, .. } => {
                cond.iter().chain(step).for_each(&mut *see);
                expressions(body, see);
            }
            _ => {}
        }
    }
}

pub(super) fn is_exit(e: &Expr) -> bool {
    matches!(&e.kind, ExprKind::Call(Callee::Builtin { id, .. }, _) if crate::builtins::row(*id).name == "exit")
}

/// For each function whether it may end the shader; empty when none does.
pub(super) fn exiting(tree: &Shader) -> Vec<bool> {
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
    if todo.is_empty() {
        return Vec::new();
    }
    while let Some(id) = todo.pop() {
        if !std::mem::replace(&mut exits[id.0 as usize], true) {
            todo.extend(&callers[id.0 as usize]);
        }
    }
    exits
}

impl Lower<'_> {
    fn is_exiting(&self, e: &Expr) -> bool {
        let exits = |id: &FunctionId| self.exiting.get(id.0 as usize).copied().unwrap_or(false);
        matches!(&e.kind, ExprKind::Call(Callee::User(id), _) if exits(id))
    }

    /// Whether evaluating the expression may end the shader.
    pub(super) fn calls_exit(&self, e: &Expr) -> bool {
        let mut found = false;
        if !self.exiting.is_empty() {
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

    /// Refuses an expression that would do more after its call of `exit()`: nothing can be skipped inside expressions.
    pub(super) fn refuse_rest(&mut self, e: &Expr) {
        let (mut exits, mut effects) = (0, 0);
        visit(e, &mut |e| match &e.kind {
            _ if self.is_exiting(e) => exits += 1,
            ExprKind::Assign(..) | ExprKind::AssignOp(..) | ExprKind::IncDec(..) => effects += 1,
            ExprKind::Call(Callee::User(id), _) => {
                let outputs = self.tree.functions[id.0 as usize].params.iter().any(|(_, output)| *output);
                effects += usize::from(outputs);
            }
            ExprKind::Call(Callee::Builtin { outputs, .. }, _) => effects += usize::from(outputs.contains(&true)),
            _ => {}
        });
        if exits > 1 || exits == 1 && effects > 0 {
            self.refuse_exit(e.span);
        }
    }

    /// For calls where nothing can be done about it.
    pub(super) fn refuse_exit(&mut self, span: Span) {
        let d = Diagnostic::not_yet("E3005", span, "a function that may call exit() in an expression like this");
        self.error(d.help("call it in a statement of its own, or assign its result to a variable first"));
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

    /// A statement that is an expression with a call that may end the shader.
    pub(super) fn exiting_statement(&mut self, e: &Expr, tail: bool) {
        match &e.kind {
            ExprKind::Call(Callee::User(_), args) if !args.iter().any(|a| self.calls_exit(a)) => self.effect(e),
            ExprKind::Assign(target, value) if !self.calls_exit(target) => {
                self.refuse_rest(value);
                let storage = self.storage("t", value.ty, LocalKind::Variable);
                let result = Place::whole(storage);
                self.assign_expr(&result, value);
                self.unless_exited(e.span, |l| {
                    let place = l.place(target);
                    l.copy(&place, &result, e.span);
                });
            }
            _ => self.refuse_exit(e.span),
        }
        self.leave_if_exited(e.span, tail);
    }

    /// An `if` whose condition may end the shader.
    pub(super) fn exiting_if(&mut self, cond: &Expr, branches: [&[Typed]; 2], tail: bool) {
        self.refuse_rest(cond);
        let value: ValueId = self.expr(cond);
        self.leave_if_exited(cond.span, tail);
        self.unless_exited(cond.span, |l| {
            let [then, otherwise] = branches.map(|b| l.in_block(|l| l.stmts(b, tail)));
            l.push(Stmt::If(value, then, otherwise));
        });
    }
}
