//! Calls: user functions, built-ins, closures and struct constructors; overload resolution.

use super::Checker;
use super::convert::score;
use super::init::counted;
use super::scope::Symbol;
use super::typed::{Callee, Expr, ExprKind, FunctionId};
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

/// An argument before its type is known: a `{...}` list fits what the formal says.
enum Argument<'a> {
    Typed(Expr),
    List(&'a [ast::Init], Span),
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
            return self.initial(&ast::Init::List(args.to_vec(), span), ty, &format!("`{}`", callee.name));
        }
        let mut typed = Vec::new();
        let mut failed = false;
        for arg in args {
            match arg {
                ast::Init::Expr(e) => match self.expr(e, None) {
                    Some(e) => typed.push(Argument::Typed(e)),
                    None => failed = true,
                },
                ast::Init::List(items, at) => typed.push(Argument::List(items, *at)),
            }
        }
        if let Some(Symbol::Broken) = self.scopes.find(&callee.name) {
            return None;
        }
        let candidates = self.candidates(&callee.name);
        if candidates.is_empty() {
            return self.unknown_function(callee);
        }
        if failed {
            return None;
        }
        self.resolve(&callee.name, callee.span, span, candidates, typed, wanted)
    }

    /// A call to a function known to exist, such as an overloaded operator.
    pub(super) fn call_named(&mut self, name: &str, span: Span, args: Vec<Expr>, wanted: Option<Type>) -> Option<Expr> {
        let candidates = self.candidates(name);
        self.resolve(name, span, span, candidates, args.into_iter().map(Argument::Typed).collect(), wanted)
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
        }
        self.fail(d)
    }

    /// All overloads of a name: the user's, innermost first, then built-ins, then closures.
    fn candidates(&self, name: &str) -> Vec<Candidate> {
        let mut out: Vec<Candidate> = Vec::new();
        for id in self.scopes.functions(name) {
            let f = &self.functions[id.0 as usize];
            let formals: Vec<_> = f.params.iter().map(|(v, _)| Some(self.var(*v).ty)).collect();
            // Newer and inner ones hide those with the same parameters and result.
            if out.iter().any(|c| c.formals == formals && c.ret == f.ret) {
                continue;
            }
            out.push(Candidate {
                target: Target::User(id),
                ret: f.ret,
                any_array: vec![false; formals.len()],
                outputs: f.params.iter().map(|(_, o)| *o).collect(),
                formals,
                variadic: false,
            });
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
        out
    }

    /// How well the arguments fit; an error says why they don't.
    fn fit(&self, c: &Candidate, args: &[Argument]) -> Result<u32, String> {
        let (given, formals) = (args.len(), c.formals.len());
        if given < formals || (given > formals && !c.variadic) {
            let least = if c.variadic { "at least " } else { "" };
            return Err(format!("takes {least}{}, not {given}", counted(formals, "argument")));
        }
        let mut sum = 0;
        for (i, (formal, arg)) in c.formals.iter().zip(args).enumerate() {
            let Argument::Typed(arg) = arg else {
                let takes_list =
                    formal.is_some_and(|f| f.is_array() || matches!(f.base, Base::Struct(_)) || f.base.is_triple());
                if !takes_list {
                    return Err(format!("argument {} cannot be a list", i + 1));
                }
                sum += 44;
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
                    (Base::Closure, ExprKind::Int(0)) => Some(24),
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

    fn resolve(
        &mut self,
        name: &str,
        name_span: Span,
        span: Span,
        candidates: Vec<Candidate>,
        args: Vec<Argument>,
        wanted: Option<Type>,
    ) -> Option<Expr> {
        let fits: Vec<Result<u32, String>> = candidates.iter().map(|c| self.fit(c, &args)).collect();
        let Some(best) = fits.iter().flatten().max().copied() else {
            return self.no_overload(name, name_span, &candidates, &fits, &args);
        };
        let tied: Vec<&Candidate> =
            candidates.iter().zip(&fits).filter(|(_, f)| f.as_ref() == Ok(&best)).map(|(c, _)| c).collect();
        let by_result = |c: &Candidate| wanted.map_or(0, |w| score(w, c.ret).unwrap_or(0));
        // The first of the best: tables and scopes are in order of preference.
        let rank = tied.iter().map(|c| by_result(c)).max().unwrap_or(0);
        let winners: Vec<&Candidate> = tied.into_iter().filter(|c| by_result(c) == rank).collect();
        let chosen = winners.first().map(|c| (*c).clone())?;
        let rival = winners.iter().skip(1).find(|c| {
            matches!((chosen.target, c.target), (Target::User(_), Target::User(_))) && c.formals != chosen.formals
        });
        if let (Some(rival), Target::User(a)) = (rival, chosen.target)
            && let Target::User(b) = rival.target
        {
            let (at_a, at_b) = (self.functions[a.0 as usize].span, self.functions[b.0 as usize].span);
            let d = Diagnostic::error("E2005", span, format!("this call of `{name}` is ambiguous"))
                .label(at_a, format!("could be {}", self.signature(name, &chosen)))
                .label(at_b, format!("could be {}", self.signature(name, rival)))
                .help("cast the arguments to the types that you mean");
            return self.fail(d);
        }
        self.finish(name, chosen, args, span)
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
        args: &[Argument],
    ) -> Option<T> {
        let given: Vec<String> = args
            .iter()
            .map(|a| match a {
                Argument::Typed(e) => self.show(e.ty),
                Argument::List(..) => "{...}".into(),
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
        let more = lines.len().saturating_sub(6);
        lines.truncate(6);
        if more > 0 {
            lines.push(format!("and {more} more"));
        }
        self.fail(Diagnostic::error("E2004", name_span, message).help(lines.join("\n        ")))
    }

    fn finish(&mut self, name: &str, c: Candidate, args: Vec<Argument>, span: Span) -> Option<Expr> {
        let mut out = Vec::new();
        for (i, arg) in args.into_iter().enumerate() {
            let formal = c.formals.get(i).copied().flatten();
            let what = format!("argument {} of `{name}`", i + 1);
            let output = c.outputs.get(i).copied().unwrap_or(false);
            out.push(match (arg, formal) {
                (Argument::List(items, at), Some(f)) => self.initial(&ast::Init::List(items.to_vec(), at), f, &what)?,
                (Argument::List(_, at), None) => {
                    return self.fail(Diagnostic::error("E2003", at, format!("{what} cannot be a list")));
                }
                (Argument::Typed(e), Some(_)) if output => {
                    // The reference lets these write to any array.
                    if !matches!(name, "regex_search" | "regex_match") {
                        self.require_lvalue(&e)?;
                    }
                    e
                }
                (Argument::Typed(e), Some(f)) => self.convert(e, f, &what)?,
                (Argument::Typed(e), None) => e,
            });
        }
        let callee = match c.target {
            Target::User(id) => {
                if let Some(from) = self.current {
                    self.calls.push((from, id, span));
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
            Target::Closure(id) => Callee::Closure { id, formals: c.formals.len() },
        };
        Some(Expr { kind: ExprKind::Call(callee, out), ty: c.ret, span })
    }
}
