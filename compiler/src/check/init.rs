//! Initial values: expressions and `{ ... }` lists against a wanted type.

use super::Checker;
use super::typed::{Expr, ExprKind};
use crate::ast;
use crate::diag::Diagnostic;
use crate::source::Span;
use crate::types::{Base, Extent, Type};

/// An initial value whose parts have types, before it is known what it is for.
pub(super) enum Given {
    /// A value.
    Value(Expr),
    /// `{ ... }`
    List(Vec<Given>, Span),
}

impl Given {
    pub fn span(&self) -> Span {
        match self {
            Given::Value(e) => e.span,
            Given::List(_, span) => *span,
        }
    }
}

impl Checker {
    /// `init` as a value of type `ty`. The result of an unsized array type has its length.
    pub(super) fn initial(&mut self, init: &ast::Init, ty: Type, what: &str) -> Option<Expr> {
        match init {
            ast::Init::Expr(e) => {
                // `T a[1] = value` and `T a[] = value`: one value for the first element.
                let element = Type::scalar(ty.base);
                let expr = self.expr(e, Some(if ty.is_array() { element } else { ty }))?;
                if ty.is_array() && !expr.ty.is_array() {
                    let message = format!("{what} is an array and needs a list");
                    return self.fail(Diagnostic::error("E2011", expr.span, message).help("write `{ value, ... }`"));
                }
                self.convert(expr, ty, what)
            }
            ast::Init::List(items, span) => self.list(items, *span, ty, what),
        }
    }

    /// As [`Checker::initial`] for what is assigned: an int takes a float there, with a warning.
    pub(super) fn assigned(&mut self, init: &ast::Init, ty: Type, what: &str) -> Option<Expr> {
        let ast::Init::Expr(e) = init else { return self.initial(init, ty, what) };
        if ty != Type::INT {
            return self.initial(init, ty, what);
        }
        let expr = self.expr(e, Some(ty))?;
        if expr.ty != Type::FLOAT {
            return self.convert(expr, ty, what);
        }
        let message = format!("{what} is int, and the fraction of this float is cut off");
        self.warn(Diagnostic::warning("W2005", expr.span, message).help("write `(int)` before it to say so"));
        let span = expr.span;
        Some(Expr { kind: ExprKind::Convert(Box::new(expr)), ty, span })
    }

    /// A list whose parts have types already, as a value of type `ty`. All fields and elements must be given.
    pub(super) fn fill(&mut self, given: Given, ty: Type, what: &str) -> Option<Expr> {
        let (items, span) = match given {
            Given::Value(e) => return self.convert(e, ty, what),
            Given::List(items, span) => (items, span),
        };
        let types: Vec<Type> = match (ty.base, ty.extent) {
            (base, Extent::Fixed(_) | Extent::Unsized) => vec![Type::scalar(base); items.len()],
            (Base::Struct(id), _) => self.structs[id.0 as usize].fields.iter().map(|f| f.1).collect(),
            (base, _) => {
                let values = items.into_iter().map(|i| match i {
                    Given::Value(e) => Some(e),
                    Given::List(..) => None,
                });
                return self.construct_typed(base, values.collect::<Option<Vec<_>>>()?, span);
            }
        };
        let extent = match ty.extent {
            Extent::Unsized => Extent::Fixed(items.len() as u32),
            extent => extent,
        };
        let parts = items.into_iter().zip(types).map(|(item, ty)| self.fill(item, ty, what));
        let parts = parts.collect::<Option<Vec<_>>>()?;
        Some(Expr { kind: ExprKind::List(parts), ty: Type { base: ty.base, extent }, span })
    }

    /// Whether [`Checker::fill`] would succeed.
    pub(super) fn fills(&self, given: &Given, ty: Type) -> bool {
        let items = match given {
            Given::Value(e) => return self.converts(e, ty),
            Given::List(items, _) => items,
        };
        let element = Type::scalar(ty.base);
        match (ty.base, ty.extent) {
            (_, Extent::Fixed(n)) => items.len() == n as usize && items.iter().all(|i| self.fills(i, element)),
            (_, Extent::Unsized) => !items.is_empty() && items.iter().all(|i| self.fills(i, element)),
            (Base::Struct(id), _) => {
                let fields = &self.structs[id.0 as usize].fields;
                items.len() == fields.len() && items.iter().zip(fields).all(|(i, f)| self.fills(i, f.1))
            }
            (base, _) => {
                let of = |i: &Given, types: &[Type]| matches!(i, Given::Value(e) if types.contains(&e.ty));
                let number = |i: &Given| of(i, &[Type::INT, Type::FLOAT]);
                let strings = items.iter().take_while(|i| of(i, &[Type::STRING])).count();
                let numbers = items.len() - strings;
                if !items[strings..].iter().all(number) {
                    // One triple or matrix makes another.
                    let same =
                        |e: &Expr| !e.ty.is_array() && (e.ty.base == base || base.is_triple() && e.ty.base.is_triple());
                    return matches!(items.as_slice(), [Given::Value(e)] if same(e) && base != Base::String);
                }
                match base {
                    Base::Int | Base::Float => strings == 0 && numbers == 1,
                    Base::Matrix => matches!((strings, numbers), (0 | 1, 1 | 16) | (2, 0)),
                    b if b.is_triple() => matches!((strings, numbers), (0, 1 | 3) | (1, 3)),
                    _ => false,
                }
            }
        }
    }

    /// The types of an argument's parts, before it is known what it is for.
    pub(super) fn given(&mut self, init: &ast::Init, wanted: Option<Type>) -> Option<Given> {
        match init {
            ast::Init::Expr(e) => self.expr(e, wanted).map(Given::Value),
            ast::Init::List(items, span) => {
                let parts: Vec<Option<Given>> = items.iter().map(|i| self.given(i, None)).collect();
                Some(Given::List(parts.into_iter().collect::<Option<Vec<_>>>()?, *span))
            }
        }
    }

    fn list(&mut self, items: &[ast::Init], span: Span, ty: Type, what: &str) -> Option<Expr> {
        if ty.is_array() {
            return self.array_list(items, span, ty, what);
        }
        match ty.base {
            Base::Struct(id) => {
                let fields = self.structs[id.0 as usize].fields.clone();
                // The fields behind the last value stay undefined.
                if items.is_empty() || items.len() > fields.len() {
                    let message = format!(
                        "{what}: struct `{}` has {}, but {} given",
                        self.show(ty),
                        counted(fields.len(), "field"),
                        given(items.len())
                    );
                    return self.fail(Diagnostic::error("E2012", span, message));
                }
                let mut out = Vec::new();
                for (item, (name, field)) in items.iter().zip(&fields) {
                    out.push(self.initial(item, *field, &format!("field `{name}`"))?);
                }
                Some(Expr { kind: ExprKind::List(out), ty, span })
            }
            // `color c = {1, 2, 3}` is `color(1, 2, 3)`.
            Base::Closure | Base::Void => {
                let message = format!("{what}: {} takes no list", self.show(ty));
                self.fail(Diagnostic::error("E2003", span, message))
            }
            _ => self.construct(ty.base, items, span),
        }
    }

    fn array_list(&mut self, items: &[ast::Init], span: Span, ty: Type, what: &str) -> Option<Expr> {
        let element = Type::scalar(ty.base);
        if let Extent::Fixed(n) = ty.extent
            && items.len() > n as usize
        {
            let message = format!("{what} has {}, but {} given", counted(n as usize, "element"), given(items.len()));
            return self.fail(Diagnostic::error("E2011", span, message));
        }
        if items.is_empty() {
            return self.fail(Diagnostic::error("E2011", span, format!("{what} needs at least one value")));
        }
        let mut out = Vec::with_capacity(items.len());
        for item in items {
            out.push(self.initial(item, element, &format!("an element of {what}"))?);
        }
        let extent = match ty.extent {
            Extent::Unsized => Extent::Fixed(out.len() as u32),
            extent => extent,
        };
        Some(Expr { kind: ExprKind::List(out), ty: Type { base: ty.base, extent }, span })
    }
}

/// `1 field`, `2 fields`.
pub(super) fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

pub(super) fn given(n: usize) -> String {
    format!("{} {}", counted(n, "value"), if n == 1 { "is" } else { "are" })
}
