//! Dictionaries as tables: every node that a query can find is known before the shader runs.
//!
//! In: folded IR. Out: the same without `dict_*` calls. A query on a document becomes a number, or a choice among numbers;
//! `dict_next`, queries from nodes and values become tables by the number of the node. Documents, queries and attributes must
//! be constants or choices among them.

use super::Settings;
use super::strings::Strings;
use crate::builtins::{self, FuncId};
use crate::diag::Diagnostic;
use crate::dictionary::{Dictionary, numbers};
use crate::ir::{Arg, BinaryOp, Block, Const, Inst, LocalId, Rewriter, Shader, Stmt, Ty, Value, ValueId};
use crate::messages::code;
use crate::source::Span;
use std::collections::BTreeSet;

/// Most nodes of a shader's queries: each has a place in each table.
const MAX_NODES: i32 = 4096;

/// Most texts that one argument can be.
const MAX_TEXTS: usize = 256;

/// The rows.
#[derive(Clone, Copy)]
struct Rows {
    find: FuncId,
    next: FuncId,
    get: FuncId,
}

/// Answers all questions.
pub(super) fn dictionary(shader: &mut Shader, settings: &Settings<'_>) -> Result<(), Vec<Diagnostic>> {
    let row = builtins::find;
    let (Some(find), Some(next), Some(get)) = (row("dict_find"), row("dict_next"), row("dict_get")) else {
        return Ok(());
    };
    let rows = Rows { find, next, get };
    let mut asks = false;
    for block in shader.blocks() {
        block.walk(&mut |s| asks |= question(shader, rows, s).is_some());
    }
    if !asks {
        return Ok(());
    }
    let nothing = |_: &str| None;
    let read = settings.documents.map_or(&nothing as &dyn Fn(&str) -> Option<String>, |d| &*d.0);
    let strings = Strings::of(shader);
    let mut pass = Pass {
        shader,
        strings,
        rows,
        grid: settings.grid,
        dictionary: Dictionary::new(read),
        tables: Vec::new(),
        head: Block::default(),
        errors: Vec::new(),
    };
    pass.search();
    if pass.errors.is_empty() {
        pass.answer();
    }
    if pass.errors.is_empty() { Ok(()) } else { Err(pass.errors) }
}

/// The arguments of a question and where it stands.
fn question<'s>(shader: &'s Shader, rows: Rows, stmt: &'s Stmt) -> Option<(FuncId, &'s [Arg], Span)> {
    match stmt {
        Stmt::Let(id) => match &shader.values[id.0 as usize] {
            Value { inst: Inst::Call(func, args), span, .. } if *func == rows.find || *func == rows.next => {
                Some((*func, args, *span))
            }
            _ => None,
        },
        Stmt::Call { func, args, span, .. } if *func == rows.get => Some((*func, args, *span)),
        _ => None,
    }
}

/// What a table holds.
#[derive(Clone, PartialEq)]
enum Table {
    Next,
    From(String),
    /// Whether a node has this attribute in this type.
    Has(String, String),
    /// Its value.
    Value(String, String),
}

struct Pass<'a> {
    shader: &'a mut Shader,
    strings: Strings,
    rows: Rows,
    grid: bool,
    dictionary: Dictionary<'a>,
    tables: Vec<(Table, LocalId)>,
    /// Fills the tables.
    head: Block,
    errors: Vec<Diagnostic>,
}

impl Rewriter for Pass<'_> {
    fn shader(&mut self) -> &mut Shader {
        self.shader
    }

    fn stmt(&mut self, stmt: Stmt, out: &mut Block) {
        match stmt {
            Stmt::Let(id) => {
                self.value(id, out);
                out.stmts.push(Stmt::Let(id));
            }
            Stmt::Call { func, args, outputs, result, span } if func == self.rows.get => {
                self.get(&args, &outputs, result, span, out);
            }
            other => out.stmts.push(other),
        }
    }
}

impl Pass<'_> {
    fn texts(&self, arg: Option<&Arg>) -> Option<BTreeSet<String>> {
        let Some(Arg::Value(v)) = arg else { return None };
        let texts = self.strings.trace(self.shader, vec![*v], Vec::new())?;
        (!texts.is_empty() && texts.len() <= MAX_TEXTS).then_some(texts)
    }

    fn is_text(&self, arg: Option<&Arg>) -> bool {
        matches!(arg, Some(Arg::Value(v)) if self.shader.values[v.0 as usize].ty == Ty::Str)
    }

    /// Asks all that the shader can ask, until no new nodes are found.
    fn search(&mut self) {
        let mut asked = Vec::new();
        for block in self.shader.blocks() {
            block.walk(&mut |s| {
                if let Some((func, args, span)) = question(self.shader, self.rows, s) {
                    asked.push((func, args.to_vec(), span));
                }
            });
        }
        let mut steps = BTreeSet::new();
        for (func, args, span) in asked {
            let known = if func == self.rows.next {
                true
            } else if func == self.rows.find && self.is_text(args.first()) {
                match (self.texts(args.first()), self.texts(args.get(1))) {
                    (Some(documents), Some(queries)) => {
                        for document in &documents {
                            queries.iter().for_each(|q| _ = self.dictionary.find(document, q));
                        }
                        true
                    }
                    _ => false,
                }
            } else {
                let texts = self.texts(args.get(1));
                if func == self.rows.find {
                    steps.extend(texts.clone().into_iter().flatten());
                }
                texts.is_some()
            };
            if !known {
                let what = "a dictionary, a query or an attribute that is not known at compile time";
                let d = Diagnostic::not_yet("E3003", span, what);
                self.errors.push(d.help("choose among constants, by parameters or conditions"));
            }
        }
        let mut node = 1;
        while node <= self.dictionary.count() && node <= MAX_NODES {
            for query in &steps {
                self.dictionary.find_from(node, query);
            }
            node += 1;
        }
        if self.dictionary.count() > MAX_NODES {
            let message = format!("the shader's dictionary queries find more than {MAX_NODES} nodes");
            self.errors.push(Diagnostic::global("E3004", message).help("ask for less"));
        }
    }

    /// Answers the questions; the tables are filled before anything runs.
    fn answer(&mut self) {
        self.rewrite();
        let mut head = std::mem::take(&mut self.head);
        let first = match self.shader.params.first_mut() {
            Some(param) => &mut param.init,
            None => &mut self.shader.body,
        };
        head.stmts.append(&mut first.stmts);
        *first = head;
    }

    /// The choice by a text among values, one for each that it can be.
    fn choose(&mut self, by: ValueId, options: Vec<(String, ValueId)>, ty: Ty, span: Span, out: &mut Block) -> ValueId {
        let mut options = options.into_iter().rev();
        let mut chosen = match options.next() {
            Some((_, value)) => value,
            None => return self.shader.emit_constant(Const::Int(0), span, out),
        };
        for (text, value) in options {
            let text = self.shader.emit_constant(Const::Str(text), span, out);
            let same = self.shader.emit(Inst::Binary(BinaryOp::Eq, by, text), Ty::Int, span, out);
            chosen = self.shader.emit(Inst::Select(same, value, chosen), ty, span, out);
        }
        chosen
    }

    fn value(&mut self, id: ValueId, out: &mut Block) {
        let Value { inst: Inst::Call(func, args), span, .. } = &self.shader.values[id.0 as usize] else { return };
        let (func, args, span) = (*func, args.clone(), *span);
        let inst = match args.as_slice() {
            [Arg::Value(node)] if func == self.rows.next => Inst::LoadElem(self.table(Table::Next, span), *node),
            [Arg::Value(of), Arg::Value(query)] if func == self.rows.find => {
                let queries = self.texts(args.get(1)).unwrap_or_default();
                let chosen = if self.is_text(args.first()) {
                    let documents = self.texts(args.first()).unwrap_or_default();
                    self.find(*of, documents, *query, &queries, span, out)
                } else {
                    let mut options = Vec::new();
                    for q in queries {
                        let table = self.table(Table::From(q.clone()), span);
                        options.push((q, self.shader.emit(Inst::LoadElem(table, *of), Ty::Int, span, out)));
                    }
                    self.choose(*query, options, Ty::Int, span, out)
                };
                self.shader.values[chosen.0 as usize].inst.clone()
            }
            _ => return,
        };
        self.shader.values[id.0 as usize].inst = inst;
    }

    /// A query on a document; says what is wrong with one that cannot be read.
    fn find(
        &mut self,
        of: ValueId,
        documents: BTreeSet<String>,
        query: ValueId,
        queries: &BTreeSet<String>,
        span: Span,
        out: &mut Block,
    ) -> ValueId {
        let mut options = Vec::new();
        let only = documents.len() == 1;
        for document in documents {
            if let Some(text) = self.dictionary.error(&document) {
                self.complain(text, (!only).then_some((of, document.as_str())), span, out);
            }
            let mut found = Vec::new();
            for q in queries {
                let node = self.dictionary.find(&document, q);
                found.push((q.clone(), self.shader.emit_constant(Const::Int(node), span, out)));
            }
            options.push((document, self.choose(query, found, Ty::Int, span, out)));
        }
        self.choose(of, options, Ty::Int, span, out)
    }

    /// Prints an error, as the reference does the first time that it meets the document.
    fn complain(&mut self, text: String, when: Option<(ValueId, &str)>, span: Span, out: &mut Block) {
        let Some(func) = builtins::find("print") else { return };
        let mut block = Block::default();
        let code = self.shader.emit_constant(Const::Int(code::RUNTIME), span, &mut block);
        let parts = ["", "%s", &text].map(|s| self.shader.emit_constant(Const::Str(s.to_owned()), span, &mut block));
        let args = [code, parts[0], parts[1], parts[2]].map(Arg::Value).to_vec();
        block.stmts.push(Stmt::Call { func, args, outputs: Vec::new(), result: None, span });
        if let Some(index) = builtins::find("shading_index").filter(|_| self.grid) {
            let mut test = Block::default();
            let index = self.shader.emit(Inst::Call(index, Vec::new()), Ty::Int, span, &mut test);
            let later = self.shader.emit_constant(Const::Int(0), span, &mut test);
            let first = self.shader.emit(Inst::Binary(BinaryOp::Eq, index, later), Ty::Int, span, &mut test);
            test.stmts.push(Stmt::If(first, block, Block::default()));
            block = test;
        }
        if let Some((of, document)) = when {
            let text = self.shader.emit_constant(Const::Str(document.to_owned()), span, out);
            let same = self.shader.emit(Inst::Binary(BinaryOp::Eq, of, text), Ty::Int, span, out);
            out.stmts.push(Stmt::If(same, block, Block::default()));
        } else {
            out.stmts.append(&mut block.stmts);
        }
    }

    fn get(&mut self, args: &[Arg], outputs: &[LocalId], result: Option<LocalId>, span: Span, out: &mut Block) {
        let ([Arg::Value(node), Arg::Value(name), Arg::Value(ty)], [output], Some(result)) = (args, outputs, result)
        else {
            return;
        };
        let Inst::Const(Const::Str(ty)) = self.shader.values[ty.0 as usize].inst.clone() else { return };
        let zero = self.shader.emit_constant(Const::Int(0), span, out);
        out.stmts.push(Stmt::Store(result, zero));
        let names = self.texts(args.get(1)).unwrap_or_default();
        let only = names.len() == 1;
        let target = self.shader.locals[output.0 as usize].clone();
        for attribute in names {
            let has = self.table(Table::Has(attribute.clone(), ty.clone()), span);
            let mut has = self.shader.emit(Inst::LoadElem(has, *node), Ty::Int, span, out);
            if !only {
                let text = self.shader.emit_constant(Const::Str(attribute.clone()), span, out);
                let same = self.shader.emit(Inst::Binary(BinaryOp::Eq, *name, text), Ty::Int, span, out);
                has = self.shader.emit(Inst::Binary(BinaryOp::BitAnd, has, same), Ty::Int, span, out);
            }
            let table = self.table(Table::Value(attribute, ty.clone()), span);
            let mut then = Block::default();
            match target.len {
                None => {
                    let value = self.shader.emit(Inst::LoadElem(table, *node), target.ty, span, &mut then);
                    then.stmts.push(Stmt::Store(*output, value));
                }
                Some(len) => {
                    let width = self.shader.emit_constant(Const::Int(len as i32), span, &mut then);
                    let first = self.shader.emit(Inst::Binary(BinaryOp::Mul, *node, width), Ty::Int, span, &mut then);
                    for k in 0..len as i32 {
                        let k = self.shader.emit_constant(Const::Int(k), span, &mut then);
                        let at = self.shader.emit(Inst::Binary(BinaryOp::Add, first, k), Ty::Int, span, &mut then);
                        let value = self.shader.emit(Inst::LoadElem(table, at), target.ty, span, &mut then);
                        then.stmts.push(Stmt::StoreElem(*output, k, value));
                    }
                }
            }
            let one = self.shader.emit_constant(Const::Int(1), span, &mut then);
            then.stmts.push(Stmt::Store(result, one));
            out.stmts.push(Stmt::If(has, then, Block::default()));
        }
    }

    /// A table by node; its last place is that of every number beyond the nodes.
    fn table(&mut self, table: Table, span: Span) -> LocalId {
        if let Some((_, local)) = self.tables.iter().find(|(t, _)| *t == table) {
            return *local;
        }
        let mut items = Vec::new();
        for node in 0..=self.dictionary.count() + 1 {
            match &table {
                Table::Next => items.push(Const::Int(self.dictionary.next(node))),
                Table::From(query) => items.push(Const::Int(self.dictionary.find_from(node, query))),
                Table::Has(name, ty) => {
                    let has = self.dictionary.value(node, name).is_some_and(|text| converted(text, ty).is_some());
                    items.push(Const::Int(i32::from(has)));
                }
                Table::Value(name, ty) => {
                    let text = self.dictionary.value(node, name).unwrap_or("");
                    items.extend(converted(text, ty).unwrap_or_else(|| vec![Const::Int(0)]));
                }
            }
        }
        let ty = items.first().and_then(Const::ty).unwrap_or(Ty::Int);
        let len = Some(items.len() as u32);
        let local = self.shader.add_variable("dictionary".to_owned(), ty, len);
        let mut head = std::mem::take(&mut self.head);
        for (i, item) in items.into_iter().enumerate() {
            let index = self.shader.emit_constant(Const::Int(i as i32), span, &mut head);
            let item = self.shader.emit_constant(item, span, &mut head);
            head.stmts.push(Stmt::StoreElem(local, index, item));
        }
        self.head = head;
        self.tables.push((table, local));
        local
    }
}

/// A text as the elements of a type in OSL's words; `None` when there is no way.
fn converted(text: &str, ty: &str) -> Option<Vec<Const>> {
    let (base, len) = match ty.trim_end_matches(']').split_once('[') {
        Some((base, len)) => (base, len.parse::<usize>().ok()?),
        None => (ty, 1),
    };
    Some(match base {
        "string" if len == 1 => vec![Const::Str(text.to_owned())],
        "int" => numbers(text, len).into_iter().map(|v| Const::Int(v as i32)).collect(),
        "float" => numbers(text, len).into_iter().map(Const::Float).collect(),
        "color" | "point" | "vector" | "normal" => {
            numbers(text, 3 * len).chunks_exact(3).map(|v| Const::Triple([v[0], v[1], v[2]])).collect()
        }
        "matrix" => {
            let matrices = numbers(text, 16 * len);
            let matrix = |m: &[f64]| m.try_into().ok().map(Const::Matrix);
            matrices.chunks_exact(16).map(matrix).collect::<Option<Vec<_>>>()?
        }
        _ => return None,
    })
}
