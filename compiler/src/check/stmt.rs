//! Statements.

use super::Checker;
use super::typed::{Expr, Stmt, VarKind};
use crate::ast;
use crate::diag::Diagnostic;
use crate::types::{Base, Type};

impl Checker {
    /// The statements of a block, in a scope of their own.
    pub(super) fn block(&mut self, block: &ast::Block) -> Vec<Stmt> {
        self.scopes.enter();
        self.stmts(block)
    }

    /// The statements of a function or shader, in the scope of its parameters.
    pub(super) fn body_block(&mut self, block: &ast::Block) -> Vec<Stmt> {
        self.scopes.enter_joined();
        self.stmts(block)
    }

    /// The statements of a block, whose scope ends with them.
    fn stmts(&mut self, block: &ast::Block) -> Vec<Stmt> {
        let mut out = Vec::new();
        for stmt in &block.stmts {
            self.stmt(stmt, &mut out);
        }
        self.scopes.leave();
        out
    }

    /// One statement as the body of something. Only braces open a scope: `if (c) float x = 1; else x = 2;` declares one `x`.
    fn body(&mut self, stmt: &ast::Stmt) -> Vec<Stmt> {
        let mut out = Vec::new();
        self.stmt(stmt, &mut out);
        out
    }

    fn condition(&mut self, e: &ast::Expr) -> Option<Expr> {
        let expr = self.expr(e, Some(Type::INT))?;
        self.truth(expr)
    }

    fn loop_body(&mut self, stmt: &ast::Stmt) -> Vec<Stmt> {
        self.loops += 1;
        let body = self.body(stmt);
        self.loops -= 1;
        body
    }

    fn stmt(&mut self, stmt: &ast::Stmt, out: &mut Vec<Stmt>) {
        match &stmt.kind {
            ast::StmtKind::Empty => {}
            ast::StmtKind::Declare { ty, names } => {
                for d in names {
                    self.declaration(ty, d, out);
                }
            }
            ast::StmtKind::Function(f) => self.function(f),
            ast::StmtKind::Struct(s) => self.structure(s),
            ast::StmtKind::Expr(e) => out.extend(self.expr(e, None).map(Stmt::Expr)),
            ast::StmtKind::Block(b) => {
                let inner = self.block(b);
                out.push(Stmt::Block(inner));
            }
            ast::StmtKind::If { cond, then, otherwise } => {
                let cond = self.condition(cond);
                let then = self.body(then);
                let otherwise = otherwise.as_ref().map_or(Vec::new(), |s| self.body(s));
                out.extend(cond.map(|c| Stmt::If(c, then, otherwise)));
            }
            ast::StmtKind::While { cond, body } => {
                let cond = self.condition(cond);
                let body = self.loop_body(body);
                out.push(Stmt::Loop { cond, after: false, step: None, body });
            }
            ast::StmtKind::DoWhile { body, cond } => {
                let body = self.loop_body(body);
                let cond = self.condition(cond);
                out.push(Stmt::Loop { cond, after: true, step: None, body });
            }
            ast::StmtKind::For { init, cond, step, body } => {
                self.scopes.enter();
                let mut inner = Vec::new();
                self.stmt(init, &mut inner);
                let cond = cond.as_ref().and_then(|c| self.condition(c));
                let step = step.as_ref().and_then(|s| self.expr(s, None));
                let body = self.loop_body(body);
                self.scopes.leave();
                inner.push(Stmt::Loop { cond, after: false, step, body });
                out.push(Stmt::Block(inner));
            }
            ast::StmtKind::Break => self.jump(stmt, Stmt::Break, "break", out),
            ast::StmtKind::Continue => self.jump(stmt, Stmt::Continue, "continue", out),
            ast::StmtKind::Return(value) => self.return_(stmt, value.as_ref(), out),
        }
    }

    fn jump(&mut self, at: &ast::Stmt, stmt: Stmt, word: &str, out: &mut Vec<Stmt>) {
        if self.loops == 0 {
            self.error(Diagnostic::error("E2008", at.span, format!("`{word}` outside of a loop")));
        }
        out.push(stmt);
    }

    fn declaration(&mut self, ty: &ast::TypeSpec, d: &ast::Declarator, out: &mut Vec<Stmt>) {
        let Some(ty) = self.declared_type(ty, &d.array, d.init.is_some()) else {
            self.scopes.declare_broken(&d.name.name);
            return;
        };
        if ty.base == Base::Void {
            self.error(Diagnostic::error("E2003", d.name.span, format!("`{}` cannot be void", d.name.name)));
            self.scopes.declare_broken(&d.name.name);
            return;
        }
        let init = match &d.init {
            Some(init) => self.assigned(init, ty, &format!("`{}`", d.name.name)),
            None => None,
        };
        let ty = self.settle_extent(ty, init.as_ref());
        let var = self.declare(&d.name, ty, VarKind::Local, true);
        out.push(Stmt::Declare(var, init));
    }

    fn return_(&mut self, at: &ast::Stmt, value: Option<&ast::Init>, out: &mut Vec<Stmt>) {
        self.returned = true;
        let Some(wanted) = self.returns else {
            // The function's type is unknown, which was said.
            if let Some(ast::Init::Expr(e)) = value {
                self.expr(e, None);
            }
            return;
        };
        let value = match value {
            None => {
                if wanted != Type::VOID {
                    let message = format!("this function must return {}", self.show(wanted));
                    self.error(Diagnostic::error("E2003", at.span, message));
                }
                None
            }
            Some(init) if wanted == Type::VOID => {
                let what = if self.current.is_some() { "a void function" } else { "a shader" };
                let span = match init {
                    ast::Init::Expr(e) => e.span,
                    ast::Init::List(_, span) => *span,
                };
                self.error(Diagnostic::error("E2003", span, format!("{what} cannot return a value")));
                None
            }
            Some(init) => self.initial(init, wanted, "the result"),
        };
        out.push(Stmt::Return(value, at.span));
    }
}
