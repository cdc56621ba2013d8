//! Formats of `printf` and its kin against their arguments.
//!
//! In: the typed arguments of a call. Out: findings. Run-time formats are checked when they are used.

use super::Checker;
use super::typed::{Expr, ExprKind};
use crate::diag::Diagnostic;
use crate::source::Span;
use crate::types::Base;

/// Conversions that a `%` runs up to.
const CONVERSIONS: &str = "cdefgimnopsuvxX";

impl Checker {
    /// Whether the arguments of a call fit its format, if it has one. A format that is no literal is a warning.
    pub(super) fn check_format(&mut self, name: &str, args: &[Expr], span: Span) -> bool {
        let at = match name {
            "printf" | "format" | "error" | "warning" => 0,
            "fprintf" => 1,
            _ => return true,
        };
        let Some((format, values)) = args.get(at).zip(args.get(at + 1..)) else { return true };
        let ExprKind::Str(text) = &format.kind else {
            let message = format!("the format of `{name}` is not a literal: its arguments cannot be checked");
            self.warnings.push(Diagnostic::warning("W2010", span, message));
            return true;
        };
        let wrong = match mismatch(name, text, values) {
            None => return true,
            Some(wrong) => wrong,
        };
        let mut d = Diagnostic::error("E2017", span, wrong.1);
        if let Some(at) = wrong.0 {
            d = d.label(at, "this one");
        }
        self.fail::<()>(d);
        false
    }
}

/// What is wrong, and with which argument.
fn mismatch(name: &str, format: &str, values: &[Expr]) -> Option<(Option<Span>, String)> {
    let mut values = values.iter();
    let mut rest = format;
    while let Some(at) = rest.find('%') {
        rest = &rest[at + 1..];
        if let Some(behind) = rest.strip_prefix('%') {
            rest = behind;
            continue;
        }
        let end = rest.find(|c| CONVERSIONS.contains(c));
        let (conversion, behind) = rest.split_at(end.map_or(rest.len(), |i| i + 1));
        rest = behind;
        let letter = end.and(conversion.chars().next_back());
        let Some(value) = values.next() else {
            return Some((
                None,
                format!("`{name}` has fewer arguments than its format has conversions: `%{conversion}` has none"),
            ));
        };
        let (ty, fits) = match value.ty.base {
            Base::Struct(_) => return Some((Some(value.span), format!("`{name}` cannot show a struct"))),
            Base::Closure => ("a closure", "s"),
            Base::String => ("a string", "s"),
            Base::Int => ("an int", "dioxX"),
            _ => ("a float, triple or matrix", "fgecmnpv"),
        };
        if !letter.is_some_and(|l| fits.contains(l)) {
            let wanted: Vec<String> = fits.chars().filter(|c| !"cmnpv".contains(*c)).map(|c| format!("%{c}")).collect();
            let message = format!("`%{conversion}` of `{name}` does not show {ty}: it takes {}", wanted.join(", "));
            return Some((Some(value.span), message));
        }
    }
    let extra = values.next()?;
    Some((Some(extra.span), format!("`{name}` has more arguments than its format has conversions")))
}
