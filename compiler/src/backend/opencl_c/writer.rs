//! The state of one emission, and the expressions of the IR as C text.
//!
//! A value that is used once, in the block that computes it, becomes part of the expression that uses it, unless a store
//! to something it reads stands between; the others become `const` variables.

use super::literal;
use crate::backend::analysis::{Analysis, BlockNumber, LocalUse, ROOT};
use crate::backend::headers;
use crate::backend::names;
use crate::backend::string_id;
use crate::diag::Diagnostic;
use crate::ir::{Const, InputLayout, Inst, LocalId, LocalKind, Shader, Ty, ValueId};
use crate::messages::Site;
use crate::source::{SourceMap, Span};
use std::collections::{BTreeSet, HashMap, VecDeque};

/// Longer expressions become variables of their own.
const MAX_INLINE: usize = 72;

/// Values waiting to be used, at most.
const MAX_PENDING: usize = 64;

/// Nested braces that C compilers take without complaint (clang refuses 256).
const MAX_DEPTH: usize = 200;

/// Longer constant arrays lie in constant memory.
pub(super) const MAX_PRIVATE_TABLE: u32 = 16;

/// How tightly an expression binds; higher binds tighter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Prec {
    Conditional,
    Bits,
    Equality,
    Relation,
    Sum,
    Product,
    Unary,
    Primary,
}

/// C text of a value.
#[derive(Clone, Debug)]
pub(super) struct Expr {
    pub text: String,
    pub prec: Prec,
    /// Locals that it reads and that may change.
    pub loads: Vec<LocalId>,
    /// It is exactly this local.
    pub whole: Option<LocalId>,
    /// It is a triple of this one float.
    pub splat: Option<Box<Expr>>,
    /// It is this local with one component set: the component's place and the new value.
    pub update: Option<(LocalId, String, String)>,
}

impl Expr {
    pub(super) fn new(text: impl Into<String>, prec: Prec) -> Expr {
        Expr { text: text.into(), prec, loads: Vec::new(), whole: None, splat: None, update: None }
    }

    /// The text, in parentheses if it binds less tightly than asked.
    pub(super) fn at(&self, prec: Prec) -> String {
        if self.prec >= prec { self.text.clone() } else { format!("({})", self.text) }
    }

    pub(super) fn reads(mut self, others: &[&Expr]) -> Expr {
        for other in others {
            for l in &other.loads {
                if !self.loads.contains(l) {
                    self.loads.push(*l);
                }
            }
        }
        self
    }
}

/// What `break` and `continue` of a loop become.
#[derive(Clone, Debug)]
pub(super) enum LoopForm {
    /// C's own.
    Plain,
    /// The body is a `do {} while (0)`: leaving it continues; the flag leaves the loop.
    Wrapped(String),
}

/// One emission.
pub(super) struct Writer<'a> {
    pub shader: &'a Shader,
    pub inputs: InputLayout,
    pub analysis: Analysis<'a>,
    pub out: String,
    pub indent: usize,
    /// Program-scope tables, in front of the function.
    pub tables: String,
    pub names: Vec<String>,
    pub declared: Vec<bool>,
    pub loops: Vec<LoopForm>,
    pub flags: u32,
    /// The block being written.
    pub scope: BlockNumber,
    pub includes: BTreeSet<&'static str>,
    pub errors: Vec<Diagnostic>,
    sources: Option<&'a SourceMap>,
    line: Option<(u32, u32)>,
    exprs: Vec<Option<Expr>>,
    pending: VecDeque<ValueId>,
    temps: u32,
    /// Texts of the strings written, by id.
    pub strings: HashMap<u32, String>,
    /// The calls that print.
    pub sites: Vec<Site>,
    depth: usize,
}

impl<'a> Writer<'a> {
    pub(super) fn new(shader: &'a Shader, results: &[LocalId], sources: Option<&'a SourceMap>) -> Writer<'a> {
        Writer {
            shader,
            inputs: InputLayout::of(shader),
            analysis: Analysis::of(shader, results),
            out: String::new(),
            indent: 1,
            tables: String::new(),
            names: names::of_locals(shader),
            declared: vec![false; shader.locals.len()],
            loops: Vec::new(),
            flags: 0,
            scope: ROOT,
            includes: BTreeSet::new(),
            errors: Vec::new(),
            sources,
            line: None,
            exprs: vec![None; shader.values.len()],
            pending: VecDeque::new(),
            temps: 0,
            strings: HashMap::new(),
            sites: Vec::new(),
            depth: 0,
        }
    }

    /// Writes one line, after a `#line` if lines are tracked and the place is news.
    pub(super) fn put(&mut self, span: Option<Span>, text: &str) {
        if let (Some(sources), Some(span)) = (self.sources, span.filter(|s| s.end > s.start)) {
            let (name, line) = sources.shown(span);
            let at = (span.file.0, line);
            if self.line != Some(at) {
                let name = name.replace(['"', '\\', '\n', '\r', '@'], "_");
                self.out.push_str(&format!("#line {} \"{name}\"\n", at.1));
                self.line = Some(at);
            }
        }
        for _ in 0..self.indent {
            self.out.push_str("    ");
        }
        self.out.push_str(text);
        self.out.push('\n');
        self.line = self.line.map(|(file, line)| (file, line + 1));
    }

    /// Whether `#line` directives are written.
    pub(super) fn tracks_lines(&self) -> bool {
        self.sources.is_some()
    }

    /// Variables made for values so far.
    pub(super) fn temps(&self) -> u32 {
        self.temps
    }

    /// The next line gets a `#line` in any case.
    pub(super) fn forget_line(&mut self) {
        self.line = None;
    }

    /// Opens a brace level.
    pub(super) fn open(&mut self, span: Option<Span>) {
        self.indent += 1;
        self.depth += 1;
        if self.depth == MAX_DEPTH {
            let message = format!("control flow nests deeper than the {MAX_DEPTH} levels that OpenCL compilers accept");
            self.errors.push(match span {
                Some(span) => Diagnostic::error("E4202", span, message),
                None => Diagnostic::global("E4202", message),
            });
        }
    }

    /// Closes a brace level.
    pub(super) fn close(&mut self) {
        self.indent -= 1;
        self.depth -= 1;
    }

    /// An operator's helper, by name; its header is included.
    pub(super) fn op(&mut self, name: &'static str) -> &'static str {
        self.includes.insert(headers::of_op(name));
        name
    }

    pub(super) fn local_use(&self, l: LocalId) -> &LocalUse {
        &self.analysis.locals[l.0 as usize]
    }

    pub(super) fn name(&self, l: LocalId) -> &str {
        &self.names[l.0 as usize]
    }

    pub(super) fn constant(&mut self, c: &Const) -> String {
        if let Const::Str(text) = c {
            let earlier = self.strings.entry(string_id(text)).or_insert_with(|| text.clone());
            if earlier != text {
                let message = format!("the strings `{earlier}` and `{text}` have the same id on the device");
                self.errors.push(Diagnostic::global("E4201", message).help("rename one of them"));
            }
        }
        if matches!(c, Const::Matrix(_)) {
            self.op("op_matrix_f");
        }
        literal::constant(c)
    }

    /// Zero of a type.
    pub(super) fn zero(&mut self, ty: Ty) -> &'static str {
        match ty {
            Ty::Float => "0.0",
            Ty::Triple => "(real3)(0.0)",
            Ty::Matrix => {
                self.op("op_matrix_f");
                "op_matrix_f(0.0)"
            }
            _ => "0",
        }
    }

    /// The value of a single local, now.
    pub(super) fn load(&mut self, l: LocalId) -> Expr {
        let local = &self.shader.locals[l.0 as usize];
        let never_written = self.local_use(l).writes == 0;
        match local.kind {
            LocalKind::Global(g) if never_written => return Expr::new(format!("sg->{}", g.name()), Prec::Primary),
            LocalKind::Input(i) => return self.input(i),
            _ if never_written => return Expr::new(self.zero(local.ty), Prec::Unary),
            _ => {}
        }
        let mut e = Expr::new(self.name(l), Prec::Primary);
        if !self.analysis.is_fixed(l) {
            e.loads.push(l);
            e.whole = Some(l);
        }
        e
    }

    /// `array[index]`; the index is in range already.
    pub(super) fn element(&mut self, l: LocalId, index: &str) -> Expr {
        let ty = self.shader.locals[l.0 as usize].ty;
        let name = self.name(l).to_owned();
        if !self.is_table(l) {
            let mut e = Expr::new(format!("{name}[{index}]"), Prec::Primary);
            if self.local_use(l).changes {
                e.loads.push(l);
            }
            return e;
        }
        Expr::new(table_element(self, ty, &name, index), Prec::Primary)
    }

    /// Whether an array is read from constant memory only.
    pub(super) fn is_table(&self, l: LocalId) -> bool {
        let u = self.local_use(l);
        let len = self.shader.locals[l.0 as usize].len.unwrap_or(0);
        len > MAX_PRIVATE_TABLE && !u.changes && !u.passed && !u.initial.is_empty()
    }

    /// The text of a value where it is used.
    pub(super) fn operand(&mut self, v: ValueId) -> Expr {
        let slot = &mut self.exprs[v.0 as usize];
        if !self.analysis.is_single(v) {
            return slot.clone().unwrap_or_else(|| Expr::new("0", Prec::Primary));
        }
        let e = slot.take().unwrap_or_else(|| Expr::new("0", Prec::Primary));
        if !e.loads.is_empty() {
            self.pending.retain(|p| *p != v);
        }
        e
    }

    /// Computes a value here or remembers how.
    pub(super) fn compute(&mut self, v: ValueId) {
        if self.analysis.is_dead(v) {
            return;
        }
        let shader = self.shader;
        let value = &shader.values[v.0 as usize];
        let free = match &value.inst {
            Inst::Const(c) => !matches!(c, Const::Matrix(_)),
            Inst::Load(l) => self.analysis.is_fixed(*l) && (value.ty != Ty::Matrix || self.local_use(*l).writes > 0),
            _ => false,
        };
        let e = self.inst(&value.inst, value.ty, value.span);
        if free || (self.analysis.is_single(v) && e.text.len() <= MAX_INLINE) {
            if !e.loads.is_empty() {
                self.pending.push_back(v);
            }
            self.exprs[v.0 as usize] = Some(e);
            if self.pending.len() > MAX_PENDING
                && let Some(oldest) = self.pending.pop_front()
            {
                self.materialise(oldest);
            }
        } else {
            self.exprs[v.0 as usize] = Some(e);
            self.materialise(v);
        }
    }

    /// Turns a remembered expression into a variable.
    fn materialise(&mut self, v: ValueId) {
        let value = &self.shader.values[v.0 as usize];
        let Some(e) = self.exprs[v.0 as usize].take() else { return };
        self.temps += 1;
        let name = format!("t{}", self.temps);
        self.put(Some(value.span), &format!("const {} {name} = {};", names::ctype(value.ty), e.text));
        self.exprs[v.0 as usize] = Some(Expr::new(name, Prec::Primary));
    }

    /// Before a local changes: computes what still wants its old value.
    pub(super) fn before_write(&mut self, l: LocalId) {
        let reads = |w: &Self, v: &ValueId| w.exprs[v.0 as usize].as_ref().is_some_and(|e| e.loads.contains(&l));
        let waiting: Vec<ValueId> = self.pending.iter().copied().filter(|v| reads(self, v)).collect();
        self.pending.retain(|v| !waiting.contains(v));
        for v in waiting {
            self.materialise(v);
        }
    }

    /// Before control flow: computes everything that reads variables.
    pub(super) fn before_branch(&mut self) {
        for v in std::mem::take(&mut self.pending) {
            self.materialise(v);
        }
    }
}

/// An element of a program-scope table of reals or ints.
pub(super) fn table_element(w: &mut Writer, ty: Ty, name: &str, index: &str) -> String {
    match ty {
        Ty::Triple => format!("vload3({index}, @_{name})"),
        Ty::Matrix => format!("{}(@_{name}, {index})", w.op("op_load_m")),
        _ => format!("@_{name}[{index}]"),
    }
}
