//! Typed tree to IR.
//!
//! In: [`crate::check::Checked`]. Out: [`ir::Shader`]. Functions are inlined at each call with arguments by reference;
//! structs become one local per field, arrays of structs one array per field; `return` and `exit` become structured control
//! flow; built-ins that are not one call are rewritten (`special`). It must not know any target.
//!
//! Codes: `E3001` built-in not supported yet, `E3003` a name that must be known,
//! `E3004` the shader grows too large, `E3005` other constructs not supported yet; `E2015` a function
//! without body, `E2011` more knots than the array has.

mod assigned;
mod call;
mod color_system;
mod exit;
mod expr;
mod finite;
mod host;
mod noise;
mod place;
mod points;
mod range;
mod spaces;
mod special;
mod stmt;
mod texture;

use crate::check::Checked;
use crate::check::typed::{self, FunctionId, VarId, VarKind};
use crate::diag::Diagnostic;
use crate::ir::{self, Block, Const, Global, Inst, Local, LocalId, LocalKind, Stmt, Ty, ValueId};
use crate::source::Span;
use crate::types::{Base, Extent, Type};
pub use color_system::ColorSystem;
use place::{Place, Storage};
use std::collections::HashMap;

/// Most values of a shader: inlining multiplies code, and this bounds it.
const MAX_VALUES: usize = 2_000_000;

/// What a renderer settles before shaders are lowered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// The names of the spaces that it knows beyond those of every renderer, in the order of `other_spaces` from its fourth
    /// on (kernels/globals.h).
    pub spaces: Vec<String>,
    /// What linear RGB is.
    pub color_system: ColorSystem,
    /// Unknown kinds of noise are reported when the shader runs, as by the reference implementation; otherwise they are errors.
    pub unknown_noise_runs: bool,
    /// Indices out of range are reported when the shader runs. It costs time at each index that is no constant.
    pub range_checks: bool,
    /// Variables that get a number that is not finite are reported when the shader runs. It costs time at each assignment.
    pub finite_checks: bool,
    /// Variables that are read before they are assigned are reported when the shader runs. It costs time at each access of those
    /// that are declared without a value.
    pub unassigned_checks: bool,
}

/// Lowers a checked shader for a renderer with default settings.
pub fn lower(checked: &Checked) -> Result<ir::Shader, Vec<Diagnostic>> {
    lower_for(checked, &Settings::default())
}

/// Lowers a checked shader.
pub fn lower_for(checked: &Checked, settings: &Settings) -> Result<ir::Shader, Vec<Diagnostic>> {
    let shader = &checked.shader;
    let mut lower = Lower {
        settings,
        tree: shader,
        out: ir::Shader {
            name: shader.name.clone(),
            kind: shader.kind.clone(),
            params: Vec::new(),
            locals: Vec::new(),
            values: Vec::new(),
            body: Block::default(),
            slots: Vec::new(),
            inputs: Vec::new(),
            derivative_uses: Vec::new(),
        },
        env: HashMap::new(),
        blocks: Vec::new(),
        frames: Vec::new(),
        errors: Vec::new(),
        too_large: false,
        exiting: exit::exiting(shader),
        exited: None,
        guards: 0,
        left_branch: false,
        defaults_exit: None,
        unassigned: Vec::new(),
    };
    for param in &shader.params {
        lower.param(param);
    }
    lower.frames.push(Frame { result: None, flag: None, loops: 0, function: None });
    lower.out.body = lower.in_block(|l| l.body(&shader.body));
    let Lower { mut out, errors, unassigned, .. } = lower;
    assigned::check(&mut out, unassigned);
    if errors.is_empty() { Ok(out) } else { Err(errors) }
}

/// A body being inlined.
struct Frame {
    /// Where `return value` puts it.
    result: Option<Storage>,
    /// Set to 1 by a `return` that is not the last thing done; made on first use.
    flag: Option<LocalId>,
    /// Loops of this body around the present statement.
    loops: u32,
    /// `None`: the shader itself.
    function: Option<FunctionId>,
}

/// Carries the state of a run.
pub(crate) struct Lower<'a> {
    settings: &'a Settings,
    tree: &'a typed::Shader,
    out: ir::Shader,
    env: HashMap<VarId, Storage>,
    blocks: Vec<Block>,
    frames: Vec<Frame>,
    errors: Vec<Diagnostic>,
    too_large: bool,
    /// For each function whether it may end the shader; `None` when only statements of the shader's body do.
    exiting: Option<Vec<bool>>,
    /// Set to 1 by `exit()` in a function; made on first use.
    exited: Option<LocalId>,
    /// Blocks that the present statement opened behind calls of `exit()`.
    guards: u32,
    /// A branch that was just lowered may have ended the shader.
    left_branch: bool,
    /// The last default of a parameter that may have ended the shader.
    defaults_exit: Option<Span>,
    /// Variables that were declared without a value, if that is watched.
    unassigned: Vec<assigned::Unassigned>,
}

/// The IR's type of an OSL base type that is no struct.
fn ir_type(base: Base) -> Ty {
    match base {
        Base::Int | Base::Void | Base::Struct(_) => Ty::Int,
        Base::Float => Ty::Float,
        Base::Color | Base::Point | Base::Vector | Base::Normal => Ty::Triple,
        Base::Matrix => Ty::Matrix,
        Base::String => Ty::Str,
        Base::Closure => Ty::Closure,
    }
}

impl<'a> Lower<'a> {
    fn error(&mut self, d: Diagnostic) {
        if self.errors.len() < 100 && !self.errors.contains(&d) {
            self.errors.push(d);
        }
    }

    /// Runs `f` with a fresh block and returns what it filled.
    fn in_block(&mut self, f: impl FnOnce(&mut Self)) -> Block {
        self.blocks.push(Block::default());
        f(self);
        self.blocks.pop().unwrap_or_default()
    }

    fn push(&mut self, stmt: Stmt) {
        if let Some(block) = self.blocks.last_mut() {
            block.stmts.push(stmt);
        }
    }

    /// Computes a value here.
    fn value(&mut self, inst: Inst, ty: Ty, span: Span) -> ValueId {
        if self.out.values.len() >= MAX_VALUES && !self.too_large {
            self.too_large = true;
            let message = format!("the shader grows beyond {MAX_VALUES} operations once its functions are inlined");
            self.error(Diagnostic::error("E3004", span, message).help("call large functions in fewer places"));
        }
        let id = ValueId(self.out.values.len() as u32);
        self.out.values.push(ir::Value { inst, ty, span });
        self.push(Stmt::Let(id));
        id
    }

    fn constant(&mut self, c: Const, span: Span) -> ValueId {
        let ty = c.ty().unwrap_or(Ty::Int);
        self.value(Inst::Const(c), ty, span)
    }

    fn int(&mut self, v: i32, span: Span) -> ValueId {
        self.constant(Const::Int(v), span)
    }

    fn ty_of(&self, id: ValueId) -> Ty {
        self.out.values[id.0 as usize].ty
    }

    fn local(&mut self, name: impl Into<String>, ty: Ty, len: Option<u32>, kind: LocalKind) -> LocalId {
        self.out.locals.push(Local { name: name.into(), ty, len, kind });
        LocalId(self.out.locals.len() as u32 - 1)
    }

    /// A local of the compiler's own.
    fn temp(&mut self, ty: Ty) -> LocalId {
        self.local("t", ty, None, LocalKind::Variable)
    }

    /// Storage for a variable of an OSL type.
    fn storage(&mut self, name: &str, ty: Type, kind: LocalKind) -> Storage {
        let len = match ty.extent {
            Extent::Scalar => None,
            Extent::Fixed(n) => Some(n),
            // Unsized parameters of functions are bound to their argument's storage, never made anew.
            Extent::Unsized => Some(1),
        };
        self.storage_of(name, ty.base, len, kind)
    }

    fn storage_of(&mut self, name: &str, base: Base, len: Option<u32>, kind: LocalKind) -> Storage {
        let Base::Struct(id) = base else {
            return Storage::Local(self.local(name, ir_type(base), len, kind));
        };
        let fields = self.tree.structure(id).fields.clone();
        let mut out = Vec::new();
        for (field, ty) in fields {
            // An array of structs has no arrays inside (checked), so one length is enough.
            let inner = match ty.extent {
                Extent::Fixed(n) => Some(n),
                _ => len,
            };
            out.push(self.storage_of(&format!("{name}.{field}"), ty.base, inner, kind));
        }
        Storage::Struct(out)
    }

    /// The storage of a variable; globals come to life when first used.
    fn variable(&mut self, id: VarId) -> Storage {
        if let Some(storage) = self.env.get(&id) {
            return storage.clone();
        }
        let var = self.tree.var(id).clone();
        let kind = match var.kind {
            VarKind::Global => Global::ALL.into_iter().find(|g| g.name() == var.name).map(LocalKind::Global),
            _ => None,
        };
        let storage = self.storage(&var.name, var.ty, kind.unwrap_or(LocalKind::Variable));
        if kind.is_none() {
            // Compiled shaders do not say where variables are declared.
            self.declared_without_value(&var.name, var.ty, &storage);
        }
        self.env.insert(id, storage.clone());
        storage
    }

    /// One IR parameter per leaf of a shader parameter, with its default.
    fn param(&mut self, param: &typed::Param) {
        let var = self.tree.var(param.var).clone();
        let storage = self.storage(&var.name, var.ty, LocalKind::Variable);
        self.env.insert(param.var, storage.clone());
        self.param_leaves(&var, param, var.ty, &storage, param.init.as_ref());
    }

    fn param_leaves(
        &mut self,
        var: &typed::Var,
        param: &typed::Param,
        ty: Type,
        storage: &Storage,
        init: Option<&typed::Expr>,
    ) {
        match storage {
            Storage::Local(local) => {
                let index = self.out.params.len() as u32;
                self.out.locals[local.0 as usize].kind = LocalKind::Param(index);
                let name = self.out.locals[local.0 as usize].name.clone();
                let target = Place::whole(storage.clone());
                let init = self.in_block(|l| {
                    if let Some(e) = init {
                        l.default_of(&target, e);
                    }
                });
                self.out.params.push(ir::Param {
                    name,
                    declared: ty,
                    output: param.output,
                    local: *local,
                    varying: param.varying,
                    init,
                    span: var.span,
                    traits: param.traits,
                });
            }
            Storage::Struct(fields) => {
                let Base::Struct(id) = ty.base else { return };
                let types = self.tree.structure(id).fields.clone();
                // A list gives each field its own init; any other value is computed once, by the first leaf.
                let first = self.out.params.len();
                let per_field = match init.map(|e| &e.kind) {
                    Some(typed::ExprKind::List(items)) if !ty.is_array() => Some(items),
                    _ => None,
                };
                for (i, (field, (_, field_ty))) in fields.iter().zip(&types).enumerate() {
                    let extent = if field_ty.is_array() { field_ty.extent } else { ty.extent };
                    let leaf = Type { base: field_ty.base, extent };
                    self.param_leaves(var, param, leaf, field, per_field.and_then(|items| items.get(i)));
                }
                if let (None, Some(e)) = (per_field, init) {
                    let target = Place::whole(storage.clone());
                    let block = self.in_block(|l| l.default_of(&target, e));
                    if let Some(p) = self.out.params.get_mut(first) {
                        p.init = block;
                    }
                }
            }
        }
    }
}
