//! Compiled shaders as text: the public `.oso` format, written and read.
//!
//! In and out: [`Module`], what an `.oso` file says, line by line. [`write`](mod@write) makes one of the typed tree,
//! [`parse`] and [`text`] are its textual form, [`read`](mod@read) makes a typed tree of it again, [`query`] tells its
//! parameters as `oslinfo` shows them. docs/adr/0011-oso.md says why the typed tree is both ends. It must not know the IR or any target.
//!
//! The format: a version line; the shader's kind and name with hints; a line per symbol (kind, type, name, values, hints);
//! code sections, `code NAME`, of one operation a line (name, symbols, jump targets, hints). Operations are numbered from 0
//! through all sections; jump targets are such numbers. A section named by a parameter computes its default value,
//! `___main___` is the shader.
//!
//! Codes: `E5001` text that is no `.oso`, `E5002` an operation that is not known or does not fit, `E5003` what the format
//! cannot say.

pub mod number;
pub mod parse;
pub mod query;
pub mod read;
mod read_call;
mod read_fit;
mod read_stmt;
pub mod text;
pub mod write;
mod write_call;
mod write_expr;
mod write_symbols;

use crate::source::Span;
use crate::types::{Base, Extent};

/// The section of the shader's own code.
pub const MAIN: &str = "___main___";

/// Most operations of a module. Inlining multiplies code: a file that grows beyond this would take minutes to compile.
pub const MAX_OPS: usize = 250_000;

/// How every `.oso` file starts.
pub const MAGIC: &str = "OpenShadingLanguage";

/// Handle of a [`Symbol`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SymId(pub u32);

/// What a symbol is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymbolKind {
    /// A parameter.
    Param,
    /// An output parameter.
    OutputParam,
    /// A variable of the user's.
    Local,
    /// A variable of the compiler's.
    Temp,
    /// A shader global.
    Global,
    /// A constant.
    Const,
}

impl SymbolKind {
    /// Each with its word in the text.
    pub const ALL: [(SymbolKind, &'static str); 6] = [
        (SymbolKind::Param, "param"),
        (SymbolKind::OutputParam, "oparam"),
        (SymbolKind::Local, "local"),
        (SymbolKind::Temp, "temp"),
        (SymbolKind::Global, "global"),
        (SymbolKind::Const, "const"),
    ];

    /// Its word in the text.
    pub fn word(self) -> &'static str {
        SymbolKind::ALL.iter().find(|(k, _)| *k == self).map_or("", |(_, w)| w)
    }

    /// Whether it is a parameter.
    pub fn is_param(self) -> bool {
        matches!(self, SymbolKind::Param | SymbolKind::OutputParam)
    }
}

/// An element type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Element {
    /// Any but a struct.
    Base(Base),
    /// A struct by name. Its fields are symbols of their own.
    Struct(String),
}

/// A symbol's type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SymType {
    /// Of the elements.
    pub element: Element,
    /// How many.
    pub extent: Extent,
}

impl SymType {
    /// Floats, ints or strings that one element is made of.
    pub fn components(&self) -> usize {
        match self.element {
            Element::Base(b) if b.is_triple() => 3,
            Element::Base(Base::Matrix) => 16,
            _ => 1,
        }
    }

    /// The base type; `None` for structs.
    pub fn base(&self) -> Option<Base> {
        match self.element {
            Element::Base(b) => Some(b),
            Element::Struct(_) => None,
        }
    }
}

/// A value in the text.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal {
    /// A whole number.
    Int(i32),
    /// A number with a point or an exponent.
    Float(f64),
    /// A string, unescaped.
    Str(String),
}

/// One argument of a hint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HintArg {
    /// A name, a type or a number, as written.
    Word(String),
    /// A string, unescaped.
    Str(String),
}

impl HintArg {
    /// Its text, without quotes.
    pub fn text(&self) -> &str {
        match self {
            HintArg::Word(t) | HintArg::Str(t) => t,
        }
    }
}

/// `%name{args}`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hint {
    /// Its name.
    pub name: String,
    /// What stands in the braces.
    pub args: Vec<HintArg>,
}

/// A symbol line.
#[derive(Clone, Debug, PartialEq)]
pub struct Symbol {
    /// What it is.
    pub kind: SymbolKind,
    /// Its type.
    pub ty: SymType,
    /// Its name, unique in the file.
    pub name: String,
    /// Its value, or a parameter's default.
    pub values: Vec<Literal>,
    /// Hints; `%read` and `%write` are [`Symbol::uses`].
    pub hints: Vec<Hint>,
    /// First and last operation that reads it and that writes it.
    pub uses: [Option<(u32, u32)>; 2],
    /// Its line in the `.oso`.
    pub span: Span,
}

impl Symbol {
    /// The hint with this name.
    pub fn hint(&self, name: &str) -> Option<&Hint> {
        self.hints.iter().find(|h| h.name == name)
    }
}

/// What an operation does with an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// `r`
    Read,
    /// `w`
    Write,
    /// `W`
    Both,
}

/// An operation.
#[derive(Clone, Debug, PartialEq)]
pub struct Op {
    /// Its name.
    pub name: String,
    /// Its arguments, a result first.
    pub args: Vec<SymId>,
    /// Numbers of operations.
    pub jumps: Vec<u32>,
    /// One per argument; empty when not told.
    pub access: Vec<Access>,
    /// Arguments whose derivatives are taken.
    pub derivs: Vec<u32>,
    /// Index of its section.
    pub section: u32,
    /// File (index into [`Module::files`]) and line of the OSL source.
    pub at: Option<(u32, u32)>,
    /// Its line in the `.oso`.
    pub span: Span,
}

/// A compiled shader.
#[derive(Clone, Debug, PartialEq)]
pub struct Module {
    /// Comment lines after the version, without `#`.
    pub comments: Vec<String>,
    /// `surface`, `displacement`, `volume`, `shader`, `light`.
    pub kind: String,
    /// Its name.
    pub name: String,
    /// Hints of the shader: its metadata.
    pub hints: Vec<Hint>,
    /// Symbols, parameters first.
    pub symbols: Vec<Symbol>,
    /// Sections in order: names, and the number of the first operation of each.
    pub sections: Vec<(String, u32)>,
    /// All operations.
    pub ops: Vec<Op>,
    /// Files that operations name.
    pub files: Vec<String>,
}

impl Module {
    /// The symbol behind a handle of this module.
    pub fn symbol(&self, id: SymId) -> &Symbol {
        &self.symbols[id.0 as usize]
    }

    /// The operations of a section, as a range of their numbers.
    pub fn section(&self, index: usize) -> std::ops::Range<usize> {
        let start = self.sections.get(index).map_or(self.ops.len(), |s| s.1 as usize);
        let end = self.sections.get(index + 1).map_or(self.ops.len(), |s| s.1 as usize);
        start..end
    }
}

/// Whether a text is an `.oso` file rather than OSL.
pub fn is_oso(text: &str) -> bool {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    text.strip_prefix(MAGIC).is_some_and(|rest| rest.starts_with([' ', '\t']))
}
