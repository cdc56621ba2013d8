//! [`Module`](super::Module) to the typed tree: operators, constructors, closures and built-ins.
//!
//! In: operations. Out: expressions with their overload chosen. It must not know control flow.

use super::read::{Fit, Reader, unfit};
use super::read_fit::{fitted, single, truth};
use super::{Element, Hint, HintArg, Literal, Op, Symbol};
use crate::ast::BinaryOp;
use crate::builtins::{self, CLOSURES, ClosureId, sig};
use crate::check::typed::{Callee, Expr, ExprKind};
use crate::reflect::{Metadata, Value};
use crate::types::{Base, Extent, Type};

/// The operator of an operation.
pub(super) fn binary_op(name: &str) -> Option<BinaryOp> {
    Some(match name {
        "add" => BinaryOp::Add,
        "sub" => BinaryOp::Sub,
        "mul" => BinaryOp::Mul,
        "div" => BinaryOp::Div,
        // The operator `%`; the function `mod`, which rounds down, is written as the operations that it is made of.
        "mod" => BinaryOp::Mod,
        "shl" => BinaryOp::Shl,
        "shr" => BinaryOp::Shr,
        "lt" => BinaryOp::Lt,
        "le" => BinaryOp::Le,
        "gt" => BinaryOp::Gt,
        "ge" => BinaryOp::Ge,
        "eq" => BinaryOp::Eq,
        "neq" => BinaryOp::Ne,
        "bitand" => BinaryOp::BitAnd,
        "bitor" => BinaryOp::BitOr,
        "xor" => BinaryOp::BitXor,
        "and" => BinaryOp::And,
        "or" => BinaryOp::Or,
        _ => return None,
    })
}

/// The name that the table of built-ins has for an operation.
fn row_name(name: &str) -> &str {
    match name {
        "transformv" | "transformn" => "transform",
        "mod" => "fmod",
        "strtof" => "stof",
        "strtoi" => "stoi",
        name => name,
    }
}

/// The values on a symbol's line.
pub(super) fn literal_value(symbol: &Symbol) -> Option<Value> {
    let float = !matches!(symbol.ty.base(), Some(Base::Int));
    let one = |v: &Literal| match v {
        Literal::Int(i) if float => Value::Float(f64::from(*i)),
        Literal::Int(i) => Value::Int(*i),
        Literal::Float(f) => Value::Float(*f),
        Literal::Str(s) => Value::Str(s.clone()),
    };
    let values: Vec<Value> = symbol.values.iter().map(one).collect();
    shaped(values, symbol.ty.components(), symbol.ty.extent != Extent::Scalar)
}

/// Leaves as elements of triples or matrices, in an array or alone.
fn shaped(values: Vec<Value>, components: usize, array: bool) -> Option<Value> {
    let mut elements: Vec<Value> = match components {
        1 => values,
        n => values.chunks(n).map(|c| Value::List(c.to_vec())).collect(),
    };
    match (array, elements.is_empty()) {
        (_, true) => None,
        (true, false) => Some(Value::List(elements)),
        (false, false) => Some(elements.remove(0)),
    }
}

/// A `%meta{type,name,values}` hint.
pub(super) fn meta(hint: &Hint) -> Option<Metadata> {
    let [ty, name, values @ ..] = hint.args.as_slice() else { return None };
    if hint.name != "meta" {
        return None;
    }
    let resolved = super::parse::sym_type(ty.text()).ok()?;
    let base = resolved.base()?;
    let value = |arg: &HintArg| match (arg, base) {
        (HintArg::Str(s), _) => Value::Str(s.clone()),
        (HintArg::Word(w), Base::Int) => Value::Int(w.parse().unwrap_or(0)),
        (HintArg::Word(w), _) => Value::Float(w.parse().unwrap_or(0.0)),
    };
    let values = values.iter().map(value).collect();
    let value = shaped(values, resolved.components(), resolved.extent != Extent::Scalar);
    Some(Metadata { name: name.text().to_owned(), ty: ty.text().to_owned(), value })
}

/// How well an argument fits a formal: less is better.
fn cost(formal: &sig::Formal, arg: &Expr) -> Option<u32> {
    let Some(wanted) = formal.ty else { return (!formal.any_array || arg.ty.is_array()).then_some(0) };
    if wanted.is_array() || arg.ty.is_array() {
        let triples = wanted.base.is_triple() && arg.ty.base.is_triple();
        let fits = wanted.is_array() && arg.ty.is_array() && (wanted.base == arg.ty.base || triples);
        return fits.then_some(u32::from(wanted.base != arg.ty.base));
    }
    if wanted.base == arg.ty.base {
        return Some(0);
    }
    let triples = wanted.base.is_triple() && arg.ty.base.is_triple();
    if triples {
        return Some(1);
    }
    if formal.output {
        return None;
    }
    match (wanted.base, arg.ty.base) {
        (Base::Float, Base::Int) => Some(4),
        (b, Base::Float) if b.is_triple() || b == Base::Matrix => Some(16),
        (b, Base::Int) if b.is_triple() || b == Base::Matrix => Some(20),
        (Base::Closure, Base::Int) => matches!(arg.kind, ExprKind::Int(0)).then_some(8),
        _ => None,
    }
}

impl Reader<'_> {
    pub(super) fn binary(&mut self, op: &Op, operator: BinaryOp) -> Fit<Expr> {
        use BinaryOp::{Add, And, Div, Eq, Ge, Gt, Le, Lt, Mul, Ne, Or, Sub};
        let (l, r) = (single(op, self.arg(op, 1)?)?, single(op, self.arg(op, 2)?)?);
        let node = |kind: ExprKind, ty: Type| Expr { kind, ty, span: op.span };
        let (lb, rb) = (l.ty.base, r.ty.base);
        let closure = Type::scalar(Base::Closure);
        if l.ty == closure || r.ty == closure {
            let both = l.ty == r.ty;
            return match operator {
                Add if both => Ok(node(ExprKind::Binary(Add, Box::new(l), Box::new(r)), closure)),
                Mul if !both => {
                    let (c, w) = if l.ty == closure { (l, r) } else { (r, l) };
                    let w = self.factor(op, w)?;
                    Ok(node(ExprKind::Binary(Mul, Box::new(c), Box::new(w)), closure))
                }
                Div if !both && l.ty == closure => {
                    let w = self.factor(op, r)?;
                    let ty = w.ty;
                    let one = fitted(op, node(ExprKind::Float(1.0), Type::FLOAT), ty)?;
                    let inverse = node(ExprKind::Binary(Div, Box::new(one), Box::new(w)), ty);
                    Ok(node(ExprKind::Binary(Mul, Box::new(l), Box::new(inverse)), closure))
                }
                // The only comparison of closures is with the null closure.
                Eq | Ne if !both => {
                    let c = if l.ty == closure { l } else { r };
                    let set = node(ExprKind::Truth(Box::new(c)), Type::INT);
                    Ok(if operator == Ne { set } else { node(ExprKind::Not(Box::new(set)), Type::INT) })
                }
                _ => Err(unfit(op, "does not take these closures")),
            };
        }
        if matches!(operator, And | Or) {
            let (l, r) = (truth(op, l)?, truth(op, r)?);
            return Ok(node(ExprKind::Binary(operator, Box::new(l), Box::new(r)), Type::INT));
        }
        let rank = |b: Base| match b {
            Base::Int => 0,
            Base::Float => 1,
            b if b.is_triple() => 2,
            Base::Matrix => 3,
            Base::String => 4,
            _ => 5,
        };
        let wide = if rank(rb) > rank(lb) { rb } else { lb };
        let comparison = matches!(operator, Lt | Le | Gt | Ge | Eq | Ne);
        let mixed = wide == Base::Matrix && (lb.is_triple() || rb.is_triple());
        let fits = match operator {
            Add | Sub => rank(wide) < 3,
            Mul | Div => rank(wide) <= 3 && !mixed,
            Eq | Ne => rank(wide) <= 3 && !mixed || lb == Base::String && rb == Base::String,
            Lt | Le | Gt | Ge => rank(wide) <= 1,
            _ => rank(wide) == 0,
        };
        if !fits {
            return Err(unfit(op, format!("does not take {} and {}", lb.keyword(), rb.keyword())));
        }
        let operand = Type::scalar(wide);
        let (l, r) = (fitted(op, l, operand)?, fitted(op, r, operand)?);
        let ty = if comparison { Type::INT } else { operand };
        Ok(node(ExprKind::Binary(operator, Box::new(l), Box::new(r)), ty))
    }

    /// A closure's factor: a float or a color.
    fn factor(&self, op: &Op, e: Expr) -> Fit<Expr> {
        match e.ty.base {
            Base::Int => fitted(op, e, Type::FLOAT),
            b if b == Base::Float || b.is_triple() => Ok(e),
            _ => Err(unfit(op, "needs a float or a color as the factor of a closure")),
        }
    }

    pub(super) fn construct(&mut self, op: &Op) -> Fit<Expr> {
        let to = self.target(op, 0)?;
        let base = match op.name.as_str() {
            "color" => Base::Color,
            "point" => Base::Point,
            "vector" => Base::Vector,
            "normal" => Base::Normal,
            _ => Base::Matrix,
        };
        let ty = Type::scalar(base);
        let mut parts = Vec::new();
        for i in 1..op.args.len() {
            let e = single(op, self.arg(op, i)?)?;
            parts.push(if e.ty == Type::STRING { e } else { fitted(op, e, Type::FLOAT)? });
        }
        let strings = parts.iter().take_while(|e| e.ty == Type::STRING).count();
        let numbers = parts[strings..].iter().filter(|e| e.ty == Type::FLOAT).count();
        let all = strings + numbers == parts.len();
        let fits = match (base, strings) {
            (Base::Matrix, 0) => numbers == 16 || numbers == 1,
            (Base::Matrix, 1) => numbers == 16 || numbers == 1,
            (Base::Matrix, 2) => numbers == 0,
            (Base::Matrix, _) => false,
            (_, 0 | 1) => numbers == 3 || numbers == 1,
            _ => false,
        };
        if !fits || !all {
            return Err(unfit(op, "has arguments that make no such value"));
        }
        let kind = match (strings, numbers) {
            (0, 1) => ExprKind::Convert(Box::new(parts.remove(0))),
            _ => ExprKind::Construct(parts),
        };
        let value = fitted(op, Expr { kind, ty, span: op.span }, to.ty)?;
        let ty = to.ty;
        Ok(Expr { kind: ExprKind::Assign(Box::new(to), Box::new(value)), ty, span: op.span })
    }

    /// `closure result [weight] name arguments...`
    pub(super) fn closure(&mut self, op: &Op) -> Fit<Expr> {
        let first = self.arg(op, 1)?;
        let (weight, at) = if first.ty == Type::STRING { (None, 1) } else { (Some(first), 2) };
        let name = self.constant_string(op, at)?;
        let mut args = Vec::new();
        for i in at + 1..op.args.len() {
            args.push(self.arg(op, i)?);
        }
        let rows = CLOSURES.iter().enumerate().filter(|(_, row)| row.name == name);
        let mut best: Option<(u32, ClosureId)> = None;
        let mut known = false;
        for (i, _) in rows {
            known = true;
            let id = ClosureId(i as u16);
            let formals = sig::closure_formals(id);
            // What follows the formals is pairs of a token and a value.
            let paired = args.get(formals.len()).is_none_or(|a| a.ty == Type::STRING);
            if args.len() < formals.len() || !paired {
                continue;
            }
            let sum: Option<u32> = formals.iter().zip(&args).map(|(f, a)| cost(f, a)).sum();
            // The row that names more of the arguments is the better.
            let sum = sum.map(|s| s + 100 * (args.len() - formals.len()) as u32);
            if let Some(sum) = sum.filter(|s| best.is_none_or(|(b, _)| *s < b)) {
                best = Some((sum, id));
            }
        }
        let ty = Type::scalar(Base::Closure);
        let (callee, fitting) = match best {
            Some((_, id)) => {
                let formals = sig::closure_formals(id);
                let options = args.split_off(formals.len());
                let mut fitting = Vec::with_capacity(args.len());
                for (formal, arg) in formals.iter().zip(args) {
                    fitting.push(match formal.ty {
                        Some(ty) => fitted(op, arg, ty)?,
                        None => arg,
                    });
                }
                fitting.extend(closure_options(op, id, options)?);
                (Callee::Closure { id, formals: formals.len() }, fitting)
            }
            None if known => {
                return Err(unfit(op, format!("has arguments that closure `{name}` does not take")));
            }
            // Of another renderer: it contributes nothing.
            None => (Callee::User(self.vendor_closure(name, op.span)), args),
        };
        let call = Expr { kind: ExprKind::Call(callee, fitting), ty, span: op.span };
        match weight {
            None => Ok(call),
            Some(w) => {
                let w = self.factor(op, w)?;
                Ok(Expr { kind: ExprKind::Binary(BinaryOp::Mul, Box::new(call), Box::new(w)), ty, span: op.span })
            }
        }
    }

    pub(super) fn builtin(&mut self, op: &Op) -> Fit<Expr> {
        let name = row_name(&op.name);
        let Some(id) = builtins::find(name).filter(|id| builtins::row(*id).lowering.is_public()) else {
            let mut d = unfit(op, "is not known; the file may come from a compiler newer than this one");
            let known = builtins::TABLE.iter().filter(|r| r.lowering.is_public()).map(|r| r.name);
            if let Some(near) = crate::suggest::closest(name, known) {
                d = d.help(format!("is `{near}` meant?"));
            }
            return Err(d);
        };
        let kind = match op.name.as_str() {
            "transform" => Some(Base::Point),
            "transformv" => Some(Base::Vector),
            "transformn" => Some(Base::Normal),
            _ => None,
        };
        let mut all = Vec::with_capacity(op.args.len());
        for i in 0..op.args.len() {
            all.push(self.any_arg(op, i, name)?);
        }
        let mut best: Option<(u32, &sig::Overload)> = None;
        for o in sig::overloads(id) {
            let args = if o.ret == Type::VOID { &all[..] } else { all.get(1..).unwrap_or_default() };
            let counts = args.len() == o.formals.len() || o.variadic && args.len() > o.formals.len();
            if !counts || kind.is_some_and(|k| o.ret.base != k) {
                continue;
            }
            let Some(sum) = o.formals.iter().zip(args).map(|(f, a)| cost(f, a)).sum::<Option<u32>>() else { continue };
            let result = match all.first() {
                _ if o.ret == Type::VOID => Some(0),
                Some(to) => {
                    cost(&sig::Formal { ty: Some(to.ty), any_array: false, output: false }, &as_result(op, o.ret))
                }
                None => None,
            };
            // An overload without options is the better one.
            let sum = result.map(|r| sum * 4 + r + u32::from(o.variadic));
            if let Some(sum) = sum.filter(|s| best.is_none_or(|(b, _)| *s < b)) {
                best = Some((sum, o));
            }
        }
        let Some((_, chosen)) = best else {
            let given: Vec<&str> = all.iter().map(|e| e.ty.base.keyword()).collect();
            return Err(unfit(op, format!("does not take ({})", given.join(", "))));
        };
        let mut all = all.into_iter();
        let to = if chosen.ret == Type::VOID { None } else { all.next() };
        let mut args = Vec::new();
        for (i, arg) in all.enumerate() {
            args.push(match chosen.formals.get(i) {
                Some(f) if f.output && !matches!(arg.kind, ExprKind::Var(_)) => {
                    return Err(unfit(op, "writes to a constant"));
                }
                Some(sig::Formal { ty: Some(ty), output: false, .. }) if !ty.is_array() => fitted(op, arg, *ty)?,
                _ => arg,
            });
        }
        let callee = Callee::Builtin {
            id,
            formals: chosen.formals.iter().map(|f| f.ty.unwrap_or(Type::VOID)).collect(),
            outputs: chosen.formals.iter().map(|f| f.output).collect(),
        };
        let call = Expr { kind: ExprKind::Call(callee, args), ty: chosen.ret, span: op.span };
        let Some(to) = to else { return Ok(call) };
        if !matches!(to.kind, ExprKind::Var(_)) {
            return Err(unfit(op, "writes to a constant"));
        }
        let value = fitted(op, call, to.ty)?;
        let ty = to.ty;
        Ok(Expr { kind: ExprKind::Assign(Box::new(to), Box::new(value)), ty, span: op.span })
    }

    /// An argument. `isconnected` may ask for a struct parameter, `arraylength` for an array of structs: the first field
    /// stands for it.
    fn any_arg(&self, op: &Op, index: usize, name: &str) -> Fit<Expr> {
        let symbol = self.module.symbol(op.args[index]);
        if matches!(name, "isconnected" | "arraylength") && matches!(symbol.ty.element, Element::Struct(_)) {
            let inside = format!("{}.", symbol.name);
            let field = self.module.symbols.iter().position(|s| s.name.starts_with(&inside) && s.ty.base().is_some());
            if let Some(field) = field {
                return self.get(op, super::SymId(field as u32));
            }
        }
        self.arg(op, index)
    }
}

/// Pairs of a token and its value as the tree has them: a value per token of the closure's row, then the label. Tokens that
/// the closure does not know are left out, as from OSL.
fn closure_options(op: &Op, id: ClosureId, given: Vec<Expr>) -> Fit<Vec<Expr>> {
    let keys = sig::closure_keys(id);
    let mut values: Vec<Option<Expr>> = vec![None; keys.len()];
    let mut label = None;
    let mut given = given.into_iter();
    while let Some(token) = given.next() {
        let Some(value) = given.next() else { return Err(unfit(op, "has a token without a value")) };
        let text = match token.kind {
            ExprKind::Str(text) => text,
            _ if token.ty == Type::STRING => continue,
            _ => return Err(unfit(op, "needs pairs of a token and its value behind its arguments")),
        };
        if text == "label" {
            label = Some(fitted(op, value, Type::STRING)?);
        } else if let Some(index) = keys.iter().position(|k| k.token == text) {
            values[index] = Some(fitted(op, value, keys[index].ty)?);
        }
    }
    let default = |key: &sig::Key| {
        let kind = match key.ty.base {
            Base::Int => ExprKind::Int(key.default as i32),
            _ => ExprKind::Float(key.default),
        };
        Expr { kind, ty: key.ty, span: op.span }
    };
    let all = keys.iter().zip(values).map(|(key, value)| value.unwrap_or_else(|| default(key)));
    Ok(all.chain(label).collect())
}

/// A stand-in for a value of a type, to see whether it fits.
fn as_result(op: &Op, ty: Type) -> Expr {
    Expr { kind: ExprKind::Comma(Vec::new()), ty, span: op.span }
}
