//! Expressions of single types.

use super::place::{Place, is_single};
use super::{Lower, ir_type};
use crate::ast::{BinaryOp as Op, IncDecOp};
use crate::check::typed::{Expr, ExprKind};
use crate::ir::{BinaryOp, Block, Const, Inst, LocalKind, Stmt, Ty, UnaryOp, ValueId};
use crate::source::Span;
use crate::types::{Base, Type};

/// Cheap and without effects: may be computed even when its value is not needed.
fn is_cheap(e: &Expr) -> bool {
    fn cost(e: &Expr) -> u32 {
        const TOO_MUCH: u32 = 1000;
        let sum = |parts: &[&Expr]| parts.iter().map(|p| cost(p)).sum::<u32>().min(TOO_MUCH);
        1 + match &e.kind {
            ExprKind::Int(_) | ExprKind::Float(_) | ExprKind::Str(_) => 0,
            ExprKind::Var(_) if is_single(e.ty) && e.ty.base != Base::Closure => 0,
            ExprKind::Component(a, b) => sum(&[a, b]),
            ExprKind::Neg(a) | ExprKind::Not(a) | ExprKind::Compl(a) => sum(&[a]),
            ExprKind::Convert(a) | ExprKind::Truth(a) if a.ty.base != Base::Closure => sum(&[a]),
            ExprKind::Binary(op, a, b) if !matches!(op, Op::And | Op::Or) && e.ty.base != Base::Matrix => sum(&[a, b]),
            ExprKind::Field(a, _) => sum(&[a]),
            ExprKind::Construct(parts) if e.ty.base.is_triple() && parts.len() == 3 => {
                parts.iter().map(cost).sum::<u32>().min(TOO_MUCH)
            }
            ExprKind::Var(_) => 0,
            _ => TOO_MUCH,
        }
    }
    e.ty.base != Base::Closure && cost(e) <= 12
}

fn binary_op(op: Op) -> BinaryOp {
    match op {
        Op::Add => BinaryOp::Add,
        Op::Sub => BinaryOp::Sub,
        Op::Mul => BinaryOp::Mul,
        Op::Div => BinaryOp::Div,
        Op::Mod => BinaryOp::Mod,
        Op::Shl => BinaryOp::Shl,
        Op::Shr => BinaryOp::Shr,
        Op::Lt => BinaryOp::Lt,
        Op::Le => BinaryOp::Le,
        Op::Gt => BinaryOp::Gt,
        Op::Ge => BinaryOp::Ge,
        Op::Eq => BinaryOp::Eq,
        Op::Ne => BinaryOp::Ne,
        // Short-circuiting operators are lowered before this; on plain ints their bitwise kin agree.
        Op::BitAnd | Op::And => BinaryOp::BitAnd,
        Op::BitOr | Op::Or => BinaryOp::BitOr,
        Op::BitXor => BinaryOp::BitXor,
    }
}

impl Lower<'_> {
    /// The value of an expression of a single type.
    pub(super) fn expr(&mut self, e: &Expr) -> ValueId {
        let span = e.span;
        match &e.kind {
            ExprKind::Int(v) => self.int(*v, span),
            ExprKind::Float(v) => self.constant(Const::Float(*v), span),
            ExprKind::Str(s) => self.constant(Const::Str(s.clone()), span),
            ExprKind::Var(_) | ExprKind::Index(..) | ExprKind::Field(..) => {
                let place = self.place(e);
                self.load(&place, span)
            }
            ExprKind::Component(of, index) => {
                let base = self.expr(of);
                let index = self.expr(index);
                self.check_component(of, index, span);
                self.value(Inst::Component(base, index), Ty::Float, span)
            }
            ExprKind::Element(of, row, column) => {
                let base = self.expr(of);
                let row = self.expr(row);
                let column = self.expr(column);
                self.check_component(of, row, span);
                self.check_component(of, column, span);
                self.value(Inst::MatrixElement(base, row, column), Ty::Float, span)
            }
            ExprKind::Call(callee, args) => match self.call(callee, args, e) {
                Some(place) => self.load(&place, span),
                None => self.zero(e.ty, span),
            },
            ExprKind::Construct(args) => self.construct(args, e),
            ExprKind::List(_) => {
                let place = self.place(e);
                self.load(&place, span)
            }
            ExprKind::Convert(inner) => self.convert(inner, e.ty, span),
            ExprKind::Truth(inner) => {
                let value = self.expr(inner);
                self.truth(value, span)
            }
            ExprKind::Neg(inner) => {
                let value = self.expr(inner);
                if self.ty_of(value) == Ty::Closure {
                    let minus = self.constant(Const::Float(-1.0), span);
                    return self.value(Inst::ScaleClosure(value, minus), Ty::Closure, span);
                }
                let ty = self.ty_of(value);
                self.value(Inst::Unary(UnaryOp::Neg, value), ty, span)
            }
            ExprKind::Not(inner) => {
                let value = self.expr(inner);
                self.value(Inst::Unary(UnaryOp::Not, value), Ty::Int, span)
            }
            ExprKind::Compl(inner) => {
                let value = self.expr(inner);
                self.value(Inst::Unary(UnaryOp::Compl, value), Ty::Int, span)
            }
            ExprKind::Binary(op @ (Op::And | Op::Or), l, r) => self.logic(*op, l, r, span),
            ExprKind::Binary(op, l, _) => {
                // Walk down a left-deep chain without recursion.
                let mut spine = vec![e];
                let mut at: &Expr = l;
                while let ExprKind::Binary(inner, next, _) = &at.kind {
                    if matches!(inner, Op::And | Op::Or) {
                        break;
                    }
                    spine.push(at);
                    at = next;
                }
                let _ = op;
                let mut left = self.expr(at);
                for node in spine.into_iter().rev() {
                    let ExprKind::Binary(op, _, r) = &node.kind else { continue };
                    let right = self.expr(r);
                    left = self.binary(*op, left, right, node.span);
                }
                left
            }
            ExprKind::IncDec(op, target) => self.inc_dec(*op, target, span),
            ExprKind::Assign(target, value) => {
                let place = self.place(target);
                let right = self.expr(value);
                self.check_finite(&place, right, value);
                self.store(&place, right, span);
                right
            }
            ExprKind::AssignOp(op, target, rhs) => {
                let place = self.place(target);
                let right = self.expr(rhs);
                let old = self.load(&place, span);
                let closure = self.ty_of(old) == Ty::Closure;
                let left = if closure { old } else { self.convert_value(old, self.ty_of(right), span) };
                let sum = self.binary(*op, left, right, span);
                let new = self.convert_value(sum, ir_type(target.ty.base), span);
                self.check_finite(&place, new, e);
                self.store(&place, new, span);
                new
            }
            ExprKind::Ternary(cond, a, b) => {
                let cond = self.expr(cond);
                if is_cheap(a) && is_cheap(b) {
                    let (a, b) = (self.expr(a), self.expr(b));
                    let ty = self.ty_of(a);
                    return self.value(Inst::Select(cond, a, b), ty, span);
                }
                let result = self.temp(ir_type(e.ty.base));
                let branch = |l: &mut Self, e: &Expr| {
                    l.branch(e.span, |l| {
                        let value = l.expr(e);
                        l.push(Stmt::Store(result, value));
                    })
                };
                let then = branch(self, a);
                let otherwise = branch(self, b);
                self.push(Stmt::If(cond, then, otherwise));
                self.guard_rest();
                self.value(Inst::Load(result), ir_type(e.ty.base), span)
            }
            ExprKind::Comma(parts) => match parts.split_last() {
                Some((last, head)) => {
                    head.iter().for_each(|p| self.effect(p));
                    self.expr(last)
                }
                None => self.int(0, span),
            },
        }
    }

    /// An expression for its effect, of any type.
    pub(super) fn effect(&mut self, e: &Expr) {
        match &e.kind {
            ExprKind::Call(callee, args) => {
                self.call(callee, args, e);
            }
            ExprKind::Comma(parts) => parts.iter().for_each(|p| self.effect(p)),
            ExprKind::Assign(target, value) if !is_single(e.ty) => {
                let place = self.place(target);
                // Through a copy when the value reads the target.
                let source = match &value.kind {
                    ExprKind::List(_) => {
                        let at = self.snapshot(value);
                        self.copy(&place, &at, e.span);
                        return;
                    }
                    _ => value,
                };
                self.assign_expr(&place, source);
            }
            _ if is_single(e.ty) && e.ty.base != Base::Void => {
                self.expr(e);
            }
            _ => {
                self.place(e);
            }
        }
    }

    /// Zero, "" or the null closure.
    pub(super) fn zero(&mut self, ty: Type, span: Span) -> ValueId {
        match ir_type(ty.base) {
            Ty::Int => self.int(0, span),
            Ty::Float => self.constant(Const::Float(0.0), span),
            Ty::Triple => self.constant(Const::Triple([0.0; 3]), span),
            Ty::Matrix => self.constant(Const::Matrix([0.0; 16]), span),
            Ty::Str => self.constant(Const::Str(String::new()), span),
            Ty::Closure => self.value(Inst::NullClosure, Ty::Closure, span),
        }
    }

    fn convert(&mut self, inner: &Expr, to: Type, span: Span) -> ValueId {
        if to.base == Base::Closure && inner.ty.base != Base::Closure {
            return self.value(Inst::NullClosure, Ty::Closure, span);
        }
        let value = self.expr(inner);
        self.convert_value(value, ir_type(to.base), span)
    }

    pub(super) fn convert_value(&mut self, value: ValueId, to: Ty, span: Span) -> ValueId {
        let from = self.ty_of(value);
        if from == to {
            return value;
        }
        if from == Ty::Int && matches!(to, Ty::Triple | Ty::Matrix) {
            let float = self.value(Inst::Convert(value), Ty::Float, span);
            return self.value(Inst::Convert(float), to, span);
        }
        self.value(Inst::Convert(value), to, span)
    }

    fn truth(&mut self, value: ValueId, span: Span) -> ValueId {
        let zero = match self.ty_of(value) {
            Ty::Int => self.int(0, span),
            Ty::Float => self.constant(Const::Float(0.0), span),
            Ty::Triple => self.constant(Const::Triple([0.0; 3]), span),
            Ty::Matrix => self.constant(Const::Matrix([0.0; 16]), span),
            Ty::Str => self.constant(Const::Str(String::new()), span),
            Ty::Closure => return self.value(Inst::ClosureIsSet(value), Ty::Int, span),
        };
        self.value(Inst::Binary(BinaryOp::Ne, value, zero), Ty::Int, span)
    }

    pub(super) fn binary(&mut self, op: Op, l: ValueId, r: ValueId, span: Span) -> ValueId {
        let (lt, rt) = (self.ty_of(l), self.ty_of(r));
        if lt == Ty::Closure || rt == Ty::Closure {
            return match (op, lt, rt) {
                (Op::Mul, Ty::Closure, _) => self.value(Inst::ScaleClosure(l, r), Ty::Closure, span),
                (Op::Mul, _, _) => self.value(Inst::ScaleClosure(r, l), Ty::Closure, span),
                _ => self.value(Inst::AddClosure(l, r), Ty::Closure, span),
            };
        }
        let comparison = matches!(op, Op::Lt | Op::Le | Op::Gt | Op::Ge | Op::Eq | Op::Ne);
        let ty = if comparison { Ty::Int } else { lt };
        self.value(Inst::Binary(binary_op(op), l, r), ty, span)
    }

    fn logic(&mut self, op: Op, l: &Expr, r: &Expr, span: Span) -> ValueId {
        let left = self.expr(l);
        let left = self.as_bool(left, span);
        if is_cheap(r) {
            let right = self.expr(r);
            let right = self.as_bool(right, span);
            return self.value(Inst::Binary(binary_op(op), left, right), Ty::Int, span);
        }
        let result = self.temp(Ty::Int);
        self.push(Stmt::Store(result, left));
        let right = self.branch(r.span, |l| {
            let value = l.expr(r);
            let value = l.as_bool(value, span);
            l.push(Stmt::Store(result, value));
        });
        let (then, otherwise) = if op == Op::And { (right, Block::default()) } else { (Block::default(), right) };
        self.push(Stmt::If(left, then, otherwise));
        self.guard_rest();
        self.value(Inst::Load(result), Ty::Int, span)
    }

    /// 0 or 1. Comparisons are so already.
    fn as_bool(&mut self, value: ValueId, span: Span) -> ValueId {
        use BinaryOp::{Eq, Ge, Gt, Le, Lt, Ne};
        match &self.out.values[value.0 as usize].inst {
            Inst::Binary(Eq | Ne | Lt | Le | Gt | Ge, ..) | Inst::Unary(UnaryOp::Not, _) | Inst::ClosureIsSet(_) => {
                value
            }
            _ => self.truth(value, span),
        }
    }

    fn inc_dec(&mut self, op: IncDecOp, target: &Expr, span: Span) -> ValueId {
        let place = self.place(target);
        let old = self.load(&place, span);
        let ty = self.ty_of(old);
        let one = match ty {
            Ty::Int => self.int(1, span),
            _ => self.constant(Const::Float(1.0), span),
        };
        let (operator, post) = match op {
            IncDecOp::PreInc => (BinaryOp::Add, false),
            IncDecOp::PreDec => (BinaryOp::Sub, false),
            IncDecOp::PostInc => (BinaryOp::Add, true),
            IncDecOp::PostDec => (BinaryOp::Sub, true),
        };
        let new = self.value(Inst::Binary(operator, old, one), ty, span);
        self.store(&place, new, span);
        if post { old } else { new }
    }

    /// A read-only array for a call: the variable itself, or a fresh one that holds the value.
    pub(super) fn array(&mut self, e: &Expr) -> Option<crate::ir::LocalId> {
        match self.place(e) {
            Place::Stored(super::Storage::Local(local), None) => Some(local),
            _ => None,
        }
    }

    /// A fresh array with these values.
    pub(super) fn array_of(&mut self, values: &[ValueId], ty: Ty, span: Span) -> crate::ir::LocalId {
        let local = self.local("knots", ty, Some(values.len() as u32), LocalKind::Variable);
        for (i, value) in values.iter().enumerate() {
            let index = self.int(i as i32, span);
            self.push(Stmt::StoreElem(local, index, *value));
        }
        local
    }
}
