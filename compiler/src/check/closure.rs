//! The token/value arguments of closure calls (OSL specification ch. 7, "Material closures").
//!
//! In: a call's arguments. Out: the formal arguments, then a value per token of the closure's row, then the label if there is one.

use super::Checker;
use super::typed::{Expr, ExprKind, FunctionId, VendorClosure};
use crate::builtins::{self, ClosureId, sig};
use crate::diag::Diagnostic;
use crate::source::{FileId, Span};
use crate::suggest;
use crate::types::{Base, Type};

impl Checker {
    /// Puts the optional arguments in order. The last of several values for a token counts.
    pub(super) fn closure_options(&mut self, id: ClosureId, mut args: Vec<Expr>) -> Option<Vec<Expr>> {
        let name = builtins::closure(id).name;
        let keys = sig::closure_keys(id);
        let given = args.split_off(sig::closure_formals(id).len());
        let types: Vec<(&str, Type)> = keys.iter().map(|k| (k.token, k.ty)).collect();
        let (values, label) = self.pairs(name, &types, given)?;
        let span = args.first().map(|a| a.span).or(label.as_ref().map(|l| l.span));
        for (key, value) in keys.iter().zip(values) {
            // A closure with tokens has arguments.
            let span = span.unwrap_or(Span { file: FileId(0), start: 0, end: 0 });
            let kind = match key.ty.base {
                Base::Int => ExprKind::Int(key.default as i32),
                _ => ExprKind::Float(key.default),
            };
            args.push(value.unwrap_or(Expr { kind, ty: key.ty, span }));
        }
        args.extend(label);
        Some(args)
    }

    /// The same for a function that stands for a vendor's closure. Calls of one that nobody maps keep what they give.
    pub(super) fn vendor_options(
        &mut self,
        id: FunctionId,
        formals: usize,
        mut args: Vec<Expr>,
        span: Span,
    ) -> Option<Vec<Expr>> {
        let function = &self.functions[id.0 as usize];
        let name = function.name.clone();
        match function.closure {
            VendorClosure::No => Some(args),
            VendorClosure::Unknown => {
                self.warnings.push(unmapped(&name, span).label(function.span, "declared here"));
                Some(args)
            }
            VendorClosure::Mapped { .. } => {
                let tokens: Vec<(String, Type)> = function.params[formals..]
                    .iter()
                    .map(|(v, _)| (self.var(*v).name.clone(), self.var(*v).ty))
                    .collect();
                let types: Vec<(&str, Type)> = tokens.iter().map(|(n, ty)| (n.as_str(), *ty)).collect();
                let given = args.split_off(formals);
                let (values, _) = self.pairs(&name, &types, given)?;
                for ((token, ty), value) in tokens.iter().zip(values) {
                    let zero = Expr { kind: ExprKind::Int(0), ty: Type::INT, span };
                    let zero = if ty.base == Base::String {
                        Expr { kind: ExprKind::Str(String::new()), ty: Type::STRING, span }
                    } else {
                        zero
                    };
                    args.push(match value {
                        Some(value) => value,
                        None => self.convert(zero, *ty, token)?,
                    });
                }
                Some(args)
            }
        }
    }

    /// Sorts pairs of token and value: a value per known token, and the label.
    fn pairs(
        &mut self,
        name: &str,
        known: &[(&str, Type)],
        given: Vec<Expr>,
    ) -> Option<(Vec<Option<Expr>>, Option<Expr>)> {
        let mut given = given.into_iter();
        let mut values: Vec<Option<Expr>> = vec![None; known.len()];
        let mut label = None;
        let mut failed = false;
        while let Some(token) = given.next() {
            if token.ty != Type::STRING {
                let message =
                    format!("`{name}` takes pairs of a token and its value here, not {}", self.show(token.ty));
                return self.fail(Diagnostic::error("E2016", token.span, message));
            }
            let Some(value) = given.next() else {
                let d = Diagnostic::error("E2016", token.span, "this token has no value");
                return self.fail(d.help("token/value arguments come in pairs: \"label\", \"coat\""));
            };
            let ExprKind::Str(text) = &token.kind else {
                let message = "the name of an option has to be a literal; this one is left out";
                self.warnings.push(Diagnostic::warning("W2008", token.span, message));
                continue;
            };
            if text == "label" {
                match self.convert(value, Type::STRING, "a label") {
                    Some(value) => label = Some(value),
                    None => failed = true,
                }
            } else if let Some(index) = known.iter().position(|k| k.0 == *text) {
                match self.convert(value, known[index].1, &format!("\"{text}\" of `{name}`")) {
                    Some(value) => values[index] = Some(value),
                    None => failed = true,
                }
            } else {
                let message = format!("`{name}` does not know the option \"{text}\" and leaves it out");
                let tokens: Vec<&str> = known.iter().map(|k| k.0).chain(["label"]).collect();
                let help = suggest::known_names(text, &tokens);
                self.warnings.push(Diagnostic::warning("W2008", token.span, message).help(help));
            }
        }
        (!failed).then_some((values, label))
    }
}

/// The warning about a call of a vendor's closure that no mapping tells of.
pub(crate) fn unmapped(name: &str, span: Span) -> Diagnostic {
    let message = format!("nothing says what the closure `{name}` looks like: it contributes nothing");
    Diagnostic::warning("W2009", span, message).help("a mapping can tell: docs/closures.md")
}
