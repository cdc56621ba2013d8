//! A SPIR-V module under construction: types and constants once each, imported functions, one function with its blocks.
//!
//! In: requests for types, constants and instructions. Out: ids; at the end the module's words. It must not know the IR.

use super::Width;
use rspirv::binary::Assemble;
use rspirv::dr::{Block, Function, Instruction, Module as Parts, ModuleHeader, Operand};
use rspirv::spirv::{
    AddressingModel, Capability, Decoration, FunctionControl, LinkageType, MemoryModel, OpenclStd100Op, StorageClass,
};
use std::collections::HashMap;

pub(super) use rspirv::spirv::{LoopControl, Op, SelectionControl, Word};

/// A type of the module. Pointers lead to private memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Type {
    Void,
    Bool,
    /// Three of them.
    Bool3,
    Byte,
    Int,
    Real,
    /// Three reals, aligned as four.
    Triple,
    /// 16 reals.
    Matrix,
    BytePointer,
    IntPointer,
    RealPointer,
    TriplePointer,
}

/// The module.
pub(super) struct Module {
    parts: Parts,
    width: Width,
    next: Word,
    known: HashMap<(Op, Option<Word>, Vec<Operand>), Word>,
    opencl: Word,
    imports: Vec<Function>,
    parameters: Vec<Instruction>,
    variables: Vec<Instruction>,
    blocks: Vec<Block>,
    block: Option<Block>,
}

impl Module {
    pub(super) fn new(width: Width) -> Module {
        let mut module = Module {
            parts: Parts::default(),
            width,
            next: 1,
            known: HashMap::new(),
            opencl: 0,
            imports: Vec::new(),
            parameters: Vec::new(),
            variables: Vec::new(),
            blocks: Vec::new(),
            block: None,
        };
        let mut capabilities =
            vec![Capability::Addresses, Capability::Linkage, Capability::Kernel, Capability::Int8, Capability::Int64];
        if width == Width::Double {
            capabilities.push(Capability::Float64);
        }
        for capability in capabilities {
            let operands = vec![Operand::Capability(capability)];
            module.parts.capabilities.push(Instruction::new(Op::Capability, None, None, operands));
        }
        module.opencl = module.id();
        let set = Operand::LiteralString("OpenCL.std".to_owned());
        let import = Instruction::new(Op::ExtInstImport, None, Some(module.opencl), vec![set]);
        module.parts.ext_inst_imports.push(import);
        let model =
            vec![Operand::AddressingModel(AddressingModel::Physical64), Operand::MemoryModel(MemoryModel::OpenCL)];
        module.parts.memory_model = Some(Instruction::new(Op::MemoryModel, None, None, model));
        module
    }

    /// A new id.
    pub(super) fn id(&mut self) -> Word {
        self.next += 1;
        self.next - 1
    }

    /// Names what an id stands for, for people who read the module.
    pub(super) fn name(&mut self, id: Word, name: &str) {
        let operands = vec![Operand::IdRef(id), Operand::LiteralString(name.to_owned())];
        self.parts.debug_names.push(Instruction::new(Op::Name, None, None, operands));
    }

    // ---- Types and constants ----------------------------------------------------------------------------------------

    /// A type or constant, once.
    fn global(&mut self, op: Op, ty: Option<Word>, operands: Vec<Operand>) -> Word {
        let key = (op, ty, operands);
        if let Some(id) = self.known.get(&key) {
            return *id;
        }
        let id = self.id();
        self.parts.types_global_values.push(Instruction::new(op, ty, Some(id), key.2.clone()));
        self.known.insert(key, id);
        id
    }

    pub(super) fn ty(&mut self, ty: Type) -> Word {
        let bits = |n| vec![Operand::LiteralBit32(n)];
        match ty {
            Type::Void => self.global(Op::TypeVoid, None, Vec::new()),
            Type::Bool => self.global(Op::TypeBool, None, Vec::new()),
            Type::Bool3 => self.vector(Type::Bool),
            Type::Byte => self.global(Op::TypeInt, None, [bits(8), bits(0)].concat()),
            Type::Int => self.global(Op::TypeInt, None, [bits(32), bits(0)].concat()),
            Type::Real => self.global(Op::TypeFloat, None, bits(self.width.bits())),
            Type::Triple => self.vector(Type::Real),
            Type::Matrix => {
                let real = self.ty(Type::Real);
                self.array(real, 16)
            }
            Type::BytePointer => self.pointer_to(Type::Byte),
            Type::IntPointer => self.pointer_to(Type::Int),
            Type::RealPointer => self.pointer_to(Type::Real),
            Type::TriplePointer => self.pointer_to(Type::Triple),
        }
    }

    fn vector(&mut self, of: Type) -> Word {
        let of = self.ty(of);
        self.global(Op::TypeVector, None, vec![Operand::IdRef(of), Operand::LiteralBit32(3)])
    }

    fn pointer_to(&mut self, to: Type) -> Word {
        let to = self.ty(to);
        self.pointer(to, StorageClass::Function)
    }

    fn pointer(&mut self, to: Word, class: StorageClass) -> Word {
        self.global(Op::TypePointer, None, vec![Operand::StorageClass(class), Operand::IdRef(to)])
    }

    /// A pointer to private memory of this type.
    pub(super) fn pointer_private(&mut self, to: Word) -> Word {
        self.pointer(to, StorageClass::Function)
    }

    /// An array type.
    pub(super) fn array(&mut self, of: Word, len: u32) -> Word {
        let len = self.int(len as i32);
        self.global(Op::TypeArray, None, vec![Operand::IdRef(of), Operand::IdRef(len)])
    }

    pub(super) fn int(&mut self, v: i32) -> Word {
        let ty = self.ty(Type::Int);
        self.global(Op::Constant, Some(ty), vec![Operand::LiteralBit32(v as u32)])
    }

    /// A constant, rounded to the module's reals.
    pub(super) fn real(&mut self, v: f64) -> Word {
        let ty = self.ty(Type::Real);
        let bits = match self.width {
            Width::Single => Operand::LiteralBit32((v as f32).to_bits()),
            Width::Double => Operand::LiteralBit64(v.to_bits()),
        };
        self.global(Op::Constant, Some(ty), vec![bits])
    }

    /// A constant made of others.
    pub(super) fn composite(&mut self, ty: Word, parts: Vec<Word>) -> Word {
        self.global(Op::ConstantComposite, Some(ty), parts.into_iter().map(Operand::IdRef).collect())
    }

    /// Zero of any type.
    pub(super) fn null(&mut self, ty: Word) -> Word {
        self.global(Op::ConstantNull, Some(ty), Vec::new())
    }

    /// A constant in constant memory; the same again for the same constant.
    pub(super) fn table(&mut self, ty: Word, value: Word) -> Word {
        let pointer = self.pointer(ty, StorageClass::UniformConstant);
        let operands = vec![Operand::StorageClass(StorageClass::UniformConstant), Operand::IdRef(value)];
        self.global(Op::Variable, Some(pointer), operands)
    }

    /// A pointer to an element of a table; `to` is the element's type.
    pub(super) fn table_element(&mut self, to: Word, table: Word, indices: &[Word]) -> Word {
        let ty = self.pointer(to, StorageClass::UniformConstant);
        let operands = [&[table][..], indices].concat();
        self.inst(Op::InBoundsAccessChain, ty, &operands)
    }

    // ---- Functions --------------------------------------------------------------------------------------------------

    fn function_type(&mut self, ret: Type, params: &[Type]) -> Word {
        let ids: Vec<Operand> = [&[ret][..], params].concat().into_iter().map(|t| Operand::IdRef(self.ty(t))).collect();
        self.global(Op::TypeFunction, None, ids)
    }

    fn linkage(&mut self, function: Word, name: &str, linkage: LinkageType) {
        let operands = vec![
            Operand::IdRef(function),
            Operand::Decoration(Decoration::LinkageAttributes),
            Operand::LiteralString(name.to_owned()),
            Operand::LinkageType(linkage),
        ];
        self.parts.annotations.push(Instruction::new(Op::Decorate, None, None, operands));
    }

    fn head(&mut self, ret: Type, params: &[Type], id: Word, control: FunctionControl) -> Instruction {
        let ty = self.function_type(ret, params);
        let operands = vec![Operand::FunctionControl(control), Operand::IdRef(ty)];
        let ret = self.ty(ret);
        Instruction::new(Op::Function, Some(ret), Some(id), operands)
    }

    fn parameter(&mut self, ty: Type) -> Instruction {
        let ty = self.ty(ty);
        let id = self.id();
        Instruction::new(Op::FunctionParameter, Some(ty), Some(id), Vec::new())
    }

    /// Declares a function of another module.
    pub(super) fn import(&mut self, name: &str, ret: Type, params: &[Type]) -> Word {
        let id = self.id();
        let def = Some(self.head(ret, params, id, FunctionControl::NONE));
        let parameters = params.iter().map(|t| self.parameter(*t)).collect();
        let end = Some(Instruction::new(Op::FunctionEnd, None, None, Vec::new()));
        self.imports.push(Function { def, end, parameters, blocks: Vec::new() });
        self.linkage(id, name, LinkageType::Import);
        self.name(id, name);
        id
    }

    /// Begins the function; its parameters' ids.
    pub(super) fn begin(&mut self, params: &[(&str, Type)]) -> Vec<Word> {
        let mut ids = Vec::with_capacity(params.len());
        for (name, ty) in params {
            let parameter = self.parameter(*ty);
            // A parameter always has an id.
            let id = parameter.result_id.unwrap_or(0);
            self.parameters.push(parameter);
            self.name(id, name);
            ids.push(id);
        }
        let first = self.id();
        self.label(first);
        ids
    }

    /// A variable in private memory; its pointer.
    pub(super) fn variable(&mut self, ty: Word) -> Word {
        let pointer = self.pointer(ty, StorageClass::Function);
        let id = self.id();
        let operands = vec![Operand::StorageClass(StorageClass::Function)];
        self.variables.push(Instruction::new(Op::Variable, Some(pointer), Some(id), operands));
        id
    }

    /// Begins a block.
    pub(super) fn label(&mut self, id: Word) {
        let label = Some(Instruction::new(Op::Label, None, Some(id), Vec::new()));
        self.block = Some(Block { label, instructions: Vec::new() });
    }

    /// Whether a block is open: what is written now can be reached.
    pub(super) fn is_open(&self) -> bool {
        self.block.is_some()
    }

    fn push(&mut self, instruction: Instruction) {
        if let Some(block) = &mut self.block {
            block.instructions.push(instruction);
        }
    }

    /// An instruction with a result.
    pub(super) fn inst(&mut self, op: Op, ty: Word, operands: &[Word]) -> Word {
        let id = self.id();
        let operands = operands.iter().map(|o| Operand::IdRef(*o)).collect();
        self.push(Instruction::new(op, Some(ty), Some(id), operands));
        id
    }

    /// A part of a composite.
    pub(super) fn extract(&mut self, ty: Type, from: Word, index: u32) -> Word {
        let ty = self.ty(ty);
        let id = self.id();
        let operands = vec![Operand::IdRef(from), Operand::LiteralBit32(index)];
        self.push(Instruction::new(Op::CompositeExtract, Some(ty), Some(id), operands));
        id
    }

    /// A composite with one part replaced.
    pub(super) fn insert(&mut self, ty: Type, part: Word, into: Word, index: u32) -> Word {
        let ty = self.ty(ty);
        let id = self.id();
        let operands = vec![Operand::IdRef(part), Operand::IdRef(into), Operand::LiteralBit32(index)];
        self.push(Instruction::new(Op::CompositeInsert, Some(ty), Some(id), operands));
        id
    }

    /// A vector of three parts. Translators to LLVM take OpCompositeConstruct of constants only, so parts are put in one by one.
    pub(super) fn three(&mut self, ty: Type, parts: [Word; 3]) -> Word {
        let of = self.ty(ty);
        let mut whole = self.global(Op::Undef, Some(of), Vec::new());
        for (k, part) in parts.into_iter().enumerate() {
            whole = self.insert(ty, part, whole, k as u32);
        }
        whole
    }

    /// A call of a function of OpenCL C's library.
    pub(super) fn opencl(&mut self, function: OpenclStd100Op, ty: Type, args: &[Word]) -> Word {
        let ty = self.ty(ty);
        let id = self.id();
        let mut operands = vec![Operand::IdRef(self.opencl), Operand::LiteralExtInstInteger(function as u32)];
        operands.extend(args.iter().map(|a| Operand::IdRef(*a)));
        self.push(Instruction::new(Op::ExtInst, Some(ty), Some(id), operands));
        id
    }

    /// An instruction without a result.
    pub(super) fn effect(&mut self, op: Op, operands: &[Word]) {
        let operands = operands.iter().map(|o| Operand::IdRef(*o)).collect();
        self.push(Instruction::new(op, None, None, operands));
    }

    /// Copies bytes to private memory, from there or from constant memory. By size: translators to LLVM stumble over
    /// OpCopyMemory.
    pub(super) fn copy(&mut self, to: Word, from: Word, from_table: bool, bytes: u64) {
        let byte = self.ty(Type::Byte);
        let class = if from_table { StorageClass::UniformConstant } else { StorageClass::Function };
        let (target, source) = (self.pointer_private(byte), self.pointer(byte, class));
        let to = self.inst(Op::Bitcast, target, &[to]);
        let from = self.inst(Op::Bitcast, source, &[from]);
        let long = self.global(Op::TypeInt, None, vec![Operand::LiteralBit32(64), Operand::LiteralBit32(0)]);
        let size = self.global(Op::Constant, Some(long), vec![Operand::LiteralBit64(bytes)]);
        self.effect(Op::CopyMemorySized, &[to, from, size]);
    }

    /// Bytes of a value in memory.
    pub(super) fn size(&self, ty: Type) -> u64 {
        let real = u64::from(self.width.bits() / 8);
        match ty {
            Type::Real => real,
            Type::Triple => 4 * real,
            Type::Matrix => 16 * real,
            _ => 4,
        }
    }

    /// An instruction that ends the block.
    pub(super) fn end(&mut self, op: Op, operands: &[Word]) {
        self.effect(op, operands);
        self.blocks.extend(self.block.take());
    }

    pub(super) fn selection(&mut self, merge: Word) {
        let operands = vec![Operand::IdRef(merge), Operand::SelectionControl(SelectionControl::NONE)];
        self.push(Instruction::new(Op::SelectionMerge, None, None, operands));
    }

    pub(super) fn repetition(&mut self, merge: Word, next: Word) {
        let operands = vec![Operand::IdRef(merge), Operand::IdRef(next), Operand::LoopControl(LoopControl::NONE)];
        self.push(Instruction::new(Op::LoopMerge, None, None, operands));
    }

    /// Ends the function, which others see under this name; the module's words.
    pub(super) fn finish(mut self, name: &str, params: &[(&str, Type)]) -> Vec<u32> {
        if self.is_open() {
            self.end(Op::Return, &[]);
        }
        let id = self.id();
        let types: Vec<Type> = params.iter().map(|(_, t)| *t).collect();
        let def = Some(self.head(Type::Void, &types, id, FunctionControl::INLINE));
        self.linkage(id, name, LinkageType::Export);
        self.name(id, name);
        let end = Some(Instruction::new(Op::FunctionEnd, None, None, Vec::new()));
        if let Some(first) = self.blocks.first_mut() {
            first.instructions.splice(0..0, self.variables);
        }
        self.parts.functions = self.imports;
        self.parts.functions.push(Function { def, end, parameters: self.parameters, blocks: self.blocks });
        let mut header = ModuleHeader::new(self.next);
        header.set_version(1, 0);
        self.parts.header = Some(header);
        self.parts.assemble()
    }

    /// How many ids there are.
    pub(super) fn ids(&self) -> Word {
        self.next
    }
}
