//! Instructions as C expressions: operators, conversions, calls of built-ins.
//!
//! In: an instruction. Out: an [`Expr`], its operands inlined or named by the [`Writer`].

use super::writer::{Expr, Prec, Writer};
use crate::backend::headers;
use crate::backend::names;
use crate::builtins;
use crate::diag::Diagnostic;
use crate::ir::{Arg, BinaryOp, Const, Inst, LocalId, Ty, UnaryOp, ValueId};
use crate::source::Span;

impl Writer<'_> {
    pub(super) fn index(&mut self, v: ValueId, len: u32) -> Expr {
        let last = len.saturating_sub(1).min(i32::MAX as u32) as i32;
        if let Inst::Const(Const::Int(i)) = self.shader.values[v.0 as usize].inst {
            self.operand(v);
            return Expr::new((i.clamp(0, last)).to_string(), Prec::Primary);
        }
        let e = self.operand(v);
        Expr::new(format!("clamp({}, 0, {last})", e.text), Prec::Primary).reads(&[&e])
    }

    /// The array's index as text; reads are remembered by the caller's statement.
    pub(super) fn index_text(&mut self, v: ValueId, len: u32) -> String {
        self.index(v, len).text
    }

    fn call(&mut self, function: &str, args: &[Expr]) -> Expr {
        let texts: Vec<&str> = args.iter().map(|a| a.text.as_str()).collect();
        let reads: Vec<&Expr> = args.iter().collect();
        Expr::new(format!("{function}({})", texts.join(", ")), Prec::Primary).reads(&reads)
    }

    fn op_call(&mut self, function: &'static str, args: &[ValueId]) -> Expr {
        let args: Vec<Expr> = args.iter().map(|a| self.operand(*a)).collect();
        let function = self.op(function);
        self.call(function, &args)
    }

    /// Name and arguments of a built-in's kernel function.
    pub(super) fn builtin(
        &mut self,
        func: builtins::FuncId,
        args: &[Arg],
        outputs: &[LocalId],
        result: Option<Ty>,
    ) -> Expr {
        let row = builtins::row(func);
        let mut codes = String::new();
        let mut list = Vec::new();
        if matches!(row.lowering, builtins::Lowering::State | builtins::Lowering::InternalState) {
            list.push(Expr::new("sg", Prec::Primary));
        }
        for arg in args {
            match arg {
                Arg::Value(v) => {
                    codes.push(self.shader.values[v.0 as usize].ty.code());
                    list.push(self.operand(*v));
                }
                Arg::Array(l) => {
                    codes.push('a');
                    let (name, len) = self.array(*l, &mut codes);
                    let mut e = Expr::new(name, Prec::Primary);
                    if self.local_use(*l).changes {
                        e.loads.push(*l);
                    }
                    list.extend([e, Expr::new(len, Prec::Primary)]);
                }
            }
        }
        for l in outputs {
            let local = &self.shader.locals[l.0 as usize];
            codes.push('o');
            if local.len.is_some() {
                codes.push('a');
                let (name, len) = self.array(*l, &mut codes);
                list.extend([Expr::new(name, Prec::Primary), Expr::new(len, Prec::Primary)]);
            } else {
                codes.push(local.ty.code());
                list.push(Expr::new(format!("&{}", self.name(*l)), Prec::Unary));
            }
        }
        self.includes.insert(headers::of_function(row.name));
        let function = names::kernel_function(row.name, result, &codes);
        self.call(&function, &list)
    }

    fn array(&self, l: LocalId, codes: &mut String) -> (String, String) {
        let local = &self.shader.locals[l.0 as usize];
        codes.push(local.ty.code());
        (self.name(l).to_owned(), local.len.unwrap_or(0).to_string())
    }

    pub(super) fn inst(&mut self, inst: &Inst, ty: Ty, span: Span) -> Expr {
        match inst {
            Inst::Const(c) => {
                let negative = matches!(c, Const::Int(i) if *i < 0 && *i != i32::MIN)
                    || matches!(c, Const::Float(f) if f.is_sign_negative() && !f.is_nan())
                    || matches!(c, Const::Triple(_) | Const::Str(_));
                Expr::new(self.constant(c), if negative { Prec::Unary } else { Prec::Primary })
            }
            Inst::Load(l) => self.load(*l),
            Inst::LoadElem(l, i) => {
                let len = self.shader.locals[l.0 as usize].len.unwrap_or(1);
                let index = self.index(*i, len);
                self.element(*l, &index.text).reads(&[&index])
            }
            Inst::Unary(op, a) => self.unary(*op, *a),
            Inst::Binary(op, a, b) => self.binary(*op, *a, *b),
            Inst::Convert(a) => self.convert(*a, ty),
            Inst::Triple(parts) => {
                let parts = parts.map(|p| self.operand(p));
                let mut e = self.call("(real3)", &parts);
                e.prec = Prec::Unary;
                e
            }
            Inst::Matrix(parts) => {
                self.op("op_matrix_f");
                let parts: Vec<Expr> = parts.iter().map(|p| self.operand(*p)).collect();
                self.call("make_mat4", &parts)
            }
            Inst::Component(v, i) => match self.shader.values[i.0 as usize].inst {
                Inst::Const(Const::Int(_)) => {
                    let index = self.index(*i, 3);
                    let v = self.operand(*v);
                    Expr::new(format!("{}.{}", v.at(Prec::Primary), component(&index.text)), Prec::Primary).reads(&[&v])
                }
                _ => self.op_call("op_get_v", &[*v, *i]),
            },
            Inst::WithComponent(v, i, x) => match self.shader.values[i.0 as usize].inst {
                Inst::Const(Const::Int(_)) => {
                    let index = self.index(*i, 3);
                    let (v, x) = (self.operand(*v), self.operand(*x));
                    let function = self.op("op_set_v");
                    let text = format!("{function}({}, {}, {})", v.text, index.text, x.text);
                    let place = format!("{}.{}", v.text, component(&index.text));
                    let update = v.whole.map(|l| (l, place, x.text.clone()));
                    Expr { update, ..Expr::new(text, Prec::Primary).reads(&[&v, &x]) }
                }
                _ => self.op_call("op_set_v", &[*v, *i, *x]),
            },
            Inst::MatrixElement(m, r, c) => self.op_call("op_get_m", &[*m, *r, *c]),
            Inst::WithMatrixElement(m, r, c, x) => self.op_call("op_set_m", &[*m, *r, *c, *x]),
            Inst::Select(c, a, b) => match ty {
                Ty::Triple => self.op_call("op_select_v", &[*c, *a, *b]),
                Ty::Matrix => self.op_call("op_select_m", &[*c, *a, *b]),
                _ => {
                    let (c, a, b) = (self.operand(*c), self.operand(*a), self.operand(*b));
                    let tight = Prec::Bits;
                    let text = format!("{} ? {} : {}", c.at(tight), a.at(tight), b.at(tight));
                    Expr::new(text, Prec::Conditional).reads(&[&c, &a, &b])
                }
            },
            Inst::Call(func, args) => self.builtin(*func, args, &[], Some(ty)),
            Inst::Albedo(id, args) => super::lobes::albedo(self, *id, args),
            Inst::Closure(..)
            | Inst::NullClosure
            | Inst::Layer(..)
            | Inst::AddClosure(..)
            | Inst::ScaleClosure(..)
            | Inst::ClosureIsSet(_) => {
                let message = "internal error: a closure reached the back end";
                self.errors.push(Diagnostic::error("E4299", span, message));
                Expr::new("0", Prec::Primary)
            }
        }
    }

    fn unary(&mut self, op: UnaryOp, a: ValueId) -> Expr {
        match (op, self.shader.values[a.0 as usize].ty) {
            (UnaryOp::Neg, Ty::Int) => self.op_call("op_neg_i", &[a]),
            (UnaryOp::Neg, Ty::Matrix) => self.op_call("op_neg_m", &[a]),
            (op, _) => {
                let sign = match op {
                    UnaryOp::Neg => "-",
                    UnaryOp::Compl => "~",
                    UnaryOp::Not => "!",
                };
                let a = self.operand(a);
                Expr::new(format!("{sign}{}", a.at(Prec::Primary)), Prec::Unary).reads(&[&a])
            }
        }
    }

    fn convert(&mut self, a: ValueId, to: Ty) -> Expr {
        match (self.shader.values[a.0 as usize].ty, to) {
            (Ty::Float, Ty::Int) => self.op_call("op_int_f", &[a]),
            (Ty::Float, Ty::Matrix) => self.op_call("op_matrix_f", &[a]),
            (_, Ty::Triple) => {
                let literal = matches!(self.shader.values[a.0 as usize].inst, Inst::Const(_));
                let a = self.operand(a);
                let e = Expr::new(format!("(real3)({})", a.text), Prec::Unary).reads(&[&a]);
                Expr { splat: (!literal).then(|| Box::new(a)), ..e }
            }
            _ => {
                let a = self.operand(a);
                Expr::new(format!("(real){}", a.at(Prec::Unary)), Prec::Unary).reads(&[&a])
            }
        }
    }

    /// Whether a divisor is a constant for which C's division is OSL's, but for dividends that are not finite or overflow.
    fn harmless_divisor(&self, b: ValueId) -> bool {
        // What is 0 or infinite as a 32-bit float is no harmless divisor.
        let harmless = |f: &f64| (*f as f32).is_normal();
        match &self.shader.values[b.0 as usize].inst {
            Inst::Const(Const::Int(i)) => !matches!(i, 0 | -1),
            Inst::Const(Const::Float(f)) => harmless(f),
            Inst::Const(Const::Triple(t)) => t.iter().all(harmless),
            _ => false,
        }
    }

    fn binary(&mut self, op: BinaryOp, a: ValueId, b: ValueId) -> Expr {
        use BinaryOp::*;
        let ty = self.shader.values[a.0 as usize].ty;
        let helper = match (op, ty) {
            (Add, Ty::Int) => "op_add_i",
            (Sub, Ty::Int) => "op_sub_i",
            (Mul, Ty::Int) => "op_mul_i",
            (Div, Ty::Int) if !self.harmless_divisor(b) => "op_div_i",
            (Mod, _) if !self.harmless_divisor(b) => "op_rem_i",
            (Shl, _) => "op_shl_i",
            (Shr, _) => "op_shr_i",
            (Div, Ty::Float) if !self.harmless_divisor(b) => "op_div_f",
            (Div, Ty::Triple) if !self.harmless_divisor(b) => "op_div_v",
            (Mul, Ty::Matrix) => "op_mul_m",
            (Div, Ty::Matrix) => "op_div_m",
            (Eq | Ne, Ty::Triple) => "op_eq_v",
            (Eq | Ne, Ty::Matrix) => "op_eq_m",
            _ => "",
        };
        if !helper.is_empty() {
            let e = self.op_call(helper, &[a, b]);
            return if op == Ne { Expr { prec: Prec::Unary, text: format!("!{}", e.text), ..e } } else { e };
        }
        let (sign, prec) = match op {
            Add => ("+", Prec::Sum),
            Sub => ("-", Prec::Sum),
            Mul => ("*", Prec::Product),
            Div => ("/", Prec::Product),
            Mod => ("%", Prec::Product),
            Eq => ("==", Prec::Equality),
            Ne => ("!=", Prec::Equality),
            Lt => ("<", Prec::Relation),
            Le => ("<=", Prec::Relation),
            Gt => (">", Prec::Relation),
            Ge => (">=", Prec::Relation),
            BitAnd | Shl | Shr => ("&", Prec::Bits),
            BitOr => ("|", Prec::Bits),
            BitXor => ("^", Prec::Bits),
        };
        let (mut a, mut b) = (self.operand(a), self.operand(b));
        // A float beside a triple acts on each component.
        match (a.splat.take(), b.splat.take()) {
            (Some(f), None) if prec >= Prec::Sum => a = *f,
            (None, Some(f)) if prec >= Prec::Sum => b = *f,
            _ => {}
        }
        // Comparisons and bits: parentheses around anything compound, as compilers' warnings and readers want.
        let (left, right) = match prec {
            Prec::Sum => (Prec::Sum, Prec::Product),
            Prec::Product => (Prec::Product, Prec::Unary),
            Prec::Relation | Prec::Equality => (Prec::Sum, Prec::Sum),
            _ => (Prec::Unary, Prec::Unary),
        };
        Expr::new(format!("{} {sign} {}", a.at(left), b.at(right)), prec).reads(&[&a, &b])
    }
}

/// The field of a real3 with this index.
pub(super) fn component(index: &str) -> &'static str {
    match index {
        "0" => "x",
        "1" => "y",
        _ => "z",
    }
}
