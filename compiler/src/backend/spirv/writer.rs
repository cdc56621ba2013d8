//! The state of one emission: the module, the bridge, where values and variables are.
//!
//! A value is an id; of a matrix the variable that holds it. A local is a variable, unless nothing writes it: then it is what the
//! renderer supplies, read once at the top, or zero.

use super::Width;
use super::bridge::{Bridge, Param, Ret};
use super::module::{Module, Op, Type, Word};
use crate::backend::analysis::{Analysis, LocalUse};
use crate::backend::{slots, string_id};
use crate::diag::Diagnostic;
use crate::ir::{Block, Const, InputLayout, Inst, LocalId, LocalKind, Shader, Stmt, Ty, ValueId, slots_of};
use std::collections::HashMap;

/// Longer constant arrays lie in constant memory.
const MAX_PRIVATE_TABLE: u32 = 16;

/// Elements of a part of a table: an instruction holds at most 65,535 words.
const CHUNK: usize = 4096;

/// The longest array with constants in it that is no table.
const MAX_INITIAL: u32 = 60_000;

/// What a loop's jumps lead to.
pub(super) struct Jumps {
    pub leave: Word,
    pub next: Word,
}

/// Where a local is.
#[derive(Clone, Copy, Debug)]
enum Home {
    /// Never touched.
    Nowhere,
    /// A value (of a matrix: its variable) that never changes.
    Fixed(Word),
    /// A variable; of an array the whole.
    Variable(Word),
    /// A table in constant memory, of numbers: in parts of [`CHUNK`] or whole.
    Table { id: Word, chunked: bool },
}

/// One emission.
pub(super) struct Writer<'a> {
    pub shader: &'a Shader,
    pub inputs: InputLayout,
    pub analysis: Analysis<'a>,
    pub module: Module,
    pub bridge: Bridge,
    pub errors: Vec<Diagnostic>,
    pub loops: Vec<Jumps>,
    /// The parameter `sg`.
    pub globals: Word,
    /// Numbers of the calls that print.
    pub sites: HashMap<*const Stmt, u32>,
    homes: Vec<Home>,
    values: Vec<Word>,
    /// Comparisons, as the bools that they are.
    pub bools: HashMap<ValueId, Word>,
}

impl<'a> Writer<'a> {
    pub(super) fn new(shader: &'a Shader, results: &[LocalId], entry: &str, width: Width) -> Writer<'a> {
        let mut w = Writer {
            shader,
            inputs: InputLayout::of(shader),
            analysis: Analysis::of(shader, results),
            module: Module::new(width),
            bridge: Bridge::new(entry),
            errors: Vec::new(),
            loops: Vec::new(),
            globals: 0,
            sites: HashMap::new(),
            homes: vec![Home::Nowhere; shader.locals.len()],
            values: vec![0; shader.values.len()],
            bools: HashMap::new(),
        };
        w.bridge.includes.insert("globals.h");
        for block in shader.blocks() {
            w.number(block);
        }
        w
    }

    /// Numbers the calls that print, in the order in which OpenCL C has them: a loop's step before its body.
    fn number(&mut self, block: &Block) {
        for stmt in &block.stmts {
            match stmt {
                Stmt::Call { func, .. } if crate::builtins::has_effect(*func) => {
                    let number = self.sites.len() as u32;
                    self.sites.insert(stmt, number);
                }
                Stmt::If(_, a, b) => {
                    self.number(a);
                    self.number(b);
                }
                Stmt::Loop(l) => {
                    self.number(&l.head);
                    self.number(&l.step);
                    self.number(&l.body);
                }
                _ => {}
            }
        }
    }

    pub(super) fn local_use(&self, l: LocalId) -> &LocalUse {
        &self.analysis.locals[l.0 as usize]
    }

    pub(super) fn value(&self, v: ValueId) -> Word {
        self.values[v.0 as usize]
    }

    pub(super) fn value_ty(&self, v: ValueId) -> Ty {
        self.shader.values[v.0 as usize].ty
    }

    /// The constant int that a value is.
    pub(super) fn const_int(&self, v: ValueId) -> Option<i32> {
        match self.shader.values[v.0 as usize].inst {
            Inst::Const(Const::Int(i)) => Some(i),
            _ => None,
        }
    }

    /// Computes a value here.
    pub(super) fn compute(&mut self, v: ValueId) {
        if self.analysis.is_dead(v) {
            return;
        }
        let value = &self.shader.values[v.0 as usize];
        let id = self.inst(v, &value.inst, value.ty, value.span);
        self.values[v.0 as usize] = id;
    }

    // ---- Types and constants ----------------------------------------------------------------------------------------

    /// The id of the type of a value in memory.
    pub(super) fn memory_ty(&mut self, ty: Ty) -> Word {
        self.module.ty(type_of(ty))
    }

    /// The id of a constant, of a matrix as an array of reals.
    pub(super) fn constant(&mut self, c: &Const) -> Word {
        match c {
            Const::Int(v) => self.module.int(*v),
            Const::Str(s) => self.module.int(string_id(s) as i32),
            Const::Float(v) => self.module.real(*v),
            Const::Triple(t) => {
                let parts = t.map(|x| self.module.real(x)).to_vec();
                let ty = self.module.ty(Type::Triple);
                self.module.composite(ty, parts)
            }
            Const::Matrix(m) => {
                let parts = m.map(|x| self.module.real(x)).to_vec();
                let ty = self.module.ty(Type::Matrix);
                self.module.composite(ty, parts)
            }
            Const::Array(_) => self.module.int(0),
        }
    }

    /// A constant as a value: a matrix in a variable of its own.
    pub(super) fn constant_value(&mut self, c: &Const) -> Word {
        let id = self.constant(c);
        if !matches!(c, Const::Matrix(_)) {
            return id;
        }
        let place = self.matrix_place();
        self.module.effect(Op::Store, &[place, id]);
        place
    }

    pub(super) fn zero(&mut self, ty: Ty) -> Word {
        let zero = self.zero_constant(ty);
        if ty != Ty::Matrix {
            return zero;
        }
        let place = self.matrix_place();
        self.module.effect(Op::Store, &[place, zero]);
        place
    }

    /// Zero as a constant. Of numbers it is none of OpConstantNull's: translators to LLVM stumble over that.
    fn zero_constant(&mut self, ty: Ty) -> Word {
        match ty {
            Ty::Float => self.module.real(0.0),
            Ty::Triple | Ty::Matrix => {
                let id = self.memory_ty(ty);
                self.module.null(id)
            }
            _ => self.module.int(0),
        }
    }

    /// A variable for a matrix.
    pub(super) fn matrix_place(&mut self) -> Word {
        let ty = self.module.ty(Type::Matrix);
        self.module.variable(ty)
    }

    /// A pointer to the first real of a matrix's variable.
    pub(super) fn matrix_pointer(&mut self, variable: Word) -> Word {
        let zero = self.module.int(0);
        let ty = self.module.ty(Type::RealPointer);
        self.module.inst(Op::InBoundsAccessChain, ty, &[variable, zero])
    }

    /// A pointer to an element (given as an id) of a matrix's variable.
    pub(super) fn matrix_element(&mut self, variable: Word, index: Word) -> Word {
        let ty = self.module.ty(Type::RealPointer);
        self.module.inst(Op::InBoundsAccessChain, ty, &[variable, index])
    }

    pub(super) fn copy_matrix(&mut self, to: Word, from: Word) {
        let bytes = self.module.size(Type::Matrix);
        self.module.copy(to, from, false, bytes);
    }

    // ---- Calls of the bridge ----------------------------------------------------------------------------------------

    /// An argument for a function of the bridge.
    pub(super) fn argument(&mut self, ty: Ty, value: Word) -> Word {
        if ty == Ty::Matrix { self.matrix_pointer(value) } else { value }
    }

    /// Calls a function of the bridge for its value.
    pub(super) fn call(&mut self, function: Word, ret: Ty, args: &[Word]) -> Word {
        if ret == Ty::Matrix {
            let place = self.matrix_place();
            let pointer = self.matrix_pointer(place);
            self.call_nothing(function, &[&[pointer][..], args].concat());
            return place;
        }
        let ty = self.module.ty(type_of(ret));
        self.module.inst(Op::FunctionCall, ty, &[&[function][..], args].concat())
    }

    /// Calls a function of the bridge that gives nothing back.
    pub(super) fn call_nothing(&mut self, function: Word, args: &[Word]) {
        let ty = self.module.ty(Type::Void);
        self.module.inst(Op::FunctionCall, ty, &[&[function][..], args].concat());
    }

    /// A helper of kernels/osl/ on values.
    pub(super) fn helper(&mut self, name: &'static str, ret: Ty, values: &[ValueId]) -> Word {
        let types: Vec<Ty> = values.iter().map(|v| self.value_ty(*v)).collect();
        let params: Vec<Param> = types.iter().map(|t| Param::Value(*t)).collect();
        self.bridge.includes.insert(crate::backend::headers::of_op(name));
        let body = |args: &[String]| format!("{name}({})", args.join(", "));
        let function = self.bridge.function(&mut self.module, name, Ret::Value(ret), &params, body);
        let args: Vec<Word> = values.iter().zip(types).map(|(v, ty)| self.argument(ty, self.value(*v))).collect();
        self.call(function, ret, &args)
    }

    // ---- Locals -----------------------------------------------------------------------------------------------------

    /// Gives every local its place, and puts into it what it holds before anything runs.
    pub(super) fn declare_all(&mut self) {
        let used = self.analysis.locals.iter().map(|u| u.touched).collect::<Vec<bool>>();
        for (i, touched) in used.into_iter().enumerate() {
            let local = &self.shader.locals[i];
            if touched && local.ty != Ty::Closure {
                let home = self.declare(LocalId(i as u32));
                if let Home::Variable(id) | Home::Table { id, .. } = home {
                    self.module.name(id, &local.name);
                }
                self.homes[i] = home;
            }
        }
    }

    fn declare(&mut self, l: LocalId) -> Home {
        let local = &self.shader.locals[l.0 as usize];
        match (local.kind, local.len) {
            (LocalKind::Input(input), Some(len)) => self.declare_inputs(input, local.ty, len),
            (LocalKind::Input(input), None) => Home::Fixed(self.input(input, local.ty)),
            (_, Some(len)) => self.declare_array(l, local.ty, len),
            (LocalKind::Global(g), None) => {
                let name = g.name();
                let function =
                    self.bridge.function(&mut self.module, name, Ret::Value(local.ty), &[Param::Globals], |_| {
                        format!("sg->{name}")
                    });
                let value = self.call(function, local.ty, &[self.globals]);
                if self.local_use(l).writes == 0 { Home::Fixed(value) } else { self.variable(local.ty, Some(value)) }
            }
            _ if self.local_use(l).writes == 0 => Home::Fixed(self.zero(local.ty)),
            _ if self.local_use(l).home.is_some() => self.variable(local.ty, None),
            _ => {
                let zero = self.zero_constant(local.ty);
                self.variable(local.ty, Some(zero))
            }
        }
    }

    fn variable(&mut self, ty: Ty, initial: Option<Word>) -> Home {
        let memory = self.memory_ty(ty);
        let id = self.module.variable(memory);
        if let Some(value) = initial {
            self.module.effect(Op::Store, &[id, value]);
        }
        Home::Variable(id)
    }

    /// The value of a single input.
    fn input(&mut self, input: u32, ty: Ty) -> Word {
        let (pointer, space) = slots::pointer(self.shader, &self.inputs, input);
        let (text, helper) = slots::read(&pointer, space, ty);
        self.bridge.includes.extend(helper.map(crate::backend::headers::of_op));
        let name = format!("input{input}");
        let function =
            self.bridge.function(&mut self.module, &name, Ret::Value(ty), &[Param::Globals], |_| text.clone());
        self.call(function, ty, &[self.globals])
    }

    /// An array of inputs, filled.
    fn declare_inputs(&mut self, input: u32, ty: Ty, len: u32) -> Home {
        let (pointer, space) = slots::pointer(self.shader, &self.inputs, input);
        let (text, helper) = slots::read(&format!("{pointer} + {} * i", slots_of(ty)), space, ty);
        self.bridge.includes.extend(helper.map(crate::backend::headers::of_op));
        let params = [Param::Globals, Param::Place(ty)];
        let body = |args: &[String]| format!("    for (int i = 0; i < {len}; i++) ({})[i] = {text};\n", args[1]);
        let name = format!("inputs{input}");
        let function = self.bridge.function(&mut self.module, &name, Ret::Nothing, &params, body);
        let memory = self.memory_ty(ty);
        let array = self.module.array(memory, len);
        let id = self.module.variable(array);
        let pointer = self.first(id, ty);
        self.call_nothing(function, &[self.globals, pointer]);
        Home::Variable(id)
    }

    /// A pointer to the first element of an array's variable, as the bridge takes it.
    fn first(&mut self, variable: Word, ty: Ty) -> Word {
        let zero = self.module.int(0);
        let pointer = self.module.ty(Param::Place(ty).ty());
        let indices: &[Word] = if ty == Ty::Matrix { &[variable, zero, zero] } else { &[variable, zero] };
        self.module.inst(Op::InBoundsAccessChain, pointer, indices)
    }

    /// Whether an array is read from constant memory only.
    fn is_table(&self, l: LocalId, len: u32) -> bool {
        let u = self.local_use(l);
        len > MAX_PRIVATE_TABLE && !u.changes && !u.passed && !u.initial.is_empty()
    }

    fn declare_array(&mut self, l: LocalId, ty: Ty, len: u32) -> Home {
        let mut initial = self.local_use(l).initial.clone();
        if self.is_table(l, len) {
            initial.resize(len as usize, None);
            return self.declare_table(ty, &initial);
        }
        let memory = self.memory_ty(ty);
        let array = self.module.array(memory, len);
        let id = self.module.variable(array);
        if !initial.is_empty() && len > MAX_INITIAL {
            let message = format!("an array of {len} elements is longer than a constant of SPIR-V can be");
            self.errors.push(Diagnostic::global("E4302", message).help("at most 60000 where elements change"));
            return Home::Variable(id);
        }
        let value = if initial.is_empty() {
            self.module.null(array)
        } else {
            initial.resize(len as usize, None);
            let zero = self.zero_constant(ty);
            let parts = initial.iter().map(|c| c.as_ref().map_or(zero, |c| self.constant(c))).collect();
            self.module.composite(array, parts)
        };
        if len <= MAX_PRIVATE_TABLE {
            self.module.effect(Op::Store, &[id, value]);
        } else {
            // A store of a whole array would become one instruction per element.
            let table = self.module.table(array, value);
            let bytes = self.module.size(type_of(ty)) * u64::from(len);
            self.module.copy(id, table, true, bytes);
        }
        Home::Variable(id)
    }

    /// A table lies flat: 3 reals per triple, 16 per matrix.
    fn declare_table(&mut self, ty: Ty, initial: &[Option<Const>]) -> Home {
        let (number, zero) = match ty {
            Ty::Int | Ty::Str => (self.module.ty(Type::Int), self.module.int(0)),
            _ => (self.module.ty(Type::Real), self.module.real(0.0)),
        };
        let mut parts = Vec::with_capacity(initial.len() * slots_of(ty) as usize);
        for c in initial {
            match c {
                Some(Const::Triple(t)) => parts.extend(t.map(|x| self.module.real(x))),
                Some(Const::Matrix(m)) => parts.extend(m.map(|x| self.module.real(x))),
                Some(c) => parts.push(self.constant(c)),
                None => parts.extend(std::iter::repeat_n(zero, slots_of(ty) as usize)),
            }
        }
        let chunked = parts.len() > CHUNK;
        if !chunked {
            let array = self.module.array(number, parts.len() as u32);
            let value = self.module.composite(array, parts);
            return Home::Table { id: self.module.table(array, value), chunked };
        }
        let chunk = self.module.array(number, CHUNK as u32);
        let mut chunks = Vec::new();
        for part in parts.chunks(CHUNK) {
            let mut part = part.to_vec();
            part.resize(CHUNK, zero);
            chunks.push(self.module.composite(chunk, part));
        }
        let array = self.module.array(chunk, chunks.len() as u32);
        let value = self.module.composite(array, chunks);
        Home::Table { id: self.module.table(array, value), chunked }
    }

    /// Number `index` of a table.
    fn number_of_table(&mut self, (id, chunked): (Word, bool), ty: Type, index: Word) -> Word {
        let number = self.module.ty(ty);
        let pointer = if chunked {
            let int = self.module.ty(Type::Int);
            let (bits, mask) = (self.module.int(CHUNK.trailing_zeros() as i32), self.module.int(CHUNK as i32 - 1));
            let high = self.module.inst(Op::ShiftRightLogical, int, &[index, bits]);
            let low = self.module.inst(Op::BitwiseAnd, int, &[index, mask]);
            self.module.table_element(number, id, &[high, low])
        } else {
            self.module.table_element(number, id, &[index])
        };
        self.module.inst(Op::Load, number, &[pointer])
    }

    /// An int times a constant plus a constant.
    pub(super) fn scaled(&mut self, index: Word, by: i32, plus: i32) -> Word {
        let int = self.module.ty(Type::Int);
        let (by, plus) = (self.module.int(by), self.module.int(plus));
        let product = self.module.inst(Op::IMul, int, &[index, by]);
        self.module.inst(Op::IAdd, int, &[product, plus])
    }

    /// The value of a single local, now; of a matrix a copy.
    pub(super) fn load(&mut self, l: LocalId) -> Word {
        let ty = self.shader.locals[l.0 as usize].ty;
        match self.homes[l.0 as usize] {
            Home::Fixed(id) => id,
            Home::Variable(variable) if ty == Ty::Matrix => {
                let place = self.matrix_place();
                self.copy_matrix(place, variable);
                place
            }
            Home::Variable(variable) => {
                let id = self.memory_ty(ty);
                self.module.inst(Op::Load, id, &[variable])
            }
            Home::Nowhere | Home::Table { .. } => self.zero(ty),
        }
    }

    /// Sets a single local.
    pub(super) fn store(&mut self, l: LocalId, value: Word) {
        if let Home::Variable(variable) = self.homes[l.0 as usize] {
            self.store_at(variable, self.shader.locals[l.0 as usize].ty, value);
        }
    }

    /// Sets what a pointer leads to.
    fn store_at(&mut self, pointer: Word, ty: Ty, value: Word) {
        if ty == Ty::Matrix {
            self.copy_matrix(pointer, value);
        } else {
            self.module.effect(Op::Store, &[pointer, value]);
        }
    }

    /// The pointer by which the bridge writes a single local or takes an array.
    pub(super) fn place(&mut self, l: LocalId) -> Word {
        let local = &self.shader.locals[l.0 as usize];
        let variable = match self.homes[l.0 as usize] {
            Home::Variable(id) => id,
            // What is handed to a function is a variable.
            _ => {
                let memory = self.memory_ty(local.ty);
                self.module.variable(memory)
            }
        };
        match (local.len, local.ty) {
            (Some(_), ty) => self.first(variable, ty),
            (None, Ty::Matrix) => self.matrix_pointer(variable),
            (None, _) => variable,
        }
    }

    /// The element of an array; the index is in range.
    pub(super) fn element(&mut self, l: LocalId, index: Word) -> Word {
        let ty = self.shader.locals[l.0 as usize].ty;
        match self.homes[l.0 as usize] {
            Home::Variable(variable) => {
                let pointer = self.element_pointer(variable, ty, index);
                if ty == Ty::Matrix {
                    let place = self.matrix_place();
                    self.copy_matrix(place, pointer);
                    return place;
                }
                let id = self.memory_ty(ty);
                self.module.inst(Op::Load, id, &[pointer])
            }
            Home::Table { id, chunked } => self.element_of_table((id, chunked), ty, index),
            Home::Fixed(_) | Home::Nowhere => self.zero(ty),
        }
    }

    fn element_of_table(&mut self, table: (Word, bool), ty: Ty, index: Word) -> Word {
        match ty {
            Ty::Triple => {
                let parts = [0, 1, 2].map(|k| {
                    let at = self.scaled(index, 3, k);
                    self.number_of_table(table, Type::Real, at)
                });
                self.module.three(Type::Triple, parts)
            }
            Ty::Matrix => {
                let place = self.matrix_place();
                for k in 0..16 {
                    let at = self.scaled(index, 16, k);
                    let value = self.number_of_table(table, Type::Real, at);
                    let k = self.module.int(k);
                    let to = self.matrix_element(place, k);
                    self.module.effect(Op::Store, &[to, value]);
                }
                place
            }
            ty => self.number_of_table(table, type_of(ty), index),
        }
    }

    fn element_pointer(&mut self, variable: Word, ty: Ty, index: Word) -> Word {
        let memory = self.memory_ty(ty);
        let pointer = self.module.pointer_private(memory);
        self.module.inst(Op::InBoundsAccessChain, pointer, &[variable, index])
    }

    /// Sets an element of an array; the index is in range.
    pub(super) fn store_element(&mut self, l: LocalId, index: Word, value: Word) {
        let ty = self.shader.locals[l.0 as usize].ty;
        if let Home::Variable(variable) = self.homes[l.0 as usize] {
            let pointer = self.element_pointer(variable, ty, index);
            self.store_at(pointer, ty, value);
        }
    }
}

/// The module's type of a value in memory.
pub(super) fn type_of(ty: Ty) -> Type {
    match ty {
        Ty::Float => Type::Real,
        Ty::Triple => Type::Triple,
        Ty::Matrix => Type::Matrix,
        Ty::Int | Ty::Str | Ty::Closure => Type::Int,
    }
}
