//! The types of operators (OSL specification ch. 5 and 6).

use super::Checker;
use super::typed::{Expr, ExprKind};
use crate::ast::{BinaryOp, UnaryOp};
use crate::diag::Diagnostic;
use crate::source::Span;
use crate::types::{Base, Type};

/// The method name of an operator on structs: `__operator__add__`.
fn overload_name(op: BinaryOp) -> Option<String> {
    use BinaryOp::*;
    let word = match op {
        Mul => "mul",
        Div => "div",
        Mod => "mod",
        Add => "add",
        Sub => "sub",
        Shl => "shl",
        Shr => "shr",
        Lt => "lt",
        Le => "le",
        Gt => "gt",
        Ge => "ge",
        Eq => "eq",
        Ne => "neq",
        BitAnd => "bitand",
        BitXor => "xor",
        BitOr => "bitor",
        And | Or => return None,
    };
    Some(format!("__operator__{word}__"))
}

/// The wider of two numeric types; triples of different kinds follow the left one, but a point stays a point.
fn wider(l: Base, r: Base) -> Base {
    let rank = |b: Base| match b {
        Base::Int => 0,
        Base::Float => 1,
        b if b.is_triple() => 2,
        _ => 3,
    };
    match rank(l).cmp(&rank(r)) {
        std::cmp::Ordering::Less => r,
        std::cmp::Ordering::Greater => l,
        std::cmp::Ordering::Equal => l,
    }
}

fn is_number(ty: Type) -> bool {
    !ty.is_array() && (matches!(ty.base, Base::Int | Base::Float | Base::Matrix) || ty.base.is_triple())
}

impl Checker {
    pub(super) fn unary(&mut self, op: UnaryOp, inner: Expr, span: Span) -> Option<Expr> {
        let ty = inner.ty;
        if let (Base::Struct(_), false) = (ty.base, ty.is_array()) {
            let word = match op {
                UnaryOp::Neg => "neg",
                UnaryOp::Compl => "compl",
                UnaryOp::Not => "not",
                UnaryOp::Plus => "",
            };
            let name = format!("__operator__{word}__");
            if !self.scopes.functions(&name).is_empty() {
                return self.call_named(&name, span, vec![inner], None);
            }
        }
        let numeric = is_number(ty);
        let (kind, ty) = match op {
            UnaryOp::Plus if numeric || ty == Type::scalar(Base::Closure) => return Some(inner),
            UnaryOp::Neg if numeric || ty == Type::scalar(Base::Closure) => {
                // A negative literal is a literal.
                let kind = match inner.kind {
                    ExprKind::Int(v) => ExprKind::Int(v.wrapping_neg()),
                    ExprKind::Float(v) => ExprKind::Float(-v),
                    kind => ExprKind::Neg(Box::new(Expr { kind, ty, span: inner.span })),
                };
                (kind, ty)
            }
            UnaryOp::Not => {
                let truth = self.truth(inner)?;
                (ExprKind::Not(Box::new(truth)), Type::INT)
            }
            UnaryOp::Compl if ty == Type::INT => (ExprKind::Compl(Box::new(inner)), Type::INT),
            _ => {
                let symbol = match op {
                    UnaryOp::Neg => "-",
                    UnaryOp::Plus => "+",
                    UnaryOp::Not => "!",
                    UnaryOp::Compl => "~",
                };
                let message = format!("`{symbol}` does not take {}", self.show(ty));
                return self.fail(Diagnostic::error("E2003", span, message));
            }
        };
        Some(Expr { kind, ty, span })
    }

    pub(super) fn binary(&mut self, op: BinaryOp, l: Expr, r: Expr, span: Span) -> Option<Expr> {
        if matches!(op, BinaryOp::And | BinaryOp::Or) {
            let (l, r) = (self.truth(l)?, self.truth(r)?);
            return Some(Expr { kind: ExprKind::Binary(op, Box::new(l), Box::new(r)), ty: Type::INT, span });
        }
        let is_struct = |t: Type| matches!(t.base, Base::Struct(_)) && !t.is_array();
        if (is_struct(l.ty) || is_struct(r.ty))
            && let Some(name) = overload_name(op).filter(|n| !self.scopes.functions(n).is_empty())
        {
            return self.call_named(&name, span, vec![l, r], None);
        }
        match self.operand_type(op, l.ty, r.ty) {
            Some((operand, result)) => {
                // A closure's factor keeps its own type.
                let closure = Type::scalar(Base::Closure);
                let keep = |e: &Expr| operand == closure && e.ty != closure;
                let (kl, kr) = (keep(&l), keep(&r));
                let l = if kl { self.factor(l)? } else { self.convert(l, operand, "this operand")? };
                let r = if kr { self.factor(r)? } else { self.convert(r, operand, "this operand")? };
                Some(Expr { kind: ExprKind::Binary(op, Box::new(l), Box::new(r)), ty: result, span })
            }
            None => {
                let message = format!("`{}` does not take {} and {}", op.symbol(), self.show(l.ty), self.show(r.ty));
                let mut d = Diagnostic::error("E2003", span, message)
                    .label(l.span, format!("this is {}", self.show(l.ty)))
                    .label(r.span, format!("this is {}", self.show(r.ty)));
                let has = |base| l.ty.base == base || r.ty.base == base;
                if has(Base::Closure) {
                    d = d.help("closures can be added to each other and multiplied by a float or a color, no more");
                } else if op == BinaryOp::Add && l.ty == Type::STRING && r.ty == Type::STRING {
                    d = d.help("use `concat`, or write string literals side by side");
                } else if l.ty.is_array() || r.ty.is_array() {
                    d = d.help("operators take elements of arrays, not arrays");
                } else if is_struct(l.ty)
                    && let Some(name) = overload_name(op)
                {
                    d = d.help(format!("define `{name}` to give the struct this operator"));
                }
                self.fail(d)
            }
        }
    }

    /// The factor of a closure: float or color.
    fn factor(&mut self, e: Expr) -> Option<Expr> {
        let to = if e.ty == Type::INT { Type::FLOAT } else { e.ty };
        self.convert(e, to, "a closure's factor")
    }

    /// The type that both operands convert to, and the result's.
    fn operand_type(&self, op: BinaryOp, l: Type, r: Type) -> Option<(Type, Type)> {
        use BinaryOp::*;
        if l.is_array() || r.is_array() {
            return None;
        }
        let (closure, same) = (Base::Closure, l.base == r.base);
        if l.base == closure || r.base == closure {
            let other = if l.base == closure { r.base } else { l.base };
            let fits = match op {
                Add => same,
                Mul => !same && matches!(other, Base::Int | Base::Float | Base::Color),
                _ => false,
            };
            let triple_factor = op == Mul && !same && other.is_triple();
            return (fits || triple_factor).then_some((Type::scalar(closure), Type::scalar(closure)));
        }
        match op {
            Eq | Ne if l.base == Base::String && same => return Some((Type::STRING, Type::INT)),
            Mod | Shl | Shr | BitAnd | BitXor | BitOr => {
                return (l == Type::INT && r == Type::INT).then_some((Type::INT, Type::INT));
            }
            _ => {}
        }
        if !is_number(l) || !is_number(r) {
            return None;
        }
        let wide = wider(l.base, r.base);
        match op {
            Lt | Le | Gt | Ge => matches!(wide, Base::Int | Base::Float).then_some((Type::scalar(wide), Type::INT)),
            Eq | Ne => {
                let mixes = wide == Base::Matrix && (l.base.is_triple() || r.base.is_triple());
                (!mixes).then_some((Type::scalar(wide), Type::INT))
            }
            Mul | Div | Add | Sub => {
                if wide == Base::Matrix {
                    let triple = l.base.is_triple() || r.base.is_triple();
                    let ok = matches!(op, Mul | Div) && !triple;
                    return ok.then_some((Type::scalar(wide), Type::scalar(wide)));
                }
                // Differences of points are vectors; any other triple added to a point or taken from it gives a point.
                let both = l.base.is_triple() && r.base.is_triple();
                let result = match [l.base, r.base].map(|b| b == Base::Point) {
                    [true, true] if op == Sub => Base::Vector,
                    [false, false] => wide,
                    _ if both && matches!(op, Add | Sub) => Base::Point,
                    _ => wide,
                };
                Some((Type::scalar(wide), Type::scalar(result)))
            }
            _ => None,
        }
    }
}
