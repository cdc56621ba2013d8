//! Typed tree to [`Module`]: statements and functions.
//!
//! In: [`Checked`] and the sources that its spans point into. Out: a module, or what the format cannot say. Functions are
//! inlined at each call inside a `functioncall` operation; structs become a symbol per field; every expression becomes
//! operations on symbols. Where things live stands in `write_symbols`, expressions in `write_expr`, calls in `write_call`.

use super::write_symbols::{Home, Place};
use super::{Access, MAIN, MAX_OPS, Module, Op, SymId, SymbolKind};
use crate::check::Checked;
use crate::check::typed::{Expr, ExprKind, Shader, Stmt, VarId};
use crate::diag::Diagnostic;
use crate::source::{SourceMap, Span};
use crate::types::Type;
use std::collections::{HashMap, HashSet};

/// Writes a checked shader. `comments` stand behind the version line.
pub fn write(checked: &Checked, sources: &SourceMap, comments: Vec<String>) -> Result<Module, Vec<Diagnostic>> {
    let shader = &checked.shader;
    let mut writer = Writer {
        tree: shader,
        sources,
        module: Module {
            comments,
            kind: shader.kind.clone(),
            name: shader.name.clone(),
            hints: checked.info.metadata.iter().filter_map(super::write_symbols::meta).collect(),
            symbols: Vec::new(),
            sections: Vec::new(),
            ops: Vec::new(),
            files: sources.names().map(str::to_owned).collect(),
        },
        env: HashMap::new(),
        constants: HashMap::new(),
        temps: 0,
        written: super::write_call::written_variables(shader),
        frames: Vec::new(),
        at: None,
        errors: Vec::new(),
    };
    for (param, info) in shader.params.iter().zip(&checked.info.params) {
        writer.param(param, info);
    }
    for param in &shader.params {
        writer.param_default(param);
    }
    writer.section(MAIN);
    writer.frames.push(Frame { result: None, nesting: 0, function: false });
    writer.stmts(&shader.body);
    writer.finish()
}

/// A body being written.
pub(super) struct Frame {
    /// Where `return value` puts it.
    pub result: Option<Home>,
    /// Branches and loops around the present statement.
    pub nesting: u32,
    /// False: the shader itself.
    pub function: bool,
}

/// Carries the state of a run.
pub(super) struct Writer<'a> {
    pub tree: &'a Shader,
    pub sources: &'a SourceMap,
    pub module: Module,
    pub env: HashMap<VarId, Home>,
    /// Constants by type and bits.
    pub constants: HashMap<String, SymId>,
    pub temps: u32,
    /// What functions assign.
    pub written: HashSet<VarId>,
    pub frames: Vec<Frame>,
    /// File and line of the operations being written.
    pub at: Option<(u32, u32)>,
    pub errors: Vec<Diagnostic>,
}

impl Writer<'_> {
    pub fn error(&mut self, d: Diagnostic) {
        if self.errors.len() < 100 && !self.errors.contains(&d) {
            self.errors.push(d);
        }
    }

    /// Starts a code section.
    pub fn section(&mut self, name: &str) {
        self.module.sections.push((name.to_owned(), self.module.ops.len() as u32));
    }

    /// Sets where the next operations come from.
    pub fn locate(&mut self, span: Span) {
        if (span.file.0 as usize) >= self.sources.len() {
            return;
        }
        let (name, line) = self.sources.shown(span);
        let mut file = span.file.0;
        if self.sources.is_renumbered(span.file) {
            let files = &mut self.module.files;
            let at = files.iter().position(|f| f == name).unwrap_or_else(|| {
                files.push(name.to_owned());
                files.len() - 1
            });
            file = at as u32;
        }
        self.at = Some((file, line));
    }

    /// Appends an operation; `access` has a letter per argument: `r`, `w` or `W` for both. Its number.
    pub fn op(&mut self, name: &str, access: &str, args: &[SymId]) -> usize {
        let access = access
            .chars()
            .map(|c| match c {
                'w' => Access::Write,
                'W' => Access::Both,
                _ => Access::Read,
            })
            .collect();
        self.op_with(name, access, args.to_vec())
    }

    pub fn op_with(&mut self, name: &str, access: Vec<Access>, args: Vec<SymId>) -> usize {
        if self.module.ops.len() < MAX_OPS {
            let section = self.module.sections.len().max(1) as u32 - 1;
            let span = Span { file: crate::source::FileId(0), start: 0, end: 0 };
            let name = name.to_owned();
            let op = Op { name, args, jumps: Vec::new(), access, derivs: Vec::new(), section, at: self.at, span };
            self.module.ops.push(op);
        }
        self.module.ops.len() - 1
    }

    pub fn too_large(&self) -> bool {
        self.module.ops.len() >= MAX_OPS
    }

    /// The number of the next operation.
    pub fn here(&self) -> u32 {
        self.module.ops.len() as u32
    }

    pub fn jumps(&mut self, op: usize, targets: Vec<u32>) {
        if let Some(op) = self.module.ops.get_mut(op) {
            op.jumps = targets;
        }
    }

    /// An `if` with its branches.
    pub fn branch(&mut self, cond: SymId, then: impl FnOnce(&mut Self), otherwise: impl FnOnce(&mut Self)) {
        let op = self.op("if", "r", &[cond]);
        self.nested(1);
        then(self);
        let middle = self.here();
        otherwise(self);
        self.nested(-1);
        let end = self.here();
        self.jumps(op, vec![middle, end]);
    }

    fn nested(&mut self, by: i32) {
        if let Some(frame) = self.frames.last_mut() {
            frame.nesting = frame.nesting.saturating_add_signed(by);
        }
    }

    /// Writes statements.
    pub fn stmts(&mut self, stmts: &[Stmt]) {
        for (i, stmt) in stmts.iter().enumerate() {
            if self.too_large() {
                return;
            }
            self.stmt(stmt, i + 1 == stmts.len());
        }
    }

    fn stmt(&mut self, stmt: &Stmt, last: bool) {
        match stmt {
            Stmt::Declare(var, init) => {
                let home = self.declare(*var);
                if let Some(e) = init {
                    self.locate(e.span);
                    self.assign(&Place::Home(home), e);
                }
            }
            Stmt::Expr(e) => {
                self.locate(e.span);
                self.effect(e);
            }
            Stmt::Block(b) => {
                // A last `return` in a bare block is still the last thing done.
                self.nested(i32::from(!last));
                self.stmts(b);
                self.nested(-i32::from(!last));
            }
            Stmt::If(cond, a, b) => {
                self.locate(cond.span);
                let cond = self.value(cond, None);
                self.branch(cond, |w| w.stmts(a), |w| w.stmts(b));
            }
            Stmt::Loop { cond, after, step, body } => self.loop_(cond.as_ref(), *after, step.as_ref(), body),
            Stmt::Break => {
                self.op("break", "", &[]);
            }
            Stmt::Continue => {
                self.op("continue", "", &[]);
            }
            Stmt::Return(value, span) => {
                self.locate(*span);
                let result = self.frames.last().and_then(|f| f.result.clone());
                if let (Some(e), Some(home)) = (value, result) {
                    self.assign(&Place::Home(home), e);
                }
                match self.frames.last() {
                    Some(f) if f.function && f.nesting == 0 && last => {}
                    Some(f) if f.function => {
                        self.op("return", "", &[]);
                    }
                    _ => {
                        self.op("exit", "", &[]);
                    }
                }
            }
        }
    }

    fn loop_(&mut self, cond: Option<&Expr>, after: bool, step: Option<&Expr>, body: &[Stmt]) {
        if let Some(e) = cond {
            self.locate(e.span);
        }
        let name = match (after, step) {
            (true, _) => "dowhile",
            (false, Some(_)) => "for",
            (false, None) => "while",
        };
        let op = self.op(name, "r", &[]);
        self.nested(1);
        let start = self.here();
        let symbol = match cond {
            Some(e) => {
                let value = self.value(e, None);
                if self.module.symbol(value).kind == SymbolKind::Temp { value } else { self.compared(value, "neq") }
            }
            None => self.int(1),
        };
        let first = self.here();
        self.stmts(body);
        let iteration = self.here();
        if let Some(e) = step {
            self.locate(e.span);
            self.effect(e);
        }
        self.nested(-1);
        let end = self.here();
        if let Some(o) = self.module.ops.get_mut(op).filter(|o| o.name == name) {
            o.args = vec![symbol];
            o.access = vec![Access::Read];
        }
        self.jumps(op, vec![start, first, iteration, end]);
    }

    /// An expression for its effect.
    pub fn effect(&mut self, e: &Expr) {
        match &e.kind {
            ExprKind::Comma(parts) => parts.iter().for_each(|p| self.effect(p)),
            ExprKind::Call(callee, args) => {
                self.call(callee, args, e, None);
            }
            ExprKind::Assign(target, value) => {
                let place = self.place(target);
                self.assign_apart(&place, value);
            }
            _ if e.ty == Type::VOID => {}
            _ => {
                self.home(e);
            }
        }
    }

    fn finish(mut self) -> Result<Module, Vec<Diagnostic>> {
        if self.too_large() {
            let at = self.tree.body.iter().find_map(first_span).or(self.tree.vars.last().map(|v| v.span));
            let span = at.unwrap_or(Span { file: crate::source::FileId(0), start: 0, end: 0 });
            let message = format!("the shader grows beyond {MAX_OPS} operations once its functions are inlined");
            self.error(Diagnostic::error("E5003", span, message).help("call large functions in fewer places"));
        }
        if !self.errors.is_empty() {
            return Err(self.errors);
        }
        self.drop_unused();
        self.mark_uses();
        Ok(self.module)
    }
}

fn first_span(stmt: &Stmt) -> Option<Span> {
    match stmt {
        Stmt::Expr(e) | Stmt::If(e, ..) => Some(e.span),
        _ => None,
    }
}
