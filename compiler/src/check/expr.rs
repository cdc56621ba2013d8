//! Expressions.

use super::Checker;
use super::scope::Symbol;
use super::typed::{Expr, ExprKind, VarKind};
use crate::ast::{self, BinaryOp};
use crate::diag::Diagnostic;
use crate::source::Span;
use crate::types::{Base, Extent, Type};

impl Checker {
    /// `wanted` is the type that the context would like: it decides among overloads that differ in the result only.
    pub(super) fn expr(&mut self, e: &ast::Expr, wanted: Option<Type>) -> Option<Expr> {
        let expr = self.expr_or_row(e, wanted)?;
        if matches!(&expr.kind, ExprKind::Element(_, _, column) if is_missing(column)) {
            let d = Diagnostic::error("E2003", expr.span, "a row of a matrix is no value");
            return self.fail(d.help("give both indices: `m[row][column]`"));
        }
        Some(expr)
    }

    /// As [`Checker::expr`], or a matrix that was indexed once only.
    fn expr_or_row(&mut self, e: &ast::Expr, wanted: Option<Type>) -> Option<Expr> {
        let span = e.span;
        let (kind, ty) = match &e.kind {
            ast::ExprKind::Int(v) => (ExprKind::Int(*v), Type::INT),
            ast::ExprKind::Float(v) => (ExprKind::Float(*v), Type::FLOAT),
            ast::ExprKind::Str(s) => (ExprKind::Str(s.clone()), Type::STRING),
            ast::ExprKind::Name(name) => return self.name(name, span),
            ast::ExprKind::Index { base, index } => return self.index(base, index, span),
            ast::ExprKind::Field { base, field } => return self.field(base, field, span),
            ast::ExprKind::Call { callee, args } => return self.call(callee, args, span, wanted),
            ast::ExprKind::Construct { ty, args } => {
                let base = self.base(ty)?;
                return self.construct(base, args, span);
            }
            ast::ExprKind::Cast { ty, expr } => {
                let base = self.base(ty)?;
                let inner = self.expr(expr, Some(Type::scalar(base)))?;
                return self.cast(inner, base, span);
            }
            ast::ExprKind::Unary { op, expr } => {
                let inner = self.expr(expr, wanted)?;
                return self.unary(*op, inner, span);
            }
            ast::ExprKind::IncDec { op, expr } => {
                let inner = self.expr(expr, None)?;
                if inner.ty != Type::INT && inner.ty != Type::FLOAT {
                    let message = format!("`++` and `--` do not take {}", self.show(inner.ty));
                    return self.fail(Diagnostic::error("E2003", span, message));
                }
                self.require_lvalue(&inner)?;
                let ty = inner.ty;
                (ExprKind::IncDec(*op, Box::new(inner)), ty)
            }
            ast::ExprKind::Binary { .. } => return self.binary_chain(e, wanted),
            ast::ExprKind::Assign { op, lhs, rhs } => return self.assign(*op, lhs, rhs, span),
            ast::ExprKind::Ternary { cond, then, otherwise } => {
                let cond = self.expr(cond, Some(Type::INT)).and_then(|c| self.truth(c));
                let then = self.expr(then, wanted);
                let otherwise = self.expr(otherwise, wanted);
                let (cond, then, otherwise) = (cond?, then?, otherwise?);
                let ty = self.common_type(&then, &otherwise, span)?;
                let then = self.convert(then, ty, "this branch")?;
                let otherwise = self.convert(otherwise, ty, "this branch")?;
                (ExprKind::Ternary(Box::new(cond), Box::new(then), Box::new(otherwise)), ty)
            }
            ast::ExprKind::Comma(parts) => {
                let last = parts.len().saturating_sub(1);
                let typed: Vec<Option<Expr>> = parts
                    .iter()
                    .enumerate()
                    .map(|(i, p)| self.expr(p, if i == last { wanted } else { None }))
                    .collect();
                let typed = typed.into_iter().collect::<Option<Vec<_>>>()?;
                let ty = typed.last()?.ty;
                (ExprKind::Comma(typed), ty)
            }
        };
        Some(Expr { kind, ty, span })
    }

    /// A left-deep chain of operators, without recursion along its spine.
    fn binary_chain(&mut self, e: &ast::Expr, wanted: Option<Type>) -> Option<Expr> {
        let mut spine = Vec::new();
        let mut at = e;
        while let ast::ExprKind::Binary { op, lhs, rhs } = &at.kind {
            spine.push((*op, rhs, at.span));
            at = lhs;
        }
        let mut left = self.expr(at, wanted);
        for (op, rhs, span) in spine.into_iter().rev() {
            let hint = if matches!(op, BinaryOp::And | BinaryOp::Or) { None } else { wanted };
            let right = self.expr(rhs, hint);
            left = match (left, right) {
                (Some(l), Some(r)) => self.binary(op, l, r, span),
                _ => None,
            };
        }
        left
    }

    fn name(&mut self, name: &str, span: Span) -> Option<Expr> {
        match self.scopes.find(name) {
            Some(Symbol::Var(id)) => {
                let id = *id;
                Some(Expr { kind: ExprKind::Var(id), ty: self.var(id).ty, span })
            }
            Some(Symbol::Functions(_)) => self.fail(
                Diagnostic::error("E2001", span, format!("`{name}` is a function, not a variable"))
                    .help("add `(...)` to call it"),
            ),
            Some(Symbol::Struct(_)) => {
                self.fail(Diagnostic::error("E2001", span, format!("`{name}` is a struct, not a variable")))
            }
            Some(Symbol::Broken) => None,
            None => {
                let mut d = Diagnostic::error("E2001", span, format!("there is no variable `{name}` here"));
                let near = crate::suggest::closest(name, self.scopes.names(|s| matches!(s, Symbol::Var(_))));
                if let Some(near) = near {
                    d = d.help(format!("did you mean `{near}`?"));
                }
                self.fail(d)
            }
        }
    }

    fn index(&mut self, base: &ast::Expr, index: &ast::Expr, span: Span) -> Option<Expr> {
        let base_expr = self.expr_or_row(base, None);
        let index_expr = self.expr(index, None);
        let (base, index) = (base_expr?, index_expr?);
        let index = self.convert(index, Type::INT, "an index")?;
        if let ExprKind::Int(i) = index.kind {
            let open = matches!(base.kind, ExprKind::Var(id) if self.open.contains(&id));
            let len = match (base.ty.extent, base.ty.base) {
                (Extent::Fixed(_), _) if open => None,
                (Extent::Fixed(n), _) => Some(n as i64),
                (Extent::Scalar, b) if b.is_triple() => Some(3),
                (Extent::Scalar, Base::Matrix) => Some(4),
                _ => None,
            };
            if let Some(len) = len.filter(|n| i < 0 || i as i64 >= *n) {
                let message =
                    format!("index {i} is out of range: {} has elements 0 to {}", self.show(base.ty), len - 1);
                self.warn(Diagnostic::warning("W2002", index.span, message));
            }
        }
        if base.ty.is_array() {
            let ty = Type::scalar(base.ty.base);
            return Some(Expr { kind: ExprKind::Index(Box::new(base), Box::new(index)), ty, span });
        }
        if base.ty.base.is_triple() {
            return Some(Expr { kind: ExprKind::Component(Box::new(base), Box::new(index)), ty: Type::FLOAT, span });
        }
        if base.ty.base == Base::Matrix {
            // `M[r]` alone is a row, which is no value: the second index must follow at once.
            return Some(Expr {
                kind: ExprKind::Element(Box::new(base), Box::new(index), Box::new(missing_column(span))),
                ty: Type::scalar(Base::Void),
                span,
            });
        }
        if base.ty.base == Base::Void
            && let ExprKind::Element(matrix, row, _) = base.kind
        {
            let kind = ExprKind::Element(matrix, row, Box::new(index));
            return Some(Expr { kind, ty: Type::FLOAT, span });
        }
        let message = format!("{} cannot be indexed", self.show(base.ty));
        self.fail(Diagnostic::error("E2003", span, message))
    }

    fn field(&mut self, base: &ast::Expr, field: &ast::Ident, span: Span) -> Option<Expr> {
        let base = self.expr(base, None)?;
        if base.ty.is_array() {
            let message = format!("{} is an array and has no `.{}`", self.show(base.ty), field.name);
            return self.fail(Diagnostic::error("E2012", field.span, message).help("index it first"));
        }
        if let Base::Struct(id) = base.ty.base {
            let fields = &self.structs[id.0 as usize].fields;
            if let Some(i) = fields.iter().position(|(n, _)| *n == field.name) {
                let ty = fields[i].1;
                return Some(Expr { kind: ExprKind::Field(Box::new(base), i as u32), ty, span });
            }
            let mut d = Diagnostic::error(
                "E2012",
                field.span,
                format!("struct `{}` has no field `{}`", self.show(base.ty), field.name),
            );
            let near = crate::suggest::closest(&field.name, fields.iter().map(|(n, _)| n.as_str())).map(str::to_string);
            if let Some(near) = near {
                d = d.help(format!("did you mean `{near}`?"));
            }
            return self.fail(d);
        }
        let letters = if base.ty.base == Base::Color { "rgb" } else { "xyz" };
        if base.ty.base.is_triple()
            && let (Some(i), 1) = (letters.find(&field.name), field.name.len())
        {
            let index = Expr { kind: ExprKind::Int(i as i32), ty: Type::INT, span: field.span };
            return Some(Expr { kind: ExprKind::Component(Box::new(base), Box::new(index)), ty: Type::FLOAT, span });
        }
        let message = format!("{} has no field `{}`", self.show(base.ty), field.name);
        let mut d = Diagnostic::error("E2012", field.span, message);
        if base.ty.base.is_triple() {
            let (a, b) = letters.split_at(1);
            d = d.help(format!("the components are .{a}, .{} and .{}", &b[..1], &b[1..]));
        }
        self.fail(d)
    }

    fn cast(&mut self, inner: Expr, base: Base, span: Span) -> Option<Expr> {
        let to = Type::scalar(base);
        if inner.ty == to {
            return Some(Expr { span, ..inner });
        }
        let narrowing = to == Type::INT && inner.ty == Type::FLOAT;
        if narrowing || (base != Base::Closure && self.fits(to, inner.ty)) {
            return Some(Expr { kind: ExprKind::Convert(Box::new(inner)), ty: to, span });
        }
        let message = format!("{} cannot be cast to {}", self.show(inner.ty), self.show(to));
        self.fail(Diagnostic::error("E2003", span, message))
    }

    /// The type of `c ? a : b`.
    fn common_type(&mut self, a: &Expr, b: &Expr, span: Span) -> Option<Type> {
        let closure = Type::scalar(Base::Closure);
        if a.ty == b.ty || (a.ty == closure && matches!(b.kind, ExprKind::Int(0))) {
            return Some(a.ty);
        }
        if b.ty == closure && matches!(a.kind, ExprKind::Int(0)) {
            return Some(closure);
        }
        // Among triples the second one's, as in the reference implementation.
        let triples = a.ty.base.is_triple() && b.ty.base.is_triple();
        if self.fits(a.ty, b.ty) && !a.ty.is_array() && !triples {
            return Some(a.ty);
        }
        if self.fits(b.ty, a.ty) && !b.ty.is_array() {
            return Some(b.ty);
        }
        let message = format!("the branches of `?:` differ: {} and {}", self.show(a.ty), self.show(b.ty));
        self.fail(Diagnostic::error("E2003", span, message))
    }

    /// Reports what cannot be assigned.
    pub(super) fn require_lvalue(&mut self, e: &Expr) -> Option<()> {
        match &e.kind {
            ExprKind::Var(id) => {
                let var = self.var(*id);
                // Of parameters of the shader `check_writes` knows more.
                if var.writable || matches!(var.kind, VarKind::ShaderParam(_)) {
                    return Some(());
                }
                // As the reference implementation: said, but done.
                let (what, help) = match var.kind {
                    VarKind::Global => {
                        ("a global variable that shaders should only read", "copy it to a variable of your own")
                    }
                    _ => ("a parameter without `output`", "declare it `output`, or copy it to a variable"),
                };
                let message = format!("`{}` is {what}, and is written here", var.name);
                let mut d = Diagnostic::warning("W2004", e.span, message).help(help);
                if var.kind != VarKind::Global {
                    d = d.label(var.span, "declared here");
                }
                self.warn(d);
                Some(())
            }
            ExprKind::Index(base, _) | ExprKind::Component(base, _) | ExprKind::Field(base, _) => {
                self.require_lvalue(base)
            }
            ExprKind::Element(base, _, column) if e.ty != Type::VOID || !is_missing(column) => {
                self.require_lvalue(base)
            }
            _ => self.fail(
                Diagnostic::error("E2006", e.span, "this cannot be assigned")
                    .help("only variables, their elements, components and fields can"),
            ),
        }
    }

    fn assign(&mut self, op: Option<BinaryOp>, lhs: &ast::Expr, rhs: &ast::Init, span: Span) -> Option<Expr> {
        let target = self.expr(lhs, None)?;
        self.require_lvalue(&target)?;
        let ty = target.ty;
        let Some(op) = op else {
            let value = self.assigned(rhs, ty, "the assignment")?;
            return Some(Expr { kind: ExprKind::Assign(Box::new(target), Box::new(value)), ty, span });
        };
        let ast::Init::Expr(rhs) = rhs else {
            return self.fail(Diagnostic::error("E2003", span, format!("`{}=` takes no list", op.symbol())));
        };
        let value = self.expr(rhs, Some(ty))?;
        // Typed as `target op value`, then taken apart again: the target is evaluated once only.
        let place = Expr { kind: target.kind.clone(), ty, span: target.span };
        let sum = self.binary(op, place, value, span)?;
        let scalar_to_int = ty == Type::INT && sum.ty == Type::FLOAT;
        if !scalar_to_int && !self.fits(ty, sum.ty) {
            let message = format!(
                "the result of `{}` is {}, which does not fit {}",
                op.symbol(),
                self.show(sum.ty),
                self.show(ty)
            );
            return self.fail(Diagnostic::error("E2003", span, message));
        }
        if let ExprKind::Call(..) = sum.kind {
            // An overloaded operator of a struct: a plain assignment of the call's result.
            return Some(Expr { kind: ExprKind::Assign(Box::new(target), Box::new(sum)), ty, span });
        }
        let ExprKind::Binary(op, _, right) = sum.kind else {
            return self.fail(Diagnostic::error("E2003", span, "this operator cannot be combined with `=`"));
        };
        Some(Expr { kind: ExprKind::AssignOp(op, Box::new(target), right), ty, span })
    }

    /// `float(...)`, `color(...)`, `matrix(...)` and the like.
    pub(super) fn construct(&mut self, base: Base, args: &[ast::Init], span: Span) -> Option<Expr> {
        let ty = Type::scalar(base);
        let hint = match base {
            Base::Float => Some(Type::FLOAT),
            b if b.is_triple() => Some(if args.len() == 1 { ty } else { Type::FLOAT }),
            _ => None,
        };
        let mut typed = Vec::new();
        for arg in args {
            typed.push(match arg {
                ast::Init::Expr(e) => self.expr(e, hint),
                ast::Init::List(_, at) => self.fail(Diagnostic::error("E2003", *at, "a list cannot stand here")),
            });
        }
        let typed = typed.into_iter().collect::<Option<Vec<_>>>()?;
        self.construct_typed(base, typed, span)
    }

    /// As [`Checker::construct`], of values whose types are known.
    pub(super) fn construct_typed(&mut self, base: Base, typed: Vec<Expr>, span: Span) -> Option<Expr> {
        let ty = Type::scalar(base);
        let strings = typed.iter().take_while(|e| e.ty == Type::STRING).count();
        let numbers = typed.len() - strings;
        if strings == 0 && numbers == 1 && matches!(base, Base::Int | Base::Float | Base::String)
            || typed.len() == 1 && strings == 0
        {
            let only = typed.into_iter().next()?;
            // A value of its own, while `(float)k` is the variable.
            if only.ty == ty && only.is_place() {
                return Some(Expr { kind: ExprKind::Convert(Box::new(only)), ty, span });
            }
            return self.cast(only, base, span);
        }
        let fits = match base {
            b if b.is_triple() => (strings == 0 && numbers == 3) || (strings == 1 && (numbers == 3 || numbers == 1)),
            Base::Matrix => match strings {
                0 => numbers == 16,
                1 => numbers == 16 || numbers == 1,
                2 => numbers == 0,
                _ => false,
            },
            _ => false,
        };
        if !fits {
            let given: Vec<String> = typed.iter().map(|e| self.show(e.ty)).collect();
            let forms = match base {
                Base::Matrix => "16 floats, one float, a space and 16 floats or one, or two spaces",
                b if b.is_triple() => "one value, three floats, or a space and three floats",
                _ => "one value",
            };
            let message = format!("{} cannot be made from ({})", ty.base.keyword(), given.join(", "));
            return self.fail(Diagnostic::error("E2004", span, message).help(format!("it takes {forms}")));
        }
        let mut parts = Vec::new();
        for e in typed {
            let to = if e.ty == Type::STRING { Type::STRING } else { Type::FLOAT };
            parts.push(self.convert(e, to, "a component")?);
        }
        Some(Expr { kind: ExprKind::Construct(parts), ty, span })
    }
}

/// Stands for the column of a matrix that was indexed once only; replaced by the second index.
fn missing_column(span: Span) -> Expr {
    Expr { kind: ExprKind::Comma(Vec::new()), ty: Type::VOID, span }
}

fn is_missing(e: &Expr) -> bool {
    matches!(&e.kind, ExprKind::Comma(parts) if parts.is_empty())
}
