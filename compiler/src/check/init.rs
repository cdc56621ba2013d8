//! Initial values: expressions and `{ ... }` lists against a wanted type.

use super::Checker;
use super::typed::{Expr, ExprKind};
use crate::ast;
use crate::diag::Diagnostic;
use crate::source::Span;
use crate::types::{Base, Extent, Type};

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

    fn list(&mut self, items: &[ast::Init], span: Span, ty: Type, what: &str) -> Option<Expr> {
        if ty.is_array() {
            return self.array_list(items, span, ty, what);
        }
        match ty.base {
            Base::Struct(id) => {
                let fields = self.structs[id.0 as usize].fields.clone();
                if items.len() != fields.len() {
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

fn given(n: usize) -> String {
    format!("{} {}", counted(n, "value"), if n == 1 { "is" } else { "are" })
}
