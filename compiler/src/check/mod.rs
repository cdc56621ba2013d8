//! Binds names, resolves types and overloads, and reports what is wrong.
//!
//! In: the syntax tree. Out: the typed tree ([`typed`]) and the reflection ([`crate::reflect`]). Goes on after an error, so
//! that one run finds several. It must not know the IR or any target.
//!
//! Codes: `E2001` unknown name, `E2002` unknown type, `E2003` type mismatch, `E2004` no overload fits, `E2005` ambiguous
//! call, `E2006` not assignable, `E2007` redeclared, `E2008` control flow out of place, `E2009` missing return, `E2010`
//! recursion, `E2011` arrays, `E2012` structs, `E2013` shaders and parameters, `E2014` metadata, `E2016` token/value arguments, `E2018` writes,
//! `E2019` reserved names; `W2001` shadowing and the like, `W2008` tokens that a closure does not know, `W2009` closures that nothing maps.

mod call;
mod closure;
pub(crate) mod constant;
mod convert;
mod decl;
mod expr;
mod format;
mod init;
mod names;
mod operator;
mod recursion;
mod scope;
mod stmt;
pub mod typed;
mod writes;

use crate::ast;
use crate::builtins::{self, sig};
use crate::diag::Diagnostic;
use crate::reflect::ShaderInfo;
use crate::source::{FileId, Span};
use crate::types::{Base, Extent, StructId, Type};
pub(crate) use closure::unmapped;
use scope::Scopes;
use typed::{Expr, FunctionId, Var, VarId, VarKind};

/// What checking yields.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The typed tree.
    pub shader: typed::Shader,
    /// What tools ask of it.
    pub info: ShaderInfo,
    /// Warnings.
    pub warnings: Vec<Diagnostic>,
}

/// The shader globals: name, type, writable. The reference front end protects these few only; the specification's table
/// depends on the shader's kind (chapter 6), but shaders in the wild write P and N in surfaces too.
pub(crate) const GLOBALS: [(&str, Base, bool); 13] = [
    ("P", Base::Point, true),
    ("I", Base::Vector, true),
    ("N", Base::Normal, true),
    ("Ng", Base::Normal, false),
    ("u", Base::Float, false),
    ("v", Base::Float, false),
    ("dPdu", Base::Vector, false),
    ("dPdv", Base::Vector, false),
    ("Ps", Base::Point, false),
    ("time", Base::Float, false),
    ("dtime", Base::Float, false),
    ("dPdtime", Base::Vector, false),
    ("Ci", Base::Closure, true),
];

/// Most findings of one run.
const MAX_ERRORS: usize = 100;

/// Warnings after which no more are kept. Many may be about functions that stand before the user's, and are left out later.
const MAX_WARNINGS: usize = 1000;

/// Checks a file. Findings come in the order in which they are found; warnings stand among the errors too.
pub fn check(file: &ast::File) -> Result<Checked, Vec<Diagnostic>> {
    let mut checker =
        Checker { warnings: file.warnings.clone(), incomplete: !file.broken.is_empty(), ..Checker::default() };
    // Names that syntax errors hide: outermost, so that everything else goes before.
    checker.scopes.enter();
    for name in &file.broken {
        if sig::by_name(name).is_none() && builtins::find_closure(name).is_none() {
            checker.scopes.declare_broken(name);
        }
    }
    checker.scopes.enter();
    checker.declare_globals();
    checker.scopes.enter_joined();
    let result = checker.file(file);
    let errors = checker.errors;
    match result {
        Some((shader, info)) if errors.is_empty() => Ok(Checked { shader, info, warnings: checker.warnings }),
        _ => {
            let mut errors = errors;
            if errors.is_empty() && !checker.incomplete {
                errors.push(
                    Diagnostic::error("E2013", Span { file: FileId(0), start: 0, end: 0 }, "the file holds no shader")
                        .help("declare one: `surface name() { ... }`"),
                );
            }
            errors.truncate(MAX_ERRORS);
            errors.extend(checker.warnings);
            Err(errors)
        }
    }
}

/// Carries the state of a run.
#[derive(Default)]
pub(crate) struct Checker {
    errors: Vec<Diagnostic>,
    warnings: Vec<Diagnostic>,
    /// Parts of the file could not be read: what is missing may stand there.
    incomplete: bool,
    scopes: Scopes,
    vars: Vec<Var>,
    structs: Vec<typed::Struct>,
    functions: Vec<typed::Function>,
    /// Who calls whom, and where.
    calls: Vec<(FunctionId, FunctionId, Span)>,
    /// The function whose body is being checked.
    current: Option<FunctionId>,
    /// Loops around the present statement.
    loops: u32,
    /// The result type that `return` must give; `None` outside of bodies.
    returns: Option<Type>,
    /// A `return` was seen in the present function.
    returned: bool,
    /// Functions with a result whose bodies hold no `return`, and whether one was called.
    without_return: std::collections::HashMap<FunctionId, bool>,
    /// Calls whose arguments were looked at twice.
    retries: u32,
    /// Where the file defines functions, for calls that come too early.
    later: std::collections::HashMap<String, Span>,
    /// Parameters whose length the group tells; until then they have their default's.
    open: std::collections::HashSet<typed::VarId>,
}

impl Checker {
    fn error(&mut self, d: Diagnostic) {
        if self.errors.len() < MAX_ERRORS {
            self.errors.push(d);
        }
    }

    fn warn(&mut self, d: Diagnostic) {
        if self.warnings.len() < MAX_WARNINGS {
            self.warnings.push(d);
        }
    }

    /// Reports and yields `None`: the way out of expressions.
    fn fail<T>(&mut self, d: Diagnostic) -> Option<T> {
        self.error(d);
        None
    }

    fn var(&self, id: VarId) -> &Var {
        &self.vars[id.0 as usize]
    }

    fn new_var(&mut self, var: Var) -> VarId {
        self.vars.push(var);
        VarId(self.vars.len() as u32 - 1)
    }

    /// The type in the user's words: `float[4]`, `Light`, `closure color`.
    fn show(&self, ty: Type) -> String {
        let base = match ty.base {
            Base::Struct(StructId(i)) => self.structs[i as usize].name.clone(),
            base => base.keyword().to_string(),
        };
        match ty.extent {
            Extent::Scalar => base,
            Extent::Fixed(n) => format!("{base}[{n}]"),
            Extent::Unsized => format!("{base}[]"),
        }
    }

    fn declare_globals(&mut self) {
        for (name, base, writable) in GLOBALS {
            let span = Span { file: FileId(0), start: 0, end: 0 };
            let var = Var { name: name.into(), ty: Type::scalar(base), kind: VarKind::Global, writable, span };
            let id = self.new_var(var);
            self.scopes.declare_var(name, id);
        }
    }

    /// An expression of type int that is true when `expr` is; reports types that have no truth.
    fn truth(&mut self, expr: Expr) -> Option<Expr> {
        if expr.ty == Type::INT {
            return Some(expr);
        }
        if expr.ty.is_array() || matches!(expr.ty.base, Base::Void | Base::Struct(_)) {
            let message = format!("{} cannot be a condition", self.show(expr.ty));
            return self.fail(Diagnostic::error("E2003", expr.span, message));
        }
        let span = expr.span;
        Some(Expr { kind: typed::ExprKind::Truth(Box::new(expr)), ty: Type::INT, span })
    }
}
