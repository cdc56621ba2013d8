//! Prints a shader as text that [`super::read`] takes back.
//!
//! One statement per line. Spans are left out: what is read back has none.

use super::{Arg, Block, Const, Inst, LocalKind, Shader, SlotArg, Stmt};
use crate::builtins;
use std::fmt::Write;

/// The text of a shader.
pub fn print(shader: &Shader) -> String {
    let mut p = Printer { shader, out: String::new(), level: 0 };
    let _ = writeln!(p.out, "{} {:?}", shader.kind, shader.name);
    for (i, local) in shader.locals.iter().enumerate() {
        let len = local.len.map_or(String::new(), |n| format!("[{n}]"));
        let _ = write!(p.out, "local L{i} {}{len} {:?}", local.ty.code(), local.name);
        match local.kind {
            LocalKind::Variable => p.out.push('\n'),
            LocalKind::Param(n) => {
                let _ = writeln!(p.out, " is param {n}");
            }
            LocalKind::Input(n) => {
                let _ = writeln!(p.out, " is input {n}");
            }
            LocalKind::Global(g) => {
                let _ = writeln!(p.out, " is global {}", g.name());
            }
        }
    }
    for input in &shader.inputs {
        let len = input.len.map_or(String::new(), |n| format!("[{n}]"));
        let base = input.declared.base.keyword();
        let default = input.default.as_ref().map_or(String::new(), |c| format!(" {}", constant(c)));
        let source = input.source.name();
        let _ = writeln!(p.out, "input {source} {}{len} {base:?} {:?}{default}", input.ty.code(), input.name);
    }
    for param in &shader.params {
        let output = if param.output { " output" } else { "" };
        let mut varying = if param.varying { " varying" } else { "" }.to_owned();
        let traits = param.traits;
        for (is, word) in
            [(traits.interactive, " interactive"), (traits.unconnectable, " unconnectable"), (traits.open, " open")]
        {
            varying.push_str(if is { word } else { "" });
        }
        let base = param.declared.base.keyword();
        let _ = write!(p.out, "param L{} {base:?} {:?}{output}{varying} ", param.local.0, param.name);
        p.block(&param.init);
        p.out.push('\n');
    }
    for slot in &shader.slots {
        let args: Vec<String> = slot
            .args
            .iter()
            .map(|a| match a {
                SlotArg::Const(c) => constant(c),
                SlotArg::Local(l) => format!("L{}", l.0),
            })
            .collect();
        let name = builtins::closure(slot.closure).name;
        let _ = writeln!(p.out, "slot {name}#{} L{} ({})", slot.closure.0, slot.weight.0, args.join(", "));
    }
    p.out.push_str("body ");
    p.block(&shader.body);
    p.out.push('\n');
    p.out
}

struct Printer<'a> {
    shader: &'a Shader,
    out: String,
    level: usize,
}

/// A constant with its type's letter: `f 0.5`, `v (0.0 0.0 1.0)`, `s "text"`.
pub(super) fn constant(c: &Const) -> String {
    let list = |v: &[f64]| v.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ");
    match c {
        Const::Int(v) => format!("i {v}"),
        Const::Float(v) => format!("f {v:?}"),
        Const::Triple(v) => format!("v ({})", list(v)),
        Const::Matrix(v) => format!("m ({})", list(v)),
        Const::Str(s) => format!("s {s:?}"),
        Const::Array(items) => format!("a ({})", items.iter().map(constant).collect::<Vec<_>>().join(" ")),
    }
}

impl Printer<'_> {
    fn block(&mut self, block: &Block) {
        if block.stmts.is_empty() {
            self.out.push_str("{}");
            return;
        }
        self.out.push_str("{\n");
        self.level += 1;
        for stmt in &block.stmts {
            self.out.push_str(&"  ".repeat(self.level));
            self.stmt(stmt);
            self.out.push('\n');
        }
        self.level -= 1;
        self.out.push_str(&"  ".repeat(self.level));
        self.out.push('}');
    }

    fn stmt(&mut self, stmt: &Stmt) {
        match stmt {
            Stmt::Let(id) => {
                let value = &self.shader.values[id.0 as usize];
                let text = inst(&value.inst);
                let _ = write!(self.out, "%{}: {} = {text}", id.0, value.ty.code());
            }
            Stmt::Store(l, v) => {
                let _ = write!(self.out, "store L{} %{}", l.0, v.0);
            }
            Stmt::StoreElem(l, i, v) => {
                let _ = write!(self.out, "storeelem L{} %{} %{}", l.0, i.0, v.0);
            }
            Stmt::CopyArray(a, b) => {
                let _ = write!(self.out, "copy L{} L{}", a.0, b.0);
            }
            Stmt::Call { func, args: inputs, outputs, result, .. } => {
                let outs: Vec<String> = outputs.iter().map(|l| format!("L{}", l.0)).collect();
                let result = result.map_or(String::new(), |l| format!(" result L{}", l.0));
                let name = builtins::row(*func).name;
                let _ = write!(self.out, "call {name}({}) -> ({}){result}", args(inputs), outs.join(", "));
            }
            Stmt::If(cond, a, b) => {
                let _ = write!(self.out, "if %{} ", cond.0);
                self.block(a);
                if !b.stmts.is_empty() {
                    self.out.push_str(" else ");
                    self.block(b);
                }
            }
            Stmt::Loop(l) => {
                self.out.push_str("loop ");
                self.block(&l.head);
                let after = if l.tested_after { " after" } else { "" };
                let _ = write!(self.out, " while %{}{after} ", l.cond.0);
                self.block(&l.body);
                self.out.push_str(" step ");
                self.block(&l.step);
            }
            Stmt::Break => self.out.push_str("break"),
            Stmt::Continue => self.out.push_str("continue"),
        }
    }
}

fn args(list: &[Arg]) -> String {
    let one = |a: &Arg| match a {
        Arg::Value(v) => format!("%{}", v.0),
        Arg::Array(l) => format!("L{}", l.0),
    };
    list.iter().map(one).collect::<Vec<_>>().join(", ")
}

fn inst(inst: &Inst) -> String {
    let mut operands = Vec::new();
    inst.operands(&mut |v| operands.push(format!("%{}", v.0)));
    let operands = operands.join(" ");
    match inst {
        Inst::Const(c) => constant(c),
        Inst::Load(l) => format!("load L{}", l.0),
        Inst::LoadElem(l, _) => format!("loadelem L{} {operands}", l.0),
        Inst::Unary(op, _) => format!("{} {operands}", format!("{op:?}").to_lowercase()),
        Inst::Binary(op, _, _) => format!("{} {operands}", format!("{op:?}").to_lowercase()),
        Inst::Convert(_) => format!("convert {operands}"),
        Inst::Triple(_) => format!("triple {operands}"),
        Inst::Matrix(_) => format!("matrix {operands}"),
        Inst::Component(..) => format!("component {operands}"),
        Inst::MatrixElement(..) => format!("element {operands}"),
        Inst::WithComponent(..) => format!("withcomponent {operands}"),
        Inst::WithMatrixElement(..) => format!("withelement {operands}"),
        Inst::Select(..) => format!("select {operands}"),
        Inst::Call(func, list) => format!("call {}({})", builtins::row(*func).name, args(list)),
        Inst::Closure(id, _) => {
            format!("closure {}#{} {operands}", builtins::closure(*id).name, id.0).trim_end().into()
        }
        Inst::Albedo(id, _) => format!("albedo {}#{} {operands}", builtins::closure(*id).name, id.0).trim_end().into(),
        Inst::Layer(..) => format!("layer {operands}"),
        Inst::NullClosure => "null".into(),
        Inst::AddClosure(..) => format!("addclosure {operands}"),
        Inst::ScaleClosure(..) => format!("scaleclosure {operands}"),
        Inst::ClosureIsSet(_) => format!("isset {operands}"),
    }
}
