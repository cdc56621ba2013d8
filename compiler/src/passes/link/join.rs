//! Puts the IR of several shaders into one: handles move, names get their layer in front, globals are shared.
//!
//! In: shaders. Out: one shader whose body is still empty, and the parts' blocks in its handles.

use crate::diag::Diagnostic;
use crate::ir::{Block, Global, Input, Local, LocalId, LocalKind, Shader, Source, Stmt, ValueId};
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
            derivative_uses: Vec::new(),
        };
        Joined { shader, globals: Vec::new(), first_param: Vec::new() }
    }

    /// The joined parameter that is parameter `param` of part `layer`.
    pub fn param(&self, layer: usize, param: usize) -> usize {
        self.first_param[layer] + param
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
            v.inst.rename(&local, &value);
            self.shader.values.push(v);
        }
        let mut inits = Vec::with_capacity(part.params.len());
        for (i, mut param) in part.params.into_iter().enumerate() {
            let mut init = std::mem::take(&mut param.init);
            init.rename(&local, &value);
            inits.push((i, init));
            local(&mut param.local);
            param.name = format!("{layer}.{}", param.name);
            self.shader.params.push(param);
        }
        let mut body = part.body;
        body.rename(&local, &value);
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
        if let Stmt::Call { span, .. } = stmt {
            shift(span);
        }
        stmt.blocks_mut(&mut |b| shift_block(b, shift));
    }
}

/// Moves the places of a finding to later files.
pub fn shift_diagnostic(d: &mut Diagnostic, by: u32) {
    d.labels.iter_mut().for_each(|l| l.span.file.0 += by);
}
