//! Names that are taken: what a scope already has must not be declared again.
//!
//! As in the reference implementation, the parameters of a shader and the statements of its body are in one scope with the
//! file, the globals and the built-in functions; parameters and body of a function are in one scope too.

use super::Checker;
use super::scope::Symbol;
use super::typed::VarKind;
use crate::ast;
use crate::builtins::{self, sig};
use crate::diag::Diagnostic;
use crate::source::Span;

/// What OSL's own `stdosl.h` and compiler do not declare: these names are free.
const NOT_IN_STDOSL: [&str; 5] = ["absorption", "henyey_greenstein", "isotropic", "pcellnoise", "phashnoise"];

/// Whether OSL has a function or closure of this name.
fn is_builtin(name: &str) -> bool {
    let function = sig::by_name(name).is_some_and(|id| builtins::row(id).lowering.is_public());
    (function || builtins::find_closure(name).is_some()) && !NOT_IN_STDOSL.contains(&name)
}

impl Checker {
    /// Reports a name that compilers keep for themselves: in `.oso` files they tell variables of inner scopes apart.
    pub(super) fn check_reserved(&mut self, name: &ast::Ident) {
        if name.name.starts_with("___") {
            self.error(Diagnostic::error("E2019", name.span, "a name cannot begin with three underscores"));
        }
    }

    /// Reports a name that the innermost scope has already. A parameter of a shader may have the name of a function: it hides it,
    /// which is worth a warning. Whether the name can be declared.
    pub(super) fn check_unused(&mut self, name: &ast::Ident, hides_functions: bool) -> bool {
        let text = &name.name;
        let (what, at): (&str, Option<Span>) = match self.scopes.find_here(text) {
            Some(Symbol::Var(id)) => {
                let var = self.var(*id);
                match var.kind {
                    VarKind::Global => (" as a global variable", None),
                    _ => ("", Some(var.span)),
                }
            }
            Some(Symbol::Struct(_)) => (" as a struct", None),
            Some(Symbol::Functions(list)) => {
                (" as a function", list.last().map(|id| self.functions[id.0 as usize].span))
            }
            Some(Symbol::Broken) => return true,
            None if self.scopes.at_file() && is_builtin(text) => (" as a built-in function", None),
            None => return true,
        };
        let d = if hides_functions && what.ends_with("function") {
            let message = format!("parameter `{text}` hides the function of this name");
            Diagnostic::warning("W2001", name.span, message)
        } else {
            let message = format!("`{text}` is already declared in this scope{what}");
            let d = Diagnostic::error("E2007", name.span, message);
            if at.is_none() { d.help("take another name, or declare it in a block of its own") } else { d }
        };
        let d = match at {
            Some(at) => d.label(at, "here"),
            None => d,
        };
        let free = !d.is_error();
        if free {
            self.warn(d)
        } else {
            self.error(d)
        }
        free
    }
}
