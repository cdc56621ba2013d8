//! Instructions of the IR as instructions of the module, in the order of operations that OpenCL C's road has.

use super::bridge::{Param, Ret};
use super::module::{Op, Type, Word};
use super::writer::{Writer, type_of};
use crate::backend::{headers, names};
use crate::builtins;
use crate::diag::Diagnostic;
use crate::ir::{Arg, BinaryOp, Const, Inst, LocalId, Ty, UnaryOp, ValueId};
use crate::source::Span;
use rspirv::spirv::OpenclStd100Op;

/// Arguments that a function of SPIR-V can have.
pub(super) const MAX_ARGUMENTS: usize = 255;

impl Writer<'_> {
    pub(super) fn inst(&mut self, v: ValueId, inst: &Inst, ty: Ty, span: Span) -> Word {
        match inst {
            Inst::Const(c) => self.constant_value(c),
            Inst::Load(l) => self.load(*l),
            Inst::LoadElem(l, i) => {
                let len = self.shader.locals[l.0 as usize].len.unwrap_or(1);
                let index = self.index(*i, len);
                self.element(*l, index)
            }
            Inst::Unary(op, a) => self.unary(v, *op, *a),
            Inst::Binary(op, a, b) => self.binary(v, *op, *a, *b),
            Inst::Convert(a) => self.convert(*a, ty),
            Inst::Triple(parts) => {
                let parts = parts.map(|p| self.value(p));
                self.triple(parts)
            }
            Inst::Matrix(parts) => {
                let place = self.matrix_place();
                for (k, part) in parts.iter().enumerate() {
                    let value = self.value(*part);
                    self.set_matrix_element(place, k as i32, value);
                }
                place
            }
            Inst::Component(a, i) => self.component(*a, *i),
            Inst::WithComponent(a, i, x) => self.with_component(*a, *i, *x),
            Inst::MatrixElement(m, r, c) => {
                let index = self.matrix_index(*r, *c);
                let pointer = self.matrix_element(self.value(*m), index);
                let real = self.module.ty(Type::Real);
                self.module.inst(Op::Load, real, &[pointer])
            }
            Inst::WithMatrixElement(m, r, c, x) => {
                let place = self.matrix_place();
                self.copy_matrix(place, self.value(*m));
                let index = self.matrix_index(*r, *c);
                let pointer = self.matrix_element(place, index);
                self.module.effect(Op::Store, &[pointer, self.value(*x)]);
                place
            }
            Inst::Select(c, a, b) if ty == Ty::Matrix => self.helper("op_select_m", ty, &[*c, *a, *b]),
            Inst::Select(c, a, b) => {
                let condition = self.condition(*c);
                self.choose(condition, type_of(ty), self.value(*a), self.value(*b))
            }
            Inst::Call(func, args) => self.builtin(*func, args, &[], Some(ty), span),
            Inst::Albedo(id, args) => self.albedo(*id, args),
            Inst::Closure(..)
            | Inst::NullClosure
            | Inst::Layer(..)
            | Inst::AddClosure(..)
            | Inst::ScaleClosure(..)
            | Inst::ClosureIsSet(_) => {
                let message = "internal error: a closure reached the back end";
                self.errors.push(Diagnostic::error("E4399", span, message));
                self.module.int(0)
            }
        }
    }

    // ---- Small things -----------------------------------------------------------------------------------------------

    pub(super) fn triple(&mut self, parts: [Word; 3]) -> Word {
        self.module.three(Type::Triple, parts)
    }

    fn set_matrix_element(&mut self, place: Word, index: i32, value: Word) {
        let index = self.module.int(index);
        let pointer = self.matrix_element(place, index);
        self.module.effect(Op::Store, &[pointer, value]);
    }

    fn bool_op(&mut self, op: Op, operands: &[Word]) -> Word {
        let ty = self.module.ty(Type::Bool);
        self.module.inst(op, ty, operands)
    }

    fn int_op(&mut self, op: Op, operands: &[Word]) -> Word {
        let ty = self.module.ty(Type::Int);
        self.module.inst(op, ty, operands)
    }

    fn real_op(&mut self, op: Op, operands: &[Word]) -> Word {
        let ty = self.module.ty(Type::Real);
        self.module.inst(op, ty, operands)
    }

    /// `condition ? a : b` of a scalar or a triple; before SPIR-V 1.4 a vector is chosen by a vector.
    pub(super) fn choose(&mut self, condition: Word, ty: Type, a: Word, b: Word) -> Word {
        let condition = if ty == Type::Triple { self.module.three(Type::Bool3, [condition; 3]) } else { condition };
        let ty = self.module.ty(ty);
        self.module.inst(Op::Select, ty, &[condition, a, b])
    }

    /// A value as a bool: whether it is not 0.
    pub(super) fn condition(&mut self, v: ValueId) -> Word {
        if let Some(id) = self.bools.get(&v) {
            return *id;
        }
        let zero = self.module.int(0);
        self.bool_op(Op::INotEqual, &[self.value(v), zero])
    }

    /// A bool as the int that a value is.
    fn truth(&mut self, v: ValueId, bool: Word) -> Word {
        self.bools.insert(v, bool);
        let (one, zero) = (self.module.int(1), self.module.int(0));
        self.choose(bool, Type::Int, one, zero)
    }

    /// An index, clamped into range.
    pub(super) fn index(&mut self, v: ValueId, len: u32) -> Word {
        let last = len.saturating_sub(1).min(i32::MAX as u32) as i32;
        if let Some(i) = self.const_int(v) {
            return self.module.int(i.clamp(0, last));
        }
        let bounds = [self.module.int(0), self.module.int(last)];
        self.module.opencl(OpenclStd100Op::s_clamp, Type::Int, &[self.value(v), bounds[0], bounds[1]])
    }

    fn matrix_index(&mut self, row: ValueId, column: ValueId) -> Word {
        if let (Some(r), Some(c)) = (self.const_int(row), self.const_int(column)) {
            return self.module.int(4 * r.clamp(0, 3) + c.clamp(0, 3));
        }
        let (row, column) = (self.index(row, 4), self.index(column, 4));
        let first = self.scaled(row, 4, 0);
        self.int_op(Op::IAdd, &[first, column])
    }

    // ---- Components -------------------------------------------------------------------------------------------------

    fn component(&mut self, a: ValueId, i: ValueId) -> Word {
        let a = self.value(a);
        if let Some(i) = self.const_int(i) {
            return self.module.extract(Type::Real, a, i.clamp(0, 2) as u32);
        }
        let (first, second) = self.is_component(i);
        let parts = [0, 1, 2].map(|k| self.module.extract(Type::Real, a, k));
        let rest = self.choose(second, Type::Real, parts[1], parts[2]);
        self.choose(first, Type::Real, parts[0], rest)
    }

    /// Whether an index means the first component; else, whether it means the second.
    fn is_component(&mut self, i: ValueId) -> (Word, Word) {
        let (zero, one) = (self.module.int(0), self.module.int(1));
        let i = self.value(i);
        (self.bool_op(Op::SLessThanEqual, &[i, zero]), self.bool_op(Op::IEqual, &[i, one]))
    }

    fn with_component(&mut self, a: ValueId, i: ValueId, x: ValueId) -> Word {
        let (a, x) = (self.value(a), self.value(x));
        if let Some(i) = self.const_int(i) {
            return self.module.insert(Type::Triple, x, a, i.clamp(0, 2) as u32);
        }
        let (first, second) = self.is_component(i);
        let [p, q, r] = [0, 1, 2].map(|k| self.module.insert(Type::Triple, x, a, k));
        let rest = self.choose(second, Type::Triple, q, r);
        self.choose(first, Type::Triple, p, rest)
    }

    // ---- Operators --------------------------------------------------------------------------------------------------

    fn unary(&mut self, v: ValueId, op: UnaryOp, a: ValueId) -> Word {
        let ty = self.value_ty(a);
        match (op, ty) {
            (UnaryOp::Neg, Ty::Matrix) => self.helper("op_neg_m", ty, &[a]),
            (UnaryOp::Neg, Ty::Float | Ty::Triple) => {
                let ty = self.module.ty(type_of(ty));
                self.module.inst(Op::FNegate, ty, &[self.value(a)])
            }
            (UnaryOp::Neg, _) => self.int_op(Op::SNegate, &[self.value(a)]),
            (UnaryOp::Compl, _) => self.int_op(Op::Not, &[self.value(a)]),
            (UnaryOp::Not, _) => {
                let condition = self.condition(a);
                let not = self.bool_op(Op::LogicalNot, &[condition]);
                self.truth(v, not)
            }
        }
    }

    fn convert(&mut self, a: ValueId, to: Ty) -> Word {
        let value = self.value(a);
        match (self.value_ty(a), to) {
            (Ty::Float, Ty::Int) => self.truncated(value),
            (Ty::Float, Ty::Matrix) => {
                let place = self.matrix_place();
                let zero = self.module.real(0.0);
                for k in 0..16 {
                    self.set_matrix_element(place, k, if k % 5 == 0 { value } else { zero });
                }
                place
            }
            (Ty::Float, Ty::Triple) => self.triple([value; 3]),
            _ => self.real_op(Op::ConvertSToF, &[value]),
        }
    }

    /// An int as a real.
    pub(super) fn int_to_real(&mut self, value: Word) -> Word {
        self.real_op(Op::ConvertSToF, &[value])
    }

    /// A float to an int: towards zero; the smallest int for what no int holds, and for NaN.
    fn truncated(&mut self, value: Word) -> Word {
        let (low, high) = (self.module.real(-2_147_483_648.0), self.module.real(2_147_483_648.0));
        let fits_above = self.bool_op(Op::FOrdLessThan, &[value, high]);
        let fits_below = self.bool_op(Op::FOrdGreaterThanEqual, &[value, low]);
        let fits = self.bool_op(Op::LogicalAnd, &[fits_above, fits_below]);
        // What cannot be converted must not reach the conversion, whose result would be anything.
        let safe = self.choose(fits, Type::Real, value, low);
        self.int_op(Op::ConvertFToS, &[safe])
    }

    /// Whether a divisor is a constant for which the plain division is OSL's, but for dividends that are not finite or overflow.
    fn harmless_divisor(&self, b: ValueId) -> bool {
        let harmless = |f: &f64| (*f as f32).is_normal();
        match &self.shader.values[b.0 as usize].inst {
            Inst::Const(Const::Int(i)) => !matches!(i, 0 | -1),
            Inst::Const(Const::Float(f)) => harmless(f),
            Inst::Const(Const::Triple(t)) => t.iter().all(harmless),
            _ => false,
        }
    }

    fn binary(&mut self, v: ValueId, op: BinaryOp, a: ValueId, b: ValueId) -> Word {
        use BinaryOp::*;
        let ty = self.value_ty(a);
        if ty == Ty::Matrix {
            return self.of_matrices(v, op, a, b);
        }
        let (x, y) = (self.value(a), self.value(b));
        if matches!(op, Eq | Ne | Lt | Le | Gt | Ge) {
            let bool = self.comparison(op, ty, x, y);
            return self.truth(v, bool);
        }
        if matches!(ty, Ty::Float | Ty::Triple) {
            let plain = match op {
                Add => Op::FAdd,
                Sub => Op::FSub,
                Mul => Op::FMul,
                _ => Op::FDiv,
            };
            let harmless = op != Div || self.harmless_divisor(b);
            return match ty {
                Ty::Triple if !harmless => {
                    let parts = [0, 1, 2].map(|k| {
                        let (p, q) = (self.module.extract(Type::Real, x, k), self.module.extract(Type::Real, y, k));
                        self.quotient(p, q)
                    });
                    self.triple(parts)
                }
                _ if !harmless => self.quotient(x, y),
                ty => {
                    let ty = self.module.ty(type_of(ty));
                    self.module.inst(plain, ty, &[x, y])
                }
            };
        }
        match op {
            Add => self.int_op(Op::IAdd, &[x, y]),
            Sub => self.int_op(Op::ISub, &[x, y]),
            Mul => self.int_op(Op::IMul, &[x, y]),
            Div | Mod => {
                let plain = if op == Div { Op::SDiv } else { Op::SRem };
                if self.harmless_divisor(b) {
                    return self.int_op(plain, &[x, y]);
                }
                self.of_any_divisor(plain, x, y)
            }
            BitAnd => self.int_op(Op::BitwiseAnd, &[x, y]),
            BitOr => self.int_op(Op::BitwiseOr, &[x, y]),
            BitXor => self.int_op(Op::BitwiseXor, &[x, y]),
            _ => {
                let mask = self.module.int(31);
                let count = self.int_op(Op::BitwiseAnd, &[y, mask]);
                self.int_op(if op == Shl { Op::ShiftLeftLogical } else { Op::ShiftRightArithmetic }, &[x, count])
            }
        }
    }

    /// x / 0 = 0, x % 0 = 0, and -1 is negation: the smallest int wraps.
    fn of_any_divisor(&mut self, op: Op, x: Word, y: Word) -> Word {
        let (zero, one, minus) = (self.module.int(0), self.module.int(1), self.module.int(-1));
        let is_zero = self.bool_op(Op::IEqual, &[y, zero]);
        let is_minus = self.bool_op(Op::IEqual, &[y, minus]);
        let special = self.bool_op(Op::LogicalOr, &[is_zero, is_minus]);
        let safe = self.choose(special, Type::Int, one, y);
        let plain = self.int_op(op, &[x, safe]);
        if op == Op::SRem {
            return self.choose(special, Type::Int, zero, plain);
        }
        let negated = self.int_op(Op::SNegate, &[x]);
        let rest = self.choose(is_zero, Type::Int, zero, plain);
        self.choose(is_minus, Type::Int, negated, rest)
    }

    /// A quotient that is no finite float is 0 (kernels/osl/ops.h).
    fn quotient(&mut self, x: Word, y: Word) -> Word {
        let plain = self.real_op(Op::FDiv, &[x, y]);
        let (zero, most) = (self.module.real(0.0), self.module.real(f64::from(f32::MAX)));
        let size = self.module.opencl(OpenclStd100Op::fabs, Type::Real, &[plain]);
        let divides = self.bool_op(Op::FUnordNotEqual, &[y, zero]);
        let finite = self.bool_op(Op::FOrdLessThanEqual, &[size, most]);
        let good = self.bool_op(Op::LogicalAnd, &[divides, finite]);
        self.choose(good, Type::Real, plain, zero)
    }

    fn comparison(&mut self, op: BinaryOp, ty: Ty, x: Word, y: Word) -> Word {
        use BinaryOp::*;
        match ty {
            Ty::Triple => {
                let bools = self.module.ty(Type::Bool3);
                let (each, join) = if op == Eq { (Op::FOrdEqual, Op::All) } else { (Op::FUnordNotEqual, Op::Any) };
                let parts = self.module.inst(each, bools, &[x, y]);
                self.bool_op(join, &[parts])
            }
            Ty::Float => {
                let op = match op {
                    Eq => Op::FOrdEqual,
                    Ne => Op::FUnordNotEqual,
                    Lt => Op::FOrdLessThan,
                    Le => Op::FOrdLessThanEqual,
                    Gt => Op::FOrdGreaterThan,
                    _ => Op::FOrdGreaterThanEqual,
                };
                self.bool_op(op, &[x, y])
            }
            _ => {
                let op = match op {
                    Eq => Op::IEqual,
                    Ne => Op::INotEqual,
                    Lt => Op::SLessThan,
                    Le => Op::SLessThanEqual,
                    Gt => Op::SGreaterThan,
                    _ => Op::SGreaterThanEqual,
                };
                self.bool_op(op, &[x, y])
            }
        }
    }

    fn of_matrices(&mut self, v: ValueId, op: BinaryOp, a: ValueId, b: ValueId) -> Word {
        match op {
            BinaryOp::Mul => self.helper("op_mul_m", Ty::Matrix, &[a, b]),
            BinaryOp::Div => self.helper("op_div_m", Ty::Matrix, &[a, b]),
            _ => {
                let equal = self.helper("op_eq_m", Ty::Int, &[a, b]);
                let zero = self.module.int(0);
                let op = if op == BinaryOp::Eq { Op::INotEqual } else { Op::IEqual };
                let bool = self.bool_op(op, &[equal, zero]);
                self.truth(v, bool)
            }
        }
    }

    // ---- Calls ------------------------------------------------------------------------------------------------------

    /// Calls a built-in's kernel function through the bridge; its value, if it has one.
    pub(super) fn builtin(
        &mut self,
        func: builtins::FuncId,
        args: &[Arg],
        outputs: &[LocalId],
        result: Option<Ty>,
        span: Span,
    ) -> Word {
        let row = builtins::row(func);
        let mut codes = String::new();
        let mut params = Vec::new();
        let mut given = Vec::new();
        // For each parameter of the bridge: the length of an array that follows it.
        let mut lengths: Vec<Option<u32>> = Vec::new();
        if matches!(row.lowering, builtins::Lowering::State | builtins::Lowering::InternalState) {
            params.push(Param::Globals);
            given.push(self.globals);
            lengths.push(None);
        }
        for arg in args {
            match arg {
                Arg::Value(v) => {
                    let ty = self.value_ty(*v);
                    codes.push(ty.code());
                    params.push(Param::Value(ty));
                    given.push(self.argument(ty, self.value(*v)));
                    lengths.push(None);
                }
                Arg::Array(l) => {
                    let local = &self.shader.locals[l.0 as usize];
                    codes.extend(['a', local.ty.code()]);
                    params.push(Param::Place(local.ty));
                    given.push(self.place(*l));
                    lengths.push(Some(local.len.unwrap_or(0)));
                }
            }
        }
        for l in outputs {
            let local = &self.shader.locals[l.0 as usize];
            codes.push('o');
            if local.len.is_some() {
                codes.push('a');
            }
            codes.push(local.ty.code());
            params.push(Param::Place(local.ty));
            given.push(self.place(*l));
            lengths.push(local.len);
        }
        if given.len() >= MAX_ARGUMENTS {
            let message =
                format!("this call has more than the {MAX_ARGUMENTS} arguments that functions of SPIR-V have");
            self.errors.push(Diagnostic::error("E4301", span, message));
            return self.module.int(0);
        }
        self.bridge.includes.insert(headers::of_function(row.name));
        let function = names::kernel_function(row.name, result, &codes);
        let known: String = lengths.iter().flatten().map(|n| format!("_{n}")).collect();
        let ret = result.map_or(Ret::Nothing, Ret::Value);
        let body = |texts: &[String]| {
            let mut list = Vec::new();
            for (text, len) in texts.iter().zip(&lengths) {
                list.push(text.clone());
                list.extend(len.map(|n| n.to_string()));
            }
            let call = format!("{function}({})", list.join(", "));
            if result.is_some() { call } else { format!("    {call};\n") }
        };
        let id = self.bridge.function(&mut self.module, &format!("{function}{known}"), ret, &params, body);
        match result {
            Some(ty) => self.call(id, ty, &given),
            None => {
                self.call_nothing(id, &given);
                self.module.int(0)
            }
        }
    }
}
