//! Operations to statements: control flow by jump targets becomes branches and loops again.
//!
//! In: a range of operations. Out: statements of the typed tree. It must not know which built-ins there are.

use super::Op;
use super::read::{Body, Fit, Reader, unfit};
use super::read_call::binary_op;
use super::read_fit::{array, fitted, matrix, single, triple, truth};
use crate::ast::BinaryOp;
use crate::builtins;
use crate::check::typed::{Callee, Expr, ExprKind, Stmt};
use crate::source::Span;
use crate::types::{Base, Type};

/// Deepest nesting of branches, loops and inlined functions.
pub(super) const MAX_NESTING: usize = 1_000;

impl Reader<'_> {
    fn jump(&self, op: &Op, index: usize, from: usize, end: usize) -> Fit<usize> {
        match op.jumps.get(index).map(|j| *j as usize) {
            Some(j) if (from..=end).contains(&j) => Ok(j),
            Some(_) => Err(unfit(op, "jumps out of the block that it stands in")),
            None => Err(unfit(op, "lacks a jump target")),
        }
    }

    /// The statements of a range of operations.
    pub fn block(&mut self, range: std::ops::Range<usize>) -> Vec<Stmt> {
        let mut out = Vec::new();
        if self.nesting >= MAX_NESTING {
            if let Some(op) = self.module.ops.get(range.start) {
                let d = unfit(op, format!("nests deeper than {MAX_NESTING} branches, loops and functions"));
                self.error(d);
            }
            return out;
        }
        self.nesting += 1;
        let mut at = range.start;
        while at < range.end && self.errors.len() < 20 {
            let module = self.module;
            let op = &module.ops[at];
            match self.statement(op, at, range.end, &mut out) {
                Ok(next) => at = next,
                Err(d) => {
                    self.error(d);
                    at += 1;
                }
            }
        }
        self.nesting -= 1;
        out
    }

    /// One operation with what belongs to it; the number of the next.
    fn statement(&mut self, op: &Op, at: usize, end: usize, out: &mut Vec<Stmt>) -> Fit<usize> {
        match op.name.as_str() {
            "end" => return Ok(end),
            "nop" | "useparam" => {}
            "if" => {
                let cond = truth(op, self.arg(op, 0)?)?;
                let middle = self.jump(op, 0, at + 1, end)?;
                let after = self.jump(op, 1, middle, end)?;
                let then = self.block(at + 1..middle);
                let otherwise = self.block(middle..after);
                out.push(Stmt::If(cond, then, otherwise));
                return Ok(after);
            }
            "functioncall" | "functioncall_nr" => {
                let name = self.constant_string(op, 0)?;
                let after = self.jump(op, 0, at + 1, end)?;
                let (outer, loops) = (self.body, self.loops);
                (self.body, self.loops) = (Body::Function, 0);
                let body = self.block(at + 1..after);
                (self.body, self.loops) = (outer, loops);
                let id = self.function(name, Type::VOID, body, op.span);
                let kind = ExprKind::Call(Callee::User(id), Vec::new());
                out.push(Stmt::Expr(Expr { kind, ty: Type::VOID, span: op.span }));
                return Ok(after);
            }
            "for" | "while" | "dowhile" => return self.loop_(op, at, end, out),
            "break" | "continue" => {
                if self.loops == 0 {
                    return Err(unfit(op, "stands outside of a loop"));
                }
                out.push(if op.name == "break" { Stmt::Break } else { Stmt::Continue });
            }
            "return" | "exit" => out.push(self.leave(op)),
            _ => {
                let e = self.operation(op)?;
                out.push(Stmt::Expr(e));
            }
        }
        Ok(at + 1)
    }

    fn leave(&self, op: &Op) -> Stmt {
        match self.body {
            Body::Default(var) => {
                let ty = self.vars[var.0 as usize].ty;
                Stmt::Return(Some(Expr { kind: ExprKind::Var(var), ty, span: op.span }), op.span)
            }
            Body::Function if op.name == "exit" => {
                let (kind, ty) = match builtins::find("exit") {
                    Some(id) => {
                        let callee = Callee::Builtin { id, formals: Vec::new(), outputs: Vec::new() };
                        (ExprKind::Call(callee, Vec::new()), Type::VOID)
                    }
                    None => (ExprKind::Comma(Vec::new()), Type::VOID),
                };
                Stmt::Expr(Expr { kind, ty, span: op.span })
            }
            _ => Stmt::Return(None, op.span),
        }
    }

    fn loop_(&mut self, op: &Op, at: usize, end: usize, out: &mut Vec<Stmt>) -> Fit<usize> {
        let start = self.jump(op, 0, at + 1, end)?;
        let first = self.jump(op, 1, start, end)?;
        let iteration = self.jump(op, 2, first, end)?;
        let after = self.jump(op, 3, iteration, end)?;
        let init = self.block(at + 1..start);
        out.extend(init);
        let cond = self.block(start..first);
        let cond = self.condition(op, cond)?;
        self.loops += 1;
        let body = self.block(first..iteration);
        self.loops -= 1;
        let step = self.block(iteration..after);
        let step = match simple(step) {
            Ok(parts) if parts.is_empty() => None,
            Ok(parts) => Some(comma(parts, op.span)),
            Err(body) => {
                let id = self.function("step".to_owned(), Type::VOID, body, op.span);
                Some(Expr { kind: ExprKind::Call(Callee::User(id), Vec::new()), ty: Type::VOID, span: op.span })
            }
        };
        out.push(Stmt::Loop { cond: Some(cond), after: op.name == "dowhile", step, body });
        Ok(after)
    }

    /// The code of a loop's condition as one expression.
    fn condition(&mut self, op: &Op, code: Vec<Stmt>) -> Fit<Expr> {
        let read = self.arg(op, 0)?;
        match simple(code) {
            Ok(mut parts) => {
                // Mostly the last operation computes just the condition.
                let computed = parts.last().is_some_and(
                    |e| matches!(&e.kind, ExprKind::Assign(to, _) if to.kind_is_var_of(&read) && e.ty == read.ty),
                );
                if !computed {
                    parts.push(read);
                }
                truth(op, comma(parts, op.span))
            }
            Err(mut body) => {
                let ty = Type::INT;
                body.push(Stmt::Return(Some(truth(op, read)?), op.span));
                let id = self.function("condition".to_owned(), ty, body, op.span);
                Ok(Expr { kind: ExprKind::Call(Callee::User(id), Vec::new()), ty, span: op.span })
            }
        }
    }

    /// An operation that is no control flow.
    fn operation(&mut self, op: &Op) -> Fit<Expr> {
        let assign = |to: Expr, value: Expr| -> Fit<Expr> {
            let value = fitted(op, value, to.ty)?;
            let (ty, span) = (to.ty, op.span);
            Ok(Expr { kind: ExprKind::Assign(Box::new(to), Box::new(value)), ty, span })
        };
        let node = |kind: ExprKind, ty: Type| Expr { kind, ty, span: op.span };
        let index = |e: Expr| if e.ty == Type::INT { Ok(Box::new(e)) } else { Err(unfit(op, "needs an int as index")) };
        match op.name.as_str() {
            "assign" | "arraycopy" => assign(self.target(op, 0)?, self.arg(op, 1)?),
            "aref" => {
                let array = array(op, self.arg(op, 1)?)?;
                let ty = Type::scalar(array.ty.base);
                let value = node(ExprKind::Index(Box::new(array), index(self.arg(op, 2)?)?), ty);
                assign(self.target(op, 0)?, value)
            }
            "aassign" => {
                let array = array(op, self.target(op, 0)?)?;
                let ty = Type::scalar(array.ty.base);
                let to = node(ExprKind::Index(Box::new(array), index(self.arg(op, 1)?)?), ty);
                assign(to, self.arg(op, 2)?)
            }
            "compref" => {
                let triple = triple(op, self.arg(op, 1)?)?;
                let value = node(ExprKind::Component(Box::new(triple), index(self.arg(op, 2)?)?), Type::FLOAT);
                assign(self.target(op, 0)?, value)
            }
            "compassign" => {
                let triple = triple(op, self.target(op, 0)?)?;
                let to = node(ExprKind::Component(Box::new(triple), index(self.arg(op, 1)?)?), Type::FLOAT);
                assign(to, self.arg(op, 2)?)
            }
            "mxcompref" => {
                let matrix = matrix(op, self.arg(op, 1)?)?;
                let (row, column) = (index(self.arg(op, 2)?)?, index(self.arg(op, 3)?)?);
                let value = node(ExprKind::Element(Box::new(matrix), row, column), Type::FLOAT);
                assign(self.target(op, 0)?, value)
            }
            "mxcompassign" => {
                let matrix = matrix(op, self.target(op, 0)?)?;
                let (row, column) = (index(self.arg(op, 1)?)?, index(self.arg(op, 2)?)?);
                let to = node(ExprKind::Element(Box::new(matrix), row, column), Type::FLOAT);
                assign(to, self.arg(op, 3)?)
            }
            "neg" | "compl" => {
                let value = single(op, self.arg(op, 1)?)?;
                let ty = value.ty;
                let fits = if op.name == "neg" { ty.base != Base::String } else { ty == Type::INT };
                if !fits {
                    return Err(unfit(op, format!("does not take {}", ty.base.keyword())));
                }
                let value = Box::new(value);
                let kind = if op.name == "neg" { ExprKind::Neg(value) } else { ExprKind::Compl(value) };
                assign(self.target(op, 0)?, node(kind, ty))
            }
            "color" | "point" | "vector" | "normal" | "matrix" => self.construct(op),
            "closure" => {
                let value = self.closure(op)?;
                assign(self.target(op, 0)?, value)
            }
            name => match binary_op(name) {
                // Of floats, `mod` is what the function `fmod` is.
                Some(BinaryOp::Mod) if self.arg(op, 0)?.ty != Type::INT => self.builtin(op),
                Some(operator) if op.args.len() == 3 => {
                    let value = self.binary(op, operator)?;
                    assign(self.target(op, 0)?, value)
                }
                Some(_) => Err(unfit(op, "needs a result and two operands")),
                None => self.builtin(op),
            },
        }
    }
}

impl Expr {
    /// Whether both are the same variable.
    fn kind_is_var_of(&self, other: &Expr) -> bool {
        matches!((&self.kind, &other.kind), (ExprKind::Var(a), ExprKind::Var(b)) if a == b)
    }
}

/// Statements that are expressions only, or the statements.
fn simple(stmts: Vec<Stmt>) -> Result<Vec<Expr>, Vec<Stmt>> {
    if stmts.iter().all(|s| matches!(s, Stmt::Expr(_))) {
        let expr = |s| match s {
            Stmt::Expr(e) => Some(e),
            _ => None,
        };
        return Ok(stmts.into_iter().filter_map(expr).collect());
    }
    Err(stmts)
}

fn comma(mut parts: Vec<Expr>, span: Span) -> Expr {
    match parts.len() {
        1 => parts.remove(0),
        _ => {
            let ty = parts.last().map_or(Type::VOID, |e| e.ty);
            Expr { kind: ExprKind::Comma(parts), ty, span }
        }
    }
}
