//! Calls: user functions, built-ins, closures and struct constructors; overload resolution.

use super::Checker;
use super::convert::score;
use super::init::{Given, counted, given};
use super::scope::Symbol;
use super::typed::{Callee, Expr, ExprKind, FunctionId, VendorClosure};
use crate::ast;
use crate::builtins::{self, CLOSURES, ClosureId, FuncId, sig};
use crate::diag::Diagnostic;
use crate::source::Span;
use crate::types::{Base, Extent, Type};

/// An overload that a call could mean.
#[derive(Clone)]
struct Candidate {
    target: Target,
    ret: Type,
    /// Formal types; `None`: anything.
    formals: Vec<Option<Type>>,
    any_array: Vec<bool>,
    outputs: Vec<bool>,
    variadic: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Target {
    User(FunctionId),
    Builtin(FuncId),
    Closure(ClosureId),
}

/// Most calls per file whose arguments are looked at twice.
const MAX_RETRIES: u32 = 200;

/// Most overloads that a finding names.
const MAX_NAMED: usize = 6;

/// Of overloads that fit equally well the one with the least rank is taken (the reference implementation's order).
fn rank(ret: Type) -> u8 {
    match ret.base {
        Base::Float => 0,
        Base::Int => 1,
        Base::Color => 2,
        Base::Vector => 3,
        Base::Point => 4,
        Base::Normal => 5,
        Base::Matrix => 6,
        Base::String => 7,
        Base::Closure => 8,
        Base::Struct(_) => 9,
        Base::Void => 10,
    }
}

impl Checker {
    pub(super) fn call(
        &mut self,
        callee: &ast::Ident,
        args: &[ast::Init],
        span: Span,
        wanted: Option<Type>,
    ) -> Option<Expr> {
        if let Some(Symbol::Struct(id)) = self.scopes.find(&callee.name) {
            let ty = Type::scalar(Base::Struct(*id));
            let fields = self.structs[id.0 as usize].fields.len();
            if args.len() < fields {
                let message = format!(
                    "struct `{}` has {}, but {} given",
                    callee.name,
                    counted(fields, "field"),
                    given(args.len())
                );
                return self.fail(Diagnostic::error("E2012", span, message));
            }
            return self.initial(&ast::Init::List(args.to_vec(), span), ty, &format!("`{}`", callee.name));
        }
        // As in the reference implementation, what the call should give is also asked of its arguments.
        let typed: Vec<Option<Given>> = args.iter().map(|arg| self.given(arg, wanted)).collect();
        if let Some(Symbol::Broken) = self.scopes.find(&callee.name) {
            return None;
        }
        let candidates = match self.scopes.find(&callee.name) {
            Some(Symbol::Var(_)) => Vec::new(),
            _ => self.candidates(&callee.name),
        };
        if candidates.is_empty() {
            return self.unknown_function(callee);
        }
        let mut typed = typed.into_iter().collect::<Option<Vec<_>>>()?;
        // Arguments that became what the call should give may fit better as what they are without.
        let none_fits = |typed: &[Given]| candidates.iter().all(|c| self.fit(c, typed).is_err());
        if wanted.is_some() && self.retries < MAX_RETRIES && none_fits(&typed) {
            self.retries += 1;
            let said = (self.errors.len(), self.warnings.len());
            let again: Vec<Option<Given>> = args.iter().map(|arg| self.given(arg, None)).collect();
            self.errors.truncate(said.0);
            self.warnings.truncate(said.1);
            if let Some(again) = again.into_iter().collect::<Option<Vec<_>>>() {
                typed = again;
            }
        }
        self.resolve(&callee.name, callee.span, span, candidates, typed, wanted)
    }

    /// A call to a function known to exist, such as an overloaded operator.
    pub(super) fn call_named(&mut self, name: &str, span: Span, args: Vec<Expr>, wanted: Option<Type>) -> Option<Expr> {
        let candidates = self.candidates(name);
        self.resolve(name, span, span, candidates, args.into_iter().map(Given::Value).collect(), wanted)
    }

    fn unknown_function<T>(&mut self, callee: &ast::Ident) -> Option<T> {
        let name = &callee.name;
        if let Some(Symbol::Var(id)) = self.scopes.find(name) {
            let at = self.var(*id).span;
            let d = Diagnostic::error("E2001", callee.span, format!("`{name}` is a variable and cannot be called"));
            return self.fail(d.label(at, "declared here"));
        }
        if let Some(at) = self.later.get(name) {
            let d = Diagnostic::error("E2001", callee.span, format!("function `{name}` is not declared yet"))
                .label(*at, "it is defined here")
                .help("move the function before its use, or declare it there: a head that ends in `;`");
            return self.fail(d);
        }
        let users = self.scopes.names(|s| matches!(s, Symbol::Functions(_)));
        let public = builtins::TABLE.iter().filter(|r| r.lowering.is_public());
        let known = users.chain(public.map(|r| r.name)).chain(CLOSURES.iter().map(|r| r.name));
        let mut d = Diagnostic::error("E2001", callee.span, format!("there is no function `{name}`"));
        if let Some(near) = crate::suggest::closest(name, known) {
            d = d.help(format!("did you mean `{near}`?"));
        } else if let Some(header) = crate::vendor::header_of(name) {
            d = d.help(format!("a closure of another renderer: declare it, or `#include \"{header}\"`"));
        }
        self.fail(d)
    }

    /// All overloads of a name: the user's, innermost first, then built-ins, then closures.
    fn candidates(&self, name: &str) -> Vec<Candidate> {
        let mut out: Vec<Candidate> = Vec::new();
        // A function that replaces another means that other one in its own body.
        let mut own = None;
        for id in self.scopes.functions(name) {
            let f = &self.functions[id.0 as usize];
            let tokens = if let VendorClosure::Mapped { tokens } = f.closure { tokens as usize } else { 0 };
            let params = &f.params[..f.params.len() - tokens.min(f.params.len())];
            let formals: Vec<_> = params.iter().map(|(v, _)| Some(self.var(*v).ty)).collect();
            // Newer and inner ones hide those with the same parameters and result.
            if out.iter().any(|c| c.formals == formals && c.ret == f.ret) {
                continue;
            }
            let candidate = Candidate {
                target: Target::User(id),
                ret: f.ret,
                any_array: vec![false; formals.len()],
                outputs: params.iter().map(|(_, o)| *o).collect(),
                formals,
                variadic: f.closure != VendorClosure::No,
            };
            match self.current == Some(id) {
                true => own = Some(candidate),
                false => out.push(candidate),
            }
        }
        let user = out.len();
        if let Some(id) = sig::by_name(name).filter(|id| builtins::row(*id).lowering.is_public()) {
            for o in sig::overloads(id) {
                let formals: Vec<_> = o.formals.iter().map(|f| f.ty).collect();
                // The user's function hides a built-in with the same parameters.
                if out[..user].iter().any(|c| c.formals == formals) {
                    continue;
                }
                out.push(Candidate {
                    target: Target::Builtin(id),
                    ret: o.ret,
                    formals,
                    any_array: o.formals.iter().map(|f| f.any_array).collect(),
                    outputs: o.formals.iter().map(|f| f.output).collect(),
                    variadic: o.variadic,
                });
            }
        }
        for (i, row) in CLOSURES.iter().enumerate().filter(|(_, r)| r.name == name) {
            let _ = row;
            let id = ClosureId(i as u16);
            let formals = sig::closure_formals(id);
            out.push(Candidate {
                target: Target::Closure(id),
                ret: Type::scalar(Base::Closure),
                formals: formals.iter().map(|f| f.ty).collect(),
                any_array: vec![false; formals.len()],
                outputs: vec![false; formals.len()],
                variadic: true,
            });
        }
        out.extend(own.filter(|own| !out.iter().any(|c| c.formals == own.formals && c.ret == own.ret)));
        out
    }

    /// How well the arguments fit; an error says why they don't.
    fn fit(&self, c: &Candidate, args: &[Given]) -> Result<u32, String> {
        let (given, formals) = (args.len(), c.formals.len());
        if given < formals || (given > formals && !c.variadic) {
            let least = if c.variadic { "at least " } else { "" };
            return Err(format!("takes {least}{}, not {given}", counted(formals, "argument")));
        }
        // Each further argument matches anything.
        let mut sum = (given - formals) as u32;
        for (i, (formal, arg)) in c.formals.iter().zip(args).enumerate() {
            let Given::Value(arg) = arg else {
                let Some(f) = formal.filter(|f| self.fills(arg, *f)) else {
                    let wanted = formal.map_or("a value".into(), |f| self.show(f));
                    return Err(format!("argument {} needs {wanted}, which this list does not make", i + 1));
                };
                sum += score(f, f).unwrap_or(0);
                continue;
            };
            let fits = match formal {
                None if c.any_array[i] != arg.ty.is_array() && c.any_array[i] => None,
                None => Some(1),
                // An output takes the exact type, or another triple, since the value comes back.
                Some(f) if c.outputs[i] => {
                    let exact = *f == arg.ty || (f.base.is_triple() && arg.ty.base.is_triple() && !arg.ty.is_array());
                    if exact || f.is_array() { score(*f, arg.ty) } else { None }
                }
                Some(f) => match (f.base, &arg.kind) {
                    (Base::Closure, ExprKind::Int(0)) => Some(23),
                    _ => score(*f, arg.ty),
                },
            };
            match (fits, formal) {
                (Some(s), _) => sum += s,
                (None, Some(f)) if c.outputs[i] => {
                    let (wanted, given) = (self.show(*f), self.show(arg.ty));
                    return Err(format!("argument {} is an output and needs exactly {wanted}, not {given}", i + 1));
                }
                (None, Some(f)) => {
                    return Err(format!("argument {} needs {}, not {}", i + 1, self.show(*f), self.show(arg.ty)));
                }
                (None, None) => return Err(format!("argument {} needs an array", i + 1)),
            }
        }
        Ok(sum)
    }

    /// Chooses as the reference implementation does: the best fit of the arguments; among equals the best fit of the
    /// result; among those that are equal still, the first by [`rank`] of all that fit equally, with a warning.
    fn resolve(
        &mut self,
        name: &str,
        name_span: Span,
        span: Span,
        mut candidates: Vec<Candidate>,
        args: Vec<Given>,
        wanted: Option<Type>,
    ) -> Option<Expr> {
        let fits: Vec<Result<u32, String>> = candidates.iter().map(|c| self.fit(c, &args)).collect();
        let Some(best) = fits.iter().flatten().max().copied() else {
            return self.no_overload(name, name_span, &candidates, &fits, &args);
        };
        let mut fit = fits.iter();
        candidates.retain(|_| fit.next().is_some_and(|f| f.as_ref() == Ok(&best)));
        let by_result = |c: &Candidate| wanted.map_or(0, |w| score(w, c.ret).unwrap_or(0));
        let top = candidates.iter().map(by_result).max().unwrap_or(0);
        if candidates.iter().filter(|c| by_result(c) == top).count() == 1 {
            candidates.retain(|c| by_result(c) == top);
        } else {
            candidates.sort_by_key(|c| rank(c.ret));
            self.ambiguous(name, span, &candidates, &args)?;
        }
        let chosen = candidates.into_iter().next()?;
        self.finish(name, chosen, args, span)
    }

    /// Reports a call that several overloads fit equally well, the one to be chosen first: an error when the choice is
    /// among structs, or among readings of a list.
    fn ambiguous(&mut self, name: &str, span: Span, candidates: &[Candidate], args: &[Given]) -> Option<()> {
        let structs = candidates.iter().filter(|c| matches!(c.ret.base, Base::Struct(_))).count();
        let lists_differ = args.iter().enumerate().any(|(i, a)| {
            let formal = |c: &Candidate| c.formals.get(i).copied().flatten();
            matches!(a, Given::List(..)) && candidates.iter().any(|c| formal(c) != formal(&candidates[0]))
        });
        let is_user = |c: &Candidate| matches!(c.target, Target::User(_));
        if structs < 2 && !lists_differ && !candidates.iter().any(is_user) {
            // Built-in functions that differ in their results only, such as `noise(P)`.
            return Some(());
        }
        let certain = structs < 2 && !lists_differ;
        let part = match candidates.iter().all(|c| c.formals == candidates[0].formals) {
            true => "result",
            false => "arguments",
        };
        let mut d = match certain {
            true => {
                let message =
                    format!("this call of `{name}` is ambiguous: {} is taken", self.signature(name, &candidates[0]));
                Diagnostic::warning("W2006", span, message).help(format!("cast the {part} to the type that you mean"))
            }
            false => Diagnostic::error("E2005", span, format!("this call of `{name}` is ambiguous"))
                .help(format!("cast the {part} to the type that you mean")),
        };
        for c in candidates.iter().take(MAX_NAMED) {
            let text = format!("could be {}", self.signature(name, c));
            match c.target {
                Target::User(id) => d = d.label(self.functions[id.0 as usize].span, text),
                _ => d = d.label(span, text + " of the language"),
            }
        }
        match certain {
            true => {
                self.warn(d);
                Some(())
            }
            false => self.fail(d),
        }
    }

    fn signature(&self, name: &str, c: &Candidate) -> String {
        let mut parts: Vec<String> = c
            .formals
            .iter()
            .zip(&c.outputs)
            .map(|(f, out)| {
                let ty = f.map_or("any".to_string(), |t| self.show(t));
                if *out { format!("output {ty}") } else { ty }
            })
            .collect();
        if c.variadic {
            parts.push("...".into());
        }
        format!("{} {name}({})", self.show(c.ret), parts.join(", "))
    }

    fn no_overload<T>(
        &mut self,
        name: &str,
        name_span: Span,
        candidates: &[Candidate],
        fits: &[Result<u32, String>],
        args: &[Given],
    ) -> Option<T> {
        let given: Vec<String> = args
            .iter()
            .map(|a| match a {
                Given::Value(e) => self.show(e.ty),
                Given::List(..) => "{...}".into(),
            })
            .collect();
        let message = format!("no `{name}` takes ({})", given.join(", "));
        let mut lines: Vec<String> = Vec::new();
        for (c, fit) in candidates.iter().zip(fits) {
            let line = format!("{}: {}", self.signature(name, c), fit.as_ref().err().cloned().unwrap_or_default());
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
        let more = lines.len().saturating_sub(MAX_NAMED);
        lines.truncate(MAX_NAMED);
        if more > 0 {
            lines.push(format!("and {more} more"));
        }
        self.fail(Diagnostic::error("E2004", name_span, message).help(lines.join("\n        ")))
    }

    fn finish(&mut self, name: &str, c: Candidate, args: Vec<Given>, span: Span) -> Option<Expr> {
        let mut out = Vec::with_capacity(args.len());
        for (i, arg) in args.into_iter().enumerate() {
            let formal = c.formals.get(i).copied().flatten();
            let what = || format!("argument {} of `{name}`", i + 1);
            let output = c.outputs.get(i).copied().unwrap_or(false);
            out.push(match (arg, formal) {
                (Given::Value(e), Some(_)) if output => {
                    if matches!(c.target, Target::User(_)) && !e.is_place() {
                        let message = format!("{} is an output, and what it puts into this value is lost", what());
                        self.warn(Diagnostic::warning("W2004", e.span, message).help("give a variable"));
                    } else if !matches!(name, "regex_search" | "regex_match") {
                        // The reference lets those two write to any array.
                        self.require_lvalue(&e)?;
                    }
                    e
                }
                (Given::Value(e), Some(f)) if e.ty == f => e,
                (Given::Value(e), None) => e,
                (given, Some(f)) => self.fill(given, f, &what())?,
                (given, None) => {
                    return self.fail(Diagnostic::error("E2003", given.span(), format!("{} cannot be a list", what())));
                }
            });
        }
        let callee = match c.target {
            Target::User(id) => {
                if let Some(from) = self.current {
                    self.calls.push((from, id, span));
                }
                out = self.vendor_options(id, c.formals.len(), out, span)?;
                if let Some(called) = self.without_return.get_mut(&id) {
                    *called = true;
                    let at = self.functions[id.0 as usize].span;
                    let message = format!("`{name}` should return {}, but has no `return`", self.show(c.ret));
                    self.error(Diagnostic::error("E2009", span, message).label(at, "defined here"));
                }
                Callee::User(id)
            }
            Target::Builtin(_) if !self.check_format(name, &out, span) => return None,
            Target::Builtin(id) => Callee::Builtin {
                id,
                formals: c
                    .formals
                    .iter()
                    .map(|f| f.unwrap_or(Type { base: Base::Void, extent: Extent::Scalar }))
                    .collect(),
                outputs: c.outputs,
            },
            Target::Closure(id) => {
                out = self.closure_options(id, out)?;
                Callee::Closure { id, formals: c.formals.len() }
            }
        };
        Some(Expr { kind: ExprKind::Call(callee, out), ty: c.ret, span })
    }
}
