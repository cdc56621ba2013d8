//! Typed tree to [`Module`](super::Module): calls. Functions are inlined, built-ins and closures are operations.
//!
//! In: calls. Out: operations and the symbols of results. It must not know statements.

use super::write::{Frame, Writer};
use super::write_expr::is_struct;
use super::write_symbols::{Home, Place};
use super::{Access, SymId, SymbolKind};
use crate::builtins::{self, sig};
use crate::check::typed::{Callee, Expr, ExprKind, FunctionId, Shader, Stmt, VarId, VendorClosure, parts};
use crate::diag::Diagnostic;
use crate::types::{Base, Type};
use std::collections::HashSet;

/// Built-ins that write an argument behind their formals: the last one, or the values of some tokens.
enum Written {
    Last,
    Tokens(&'static [&'static str]),
    AllTokens,
}

fn written(name: &str) -> Option<Written> {
    Some(match name {
        "getattribute" | "getmessage" | "dict_value" | "gettextureinfo" | "pointcloud_get" => Written::Last,
        "texture" | "texture3d" | "environment" => Written::Tokens(&["alpha", "errormessage"]),
        "pointcloud_search" => Written::AllTokens,
        _ => return None,
    })
}

impl Writer<'_> {
    /// Writes a call; the symbols of its result, unless it returns nothing. `wanted` would spare a copy.
    pub(super) fn call(&mut self, callee: &Callee, args: &[Expr], e: &Expr, wanted: Option<SymId>) -> Option<Home> {
        let outer = self.at;
        self.locate(e.span);
        let result = match callee {
            Callee::User(id) => self.inline(*id, args, e),
            Callee::Builtin { id, outputs, .. } => self.builtin(builtins::row(*id).name, outputs, args, e, wanted),
            Callee::Closure { id, formals } => {
                let name = self.string(builtins::closure(*id).name);
                let mut symbols = self.values(&args[..*formals]);
                // Behind the formals the tree has a value per token, then the label: pairs again in the file.
                let keys = sig::closure_keys(*id);
                for (i, value) in args[*formals..].iter().enumerate() {
                    let token = keys.get(i).map_or("label", |k| k.token);
                    let default = match (&value.kind, keys.get(i)) {
                        (ExprKind::Int(v), Some(key)) => f64::from(*v) == key.default,
                        (ExprKind::Float(v), Some(key)) => *v == key.default,
                        _ => false,
                    };
                    if !default {
                        let token = self.string(token);
                        let value = self.value(value, None);
                        symbols.extend([token, value]);
                    }
                }
                let to = self.target(wanted, e.ty);
                symbols.splice(0..0, [to, name]);
                let access = format!("w{}", "r".repeat(symbols.len() - 1));
                self.op("closure", &access, &symbols);
                Some(Home::One(to))
            }
        };
        self.at = outer;
        result
    }

    fn inline(&mut self, id: FunctionId, args: &[Expr], e: &Expr) -> Option<Home> {
        let tree = self.tree;
        let function = &tree.functions[id.0 as usize];
        if function.closure == VendorClosure::Unknown {
            // Another renderer may know it.
            let mut symbols = self.values(args);
            let name = self.string(&function.name);
            let to = self.target(None, e.ty);
            symbols.splice(0..0, [to, name]);
            let access = format!("w{}", "r".repeat(symbols.len() - 1));
            self.op("closure", &access, &symbols);
            return Some(Home::One(to));
        }
        let Some(body) = &function.body else {
            let message = format!("function `{}` is declared but has no body", function.name);
            self.error(Diagnostic::error("E2015", e.span, message).label(function.span, "declared here"));
            return None;
        };
        if self.too_large() {
            return None;
        }
        let mut bound = Vec::new();
        let mut copy_back = Vec::new();
        for ((var, output), arg) in function.params.iter().zip(args) {
            let formal = tree.var(*var).ty;
            let exact = arg.ty == formal || arg.ty.is_array();
            let home = match &arg.kind {
                // By reference: a variable or a field of one is bound itself, as long as its type fits exactly.
                ExprKind::Var(_) | ExprKind::Field(..) if exact && is_whole(arg) => match self.place(arg) {
                    Place::Home(home) => home,
                    _ => continue,
                },
                _ if *output => {
                    let place = self.place(arg);
                    let home = self.temp(if arg.ty.is_array() { arg.ty } else { formal });
                    self.copy(&Place::Home(home.clone()), &place);
                    copy_back.push((place, home.clone()));
                    home
                }
                _ if is_struct(arg.ty) => {
                    let home = self.temp(if arg.ty.is_array() { arg.ty } else { formal });
                    self.assign(&Place::Home(home.clone()), arg);
                    home
                }
                _ => {
                    let value = self.value(arg, None);
                    let symbol = self.module.symbol(value);
                    // Nothing else changes a constant or a temporary, unless the function does.
                    let own = match symbol.kind {
                        SymbolKind::Const => !self.written.contains(var),
                        kind => kind == SymbolKind::Temp,
                    };
                    if own && (arg.ty.is_array() || self.type_of(value) == formal) {
                        Home::One(value)
                    } else {
                        let home = self.temp(if arg.ty.is_array() { arg.ty } else { formal });
                        self.store(&Place::Home(home.clone()), value);
                        home
                    }
                }
            };
            bound.push((*var, home));
        }
        // Bound only now: an argument may itself call the function.
        self.env.extend(bound);
        let result = (function.ret.base != Base::Void).then(|| self.temp(function.ret));
        let name = self.string(&function.name);
        let op = self.op("functioncall", "r", &[name]);
        self.frames.push(Frame { result: result.clone(), nesting: 0, function: true });
        self.stmts(body);
        self.frames.pop();
        let end = self.here();
        if self.module.ops.get(op).is_some_and(|o| o.name == "functioncall") {
            self.jumps(op, vec![end]);
        }
        for (place, home) in copy_back {
            self.copy(&place, &Place::Home(home));
        }
        result
    }

    fn builtin(
        &mut self,
        name: &str,
        outputs: &[bool],
        args: &[Expr],
        e: &Expr,
        wanted: Option<SymId>,
    ) -> Option<Home> {
        let more = written(name);
        let is_output = |i: usize| match (outputs.get(i), &more) {
            (Some(output), _) => *output,
            (None, Some(Written::Last)) => i + 1 == args.len(),
            (None, Some(Written::Tokens(tokens))) => {
                matches!(args.get(i.wrapping_sub(1)).map(|a| &a.kind), Some(ExprKind::Str(s)) if tokens.contains(&s.as_str()))
            }
            (None, Some(Written::AllTokens)) => {
                matches!(args.get(i.wrapping_sub(1)).map(|a| a.ty), Some(t) if t == Type::STRING)
            }
            (None, None) => false,
        };
        let mut symbols = Vec::new();
        let mut access = Vec::new();
        let mut copy_back = Vec::new();
        for (i, arg) in args.iter().enumerate() {
            let names_place = matches!(
                arg.kind,
                ExprKind::Var(_)
                    | ExprKind::Index(..)
                    | ExprKind::Field(..)
                    | ExprKind::Component(..)
                    | ExprKind::Element(..)
            );
            if is_output(i) && names_place && !is_struct(arg.ty) {
                let place = self.place(arg);
                let symbol = match &place {
                    Place::Home(home) => home.symbol(),
                    _ => {
                        let value = self.load(&place);
                        copy_back.push((place, value));
                        value
                    }
                };
                symbols.push(symbol);
                access.push(Access::Write);
            } else {
                symbols.push(self.value(arg, None));
                access.push(Access::Read);
            }
        }
        let result = (e.ty.base != Base::Void).then(|| {
            // A result that is also an argument's output would be written twice.
            let wanted = wanted.filter(|w| !symbols.contains(w) || !access.contains(&Access::Write));
            self.target(wanted, e.ty)
        });
        if let Some(to) = result {
            symbols.insert(0, to);
            access.insert(0, Access::Write);
        }
        let name = match (name, e.ty.base) {
            ("transform", Base::Vector) => "transformv",
            ("transform", Base::Normal) => "transformn",
            _ => name,
        };
        let derivs = derivatives(name, args);
        let op = self.op_with(name, access, symbols);
        if let Some(op) = self.module.ops.get_mut(op).filter(|_| !derivs.is_empty()) {
            op.derivs = derivs;
        }
        for (place, value) in copy_back {
            self.store(&place, value);
        }
        result.map(Home::One)
    }
}

/// The variables that anything in the shader's functions assigns.
pub(super) fn written_variables(tree: &Shader) -> HashSet<VarId> {
    let mut out = HashSet::new();
    let mut todo: Vec<&Expr> = Vec::new();
    let mut blocks: Vec<&[Stmt]> = tree.functions.iter().filter_map(|f| f.body.as_deref()).collect();
    while let Some(block) = blocks.pop() {
        for stmt in block {
            match stmt {
                Stmt::Declare(_, e) | Stmt::Return(e, _) => todo.extend(e),
                Stmt::Expr(e) => todo.push(e),
                Stmt::Block(b) => blocks.push(b),
                Stmt::If(c, a, b) => {
                    todo.push(c);
                    blocks.extend([a.as_slice(), b]);
                }
                Stmt::Loop { cond, step, body, .. } => {
                    todo.extend(cond.iter().chain(step));
                    blocks.push(body);
                }
                Stmt::Break | Stmt::Continue => {}
            }
        }
    }
    while let Some(e) = todo.pop() {
        match &e.kind {
            ExprKind::Assign(to, _) | ExprKind::AssignOp(_, to, _) | ExprKind::IncDec(_, to) => out.extend(root(to)),
            // Any argument may be an output.
            ExprKind::Call(_, args) => out.extend(args.iter().filter_map(root)),
            _ => {}
        }
        todo.extend(parts(e));
    }
    out
}

/// The variable that a place is part of.
fn root(e: &Expr) -> Option<VarId> {
    match &e.kind {
        ExprKind::Var(id) => Some(*id),
        ExprKind::Index(base, _)
        | ExprKind::Component(base, _)
        | ExprKind::Element(base, ..)
        | ExprKind::Field(base, _) => root(base),
        _ => None,
    }
}

/// A variable, or a field of one: what has symbols of its own.
fn is_whole(e: &Expr) -> bool {
    match &e.kind {
        ExprKind::Var(_) => true,
        ExprKind::Field(base, _) => is_whole(base),
        _ => false,
    }
}

/// Which arguments of an operation (its result counts as 0) have their derivatives taken.
fn derivatives(name: &str, args: &[Expr]) -> Vec<u32> {
    let is_string = |i: usize| args.get(i).is_none_or(|a| a.ty == Type::STRING);
    match name {
        "area" | "filterwidth" | "calculatenormal" | "Dx" | "Dy" | "Dz" => vec![1],
        "texture" if is_string(3) => vec![2, 3],
        "texture3d" | "environment" if is_string(2) => vec![2],
        "trace" => vec![1, 2],
        "noise" | "pnoise" => match args.first() {
            Some(first) if first.ty == Type::STRING => {
                if matches!(&first.kind, ExprKind::Str(s) if s != "gabor") {
                    return Vec::new();
                }
                (1..args.len()).take_while(|i| !is_string(*i)).map(|i| i as u32 + 1).collect()
            }
            _ => Vec::new(),
        },
        _ => Vec::new(),
    }
}
