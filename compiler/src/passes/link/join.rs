//! Puts the IR of several shaders into one: handles move, names get their layer in front, globals are shared.
//!
//! In: shaders. Out: one shader whose body is still empty, and the parts' blocks in its handles.

use crate::diag::Diagnostic;
use crate::ir::{Arg, Block, Global, Input, Inst, Local, LocalId, LocalKind, Shader, Source, Stmt, Value, ValueId};
use crate::source::{FileId, Span};

/// The shader that parts are added to.
pub(super) struct Joined {
    pub shader: Shader,
    /// The local of each global that some part uses.
    globals: Vec<(Global, LocalId)>,
    /// For each part the index of its first parameter.
    pub first_param: Vec<usize>,
}

/// A part's blocks in the handles of the joined shader.
pub(super) struct Added {
    /// The init of each of its parameters, by its index in the part.
    pub inits: Vec<(usize, Block)>,
    /// The body.
    pub body: Block,
}

impl Joined {
    pub fn new(name: &str, kind: &str) -> Joined {
        let shader = Shader {
            name: name.to_owned(),
            kind: kind.to_owned(),
            params: Vec::new(),
            locals: Vec::new(),
            values: Vec::new(),
            body: Block::default(),
            slots: Vec::new(),
            inputs: Vec::new(),
        };
        Joined { shader, globals: Vec::new(), first_param: Vec::new() }
    }

    /// The joined parameter that is parameter `param` of part `layer`.
    pub fn param(&self, layer: usize, param: usize) -> usize {
        self.first_param[layer] + param
    }

    /// A value at the end of `block`.
    pub fn value(&mut self, block: &mut Block, inst: Inst, ty: crate::ir::Ty, span: Span) -> ValueId {
        let id = ValueId(self.shader.values.len() as u32);
        self.shader.values.push(Value { inst, ty, span });
        block.stmts.push(Stmt::Let(id));
        id
    }

    /// Moves a shader in.
    pub fn add(&mut self, layer: &str, part: Shader) -> Added {
        let first_param = self.shader.params.len();
        self.first_param.push(first_param);
        let inputs: Vec<u32> = part.inputs.into_iter().map(|i| self.input(layer, i)).collect();
        let mut locals = Vec::with_capacity(part.locals.len());
        for local in part.locals {
            locals.push(self.local(layer, local, first_param as u32, &inputs));
        }
        let first_value = self.shader.values.len() as u32;
        let local = |l: &mut LocalId| *l = locals[l.0 as usize];
        let value = |v: &mut ValueId| v.0 += first_value;
        for mut v in part.values {
            v.inst.operands_mut(&mut |v| value(v));
            match &mut v.inst {
                Inst::Load(l) | Inst::LoadElem(l, _) => local(l),
                Inst::Call(_, args) => array_args(args, &local),
                _ => {}
            }
            self.shader.values.push(v);
        }
        let mut inits = Vec::with_capacity(part.params.len());
        for (i, mut param) in part.params.into_iter().enumerate() {
            let mut init = std::mem::take(&mut param.init);
            move_block(&mut init, &local, &value);
            inits.push((i, init));
            local(&mut param.local);
            param.name = format!("{layer}.{}", param.name);
            self.shader.params.push(param);
        }
        let mut body = part.body;
        move_block(&mut body, &local, &value);
        Added { inits, body }
    }

    /// Userdata is the same for all layers; an interactive parameter is its layer's.
    fn input(&mut self, layer: &str, mut input: Input) -> u32 {
        if matches!(input.source, Source::Interactive | Source::HasInteractive) {
            input.name = format!("{layer}.{}", input.name);
        }
        let same = |i: &Input| (&i.name, i.source, i.ty, i.len) == (&input.name, input.source, input.ty, input.len);
        if let Some(index) = self.shader.inputs.iter().position(same) {
            return index as u32;
        }
        self.shader.inputs.push(input);
        self.shader.inputs.len() as u32 - 1
    }

    fn local(&mut self, layer: &str, mut local: Local, first_param: u32, inputs: &[u32]) -> LocalId {
        match &mut local.kind {
            LocalKind::Global(global) => {
                if let Some((_, id)) = self.globals.iter().find(|(g, _)| g == global) {
                    return *id;
                }
                self.globals.push((*global, LocalId(self.shader.locals.len() as u32)));
            }
            LocalKind::Param(index) => {
                *index += first_param;
                local.name = format!("{layer}.{}", local.name);
            }
            LocalKind::Input(index) => *index = inputs[*index as usize],
            LocalKind::Variable => local.name = format!("{layer}.{}", local.name),
        }
        self.shader.locals.push(local);
        LocalId(self.shader.locals.len() as u32 - 1)
    }
}

fn array_args(args: &mut [Arg], local: &dyn Fn(&mut LocalId)) {
    for arg in args {
        if let Arg::Array(l) = arg {
            local(l);
        }
    }
}

/// Rewrites the handles of a block and those inside it.
pub(super) fn move_block(block: &mut Block, local: &dyn Fn(&mut LocalId), value: &dyn Fn(&mut ValueId)) {
    for stmt in &mut block.stmts {
        match stmt {
            Stmt::Let(v) => value(v),
            Stmt::Store(l, v) => {
                local(l);
                value(v);
            }
            Stmt::StoreElem(l, i, v) => {
                local(l);
                value(i);
                value(v);
            }
            Stmt::CopyArray(a, b) => {
                local(a);
                local(b);
            }
            Stmt::Call { args, outputs, result, .. } => {
                array_args(args, local);
                for arg in args {
                    if let Arg::Value(v) = arg {
                        value(v);
                    }
                }
                outputs.iter_mut().chain(result).for_each(local);
            }
            Stmt::If(c, a, b) => {
                value(c);
                move_block(a, local, value);
                move_block(b, local, value);
            }
            Stmt::Loop(l) => {
                value(&mut l.cond);
                move_block(&mut l.head, local, value);
                move_block(&mut l.body, local, value);
                move_block(&mut l.step, local, value);
            }
            Stmt::Break | Stmt::Continue => {}
        }
    }
}

/// Moves every span of a shader to a later file.
pub(super) fn shift_files(shader: &mut Shader, by: u32) {
    if by == 0 {
        return;
    }
    let shift = |span: &mut Span| span.file = FileId(span.file.0 + by);
    shader.values.iter_mut().for_each(|v| shift(&mut v.span));
    for param in &mut shader.params {
        shift(&mut param.span);
        shift_block(&mut param.init, &shift);
    }
    shift_block(&mut shader.body, &shift);
}

fn shift_block(block: &mut Block, shift: &dyn Fn(&mut Span)) {
    for stmt in &mut block.stmts {
        match stmt {
            Stmt::Call { span, .. } => shift(span),
            Stmt::If(_, a, b) => {
                shift_block(a, shift);
                shift_block(b, shift);
            }
            Stmt::Loop(l) => {
                shift_block(&mut l.head, shift);
                shift_block(&mut l.body, shift);
                shift_block(&mut l.step, shift);
            }
            _ => {}
        }
    }
}

/// Moves the places of a finding to later files.
pub fn shift_diagnostic(d: &mut Diagnostic, by: u32) {
    d.labels.iter_mut().for_each(|l| l.span.file.0 += by);
}
