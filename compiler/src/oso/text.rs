//! A [`Module`] as text.
//!
//! In: a module, and the OSL sources that its operations came from. Out: the `.oso` file. It must not know what operations mean.

use super::number::exact;
use super::{Access, Element, Hint, HintArg, Literal, MAGIC, MAIN, Module, Op, SymType, Symbol, SymbolKind};
use crate::escape::escape;
use crate::types::{Base, Extent};
use std::fmt::Write;

/// "Never", as the format spells it.
const NEVER: &str = "2147483647,-1";

impl SymType {
    /// As the format spells it: `float[4]`, `closure color`, `struct Light`.
    pub fn spelling(&self) -> String {
        let element = match &self.element {
            Element::Base(Base::Closure) => "closure color",
            Element::Base(b) => b.keyword(),
            Element::Struct(name) => return format!("struct {name}{}", extent(self.extent)),
        };
        format!("{element}{}", extent(self.extent))
    }
}

fn extent(extent: Extent) -> String {
    match extent {
        Extent::Scalar => String::new(),
        Extent::Fixed(n) => format!("[{n}]"),
        Extent::Unsized => "[]".to_owned(),
    }
}

/// Writes a module. `line_text` gives a line of an OSL file, for the comments between operations.
pub fn to_text(module: &Module, line_text: &dyn Fn(&str, u32) -> String) -> String {
    let mut out = format!("{MAGIC} 1.00\n");
    for comment in &module.comments {
        let _ = writeln!(out, "# {comment}");
    }
    let _ = write!(out, "{} {}", module.kind, module.name);
    for (i, h) in module.hints.iter().enumerate() {
        out.push(if i == 0 { '\t' } else { ' ' });
        hint(&mut out, h);
    }
    out.push('\n');
    for s in &module.symbols {
        symbol(&mut out, s);
    }
    let mut has_main = false;
    for (index, (name, _)) in module.sections.iter().enumerate() {
        let _ = writeln!(out, "code {name}");
        has_main |= name == MAIN;
        let mut place = None;
        for op in &module.ops[module.section(index)] {
            operation(&mut out, module, op, &mut place, line_text);
        }
    }
    if !has_main {
        let _ = writeln!(out, "code {MAIN}");
    }
    out.push_str("\tend\n");
    out
}

fn hint(out: &mut String, h: &Hint) {
    let _ = write!(out, "%{}", h.name);
    if h.args.is_empty() {
        return;
    }
    out.push('{');
    for (i, arg) in h.args.iter().enumerate() {
        if i > 0 {
            out.push(',');
        }
        match arg {
            HintArg::Word(w) => out.push_str(w),
            HintArg::Str(s) => {
                let _ = write!(out, "\"{}\"", escape(s));
            }
        }
    }
    out.push('}');
}

fn literal(out: &mut String, value: &Literal) {
    match value {
        Literal::Int(v) => {
            let _ = write!(out, "{v}");
        }
        Literal::Float(v) => out.push_str(&exact(*v)),
        Literal::Str(s) => {
            let _ = write!(out, "\"{}\"", escape(s));
        }
    }
}

fn symbol(out: &mut String, s: &Symbol) {
    let _ = write!(out, "{}\t{}\t{}", s.kind.word(), s.ty.spelling(), s.name);
    if s.kind.is_param() || s.kind == SymbolKind::Const {
        out.push('\t');
        for (i, v) in s.values.iter().enumerate() {
            if i > 0 {
                out.push(' ');
            }
            literal(out, v);
        }
        out.push('\t');
    }
    out.push('\t');
    for h in s.hints.iter().filter(|h| h.name == "meta") {
        hint(out, h);
        out.push(' ');
    }
    let range = |u: Option<(u32, u32)>| u.map_or(NEVER.to_owned(), |(a, b)| format!("{a},{b}"));
    let _ = write!(out, "%read{{{}}} %write{{{}}}", range(s.uses[0]), range(s.uses[1]));
    for h in s.hints.iter().filter(|h| h.name != "meta") {
        out.push(' ');
        hint(out, h);
    }
    out.push('\n');
}

fn operation(
    out: &mut String,
    module: &Module,
    op: &Op,
    place: &mut Option<(u32, u32)>,
    line_text: &dyn Fn(&str, u32) -> String,
) {
    if let Some((file, line)) = op.at.filter(|_| op.at != *place) {
        let name = module.files.get(file as usize).map_or("", String::as_str);
        let _ = writeln!(out, "# {name}:{line}\n# {}", line_text(name, line));
    }
    let _ = write!(out, "\t{}", op.name);
    if !op.args.is_empty() {
        out.push_str(if op.name.len() < 8 { "\t\t" } else { "\t" });
    }
    for arg in &op.args {
        let _ = write!(out, "{} ", module.symbol(*arg).name);
    }
    for jump in &op.jumps {
        let _ = write!(out, "{jump} ");
    }
    let mut hints = Vec::new();
    if let Some((file, line)) = op.at {
        if place.is_none_or(|(f, _)| f != file) {
            let name = module.files.get(file as usize).map_or("", String::as_str);
            hints.push(format!("%filename{{\"{}\"}}", escape(name)));
        }
        if op.at != *place {
            hints.push(format!("%line{{{line}}}"));
        }
        *place = op.at;
    }
    if !op.access.is_empty() {
        let letter = |a: &Access| match a {
            Access::Read => 'r',
            Access::Write => 'w',
            Access::Both => 'W',
        };
        hints.push(format!("%argrw{{\"{}\"}}", op.access.iter().map(letter).collect::<String>()));
    }
    if !op.derivs.is_empty() {
        let list: Vec<String> = op.derivs.iter().map(u32::to_string).collect();
        hints.push(format!("%argderivs{{{}}}", list.join(",")));
    }
    if !hints.is_empty() {
        let _ = write!(out, "\t{}", hints.join(" "));
    }
    out.push('\n');
}
