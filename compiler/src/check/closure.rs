//! The token/value arguments of closure calls (OSL specification ch. 7, "Material closures").
//!
//! In: a call's arguments. Out: the formal arguments, then a value per token of the closure's row, then the label if there is one.

use super::Checker;
use super::typed::{Expr, ExprKind};
use crate::builtins::{self, ClosureId, sig};
use crate::diag::Diagnostic;
use crate::suggest;
use crate::types::{Base, Type};

impl Checker {
    /// Puts the optional arguments in order. The last of several values for a token counts.
    pub(super) fn closure_options(&mut self, id: ClosureId, mut args: Vec<Expr>) -> Option<Vec<Expr>> {
        let name = builtins::closure(id).name;
        let keys = sig::closure_keys(id);
        let mut given = args.split_off(sig::closure_formals(id).len()).into_iter();
        let mut values: Vec<Option<Expr>> = vec![None; keys.len()];
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
            } else if let Some(index) = keys.iter().position(|k| k.token == *text) {
                match self.convert(value, keys[index].ty, &format!("\"{text}\" of `{name}`")) {
                    Some(value) => values[index] = Some(value),
                    None => failed = true,
                }
            } else {
                let message = format!("`{name}` does not know the option \"{text}\" and leaves it out");
                let known: Vec<&str> = keys.iter().map(|k| k.token).chain(["label"]).collect();
                let help = suggest::known_names(text, &known);
                self.warnings.push(Diagnostic::warning("W2008", token.span, message).help(help));
            }
        }
        let span = args.first().map(|a| a.span).or(label.as_ref().map(|l| l.span));
        for (key, value) in keys.iter().zip(values) {
            // A closure with tokens has arguments.
            let span = span.unwrap_or(crate::source::Span { file: crate::source::FileId(0), start: 0, end: 0 });
            let kind = match key.ty.base {
                Base::Int => ExprKind::Int(key.default as i32),
                _ => ExprKind::Float(key.default),
            };
            args.push(value.unwrap_or(Expr { kind, ty: key.ty, span }));
        }
        args.extend(label);
        (!failed).then_some(args)
    }
}
