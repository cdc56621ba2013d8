//! Functions of strings that are a choice among constants: one result per case.
//!
//! In: folded IR. Out: calls that only the host can carry out, on strings, ints and other values that can be so and so many
//! constants, have become choices among the results of the cases. What has too many cases stays as it is.

use super::Settings;
use super::numbers::Numbers;
use super::strings::Strings;
use crate::attributes::{Attributes, Question};
use crate::builtins::{self, FuncId, Lowering};
use crate::diag::Diagnostic;
use crate::interp;
use crate::ir::{
    Arg, BinaryOp, Block, Const, Input, Inst, Local, LocalId, LocalKind, Rewriter, Shader, Source, Stmt, Ty, Value,
    ValueId,
};
use crate::source::Span;
use crate::types::{Base, Extent, Type};

/// Most cases of a call.
const MAX_CASES: usize = 1024;

/// Most elements written by all cases of a call together.
const MAX_ELEMENTS: usize = 1024;

/// Rewrites what it can; whether there was anything.
pub(super) fn cases(shader: &mut Shader, settings: &Settings<'_>) -> Result<bool, Vec<Diagnostic>> {
    if !shader.values.iter().any(|v| matches!(&v.inst, Inst::Call(f, _) if is_host(*f))) && !has_statements(shader) {
        return Ok(false);
    }
    let strings = Strings::of_types(shader, &|ty| !matches!(ty, Ty::Int | Ty::Closure));
    let mut cases =
        Cases { strings, numbers: Numbers::of(shader), shader, settings, changed: false, errors: Vec::new() };
    cases.rewrite();
    if cases.errors.is_empty() { Ok(cases.changed) } else { Err(cases.errors) }
}

fn is_host(func: FuncId) -> bool {
    matches!(builtins::row(func).lowering, Lowering::Host | Lowering::InternalHost)
        && builtins::row(func).name != "unknown_name"
}

fn has_statements(shader: &Shader) -> bool {
    let mut found = false;
    for block in shader.blocks() {
        block.walk(&mut |s| found |= matches!(s, Stmt::Call { func, .. } if is_host(*func)));
    }
    found
}

struct Cases<'a> {
    strings: Strings,
    numbers: Numbers,
    shader: &'a mut Shader,
    settings: &'a Settings<'a>,
    changed: bool,
    errors: Vec<Diagnostic>,
}

/// An argument: the value that tells the case, and what it can be. A constant has one case and needs no telling.
type Choice = (Option<ValueId>, Vec<Const>);

impl Rewriter for Cases<'_> {
    fn shader(&mut self) -> &mut Shader {
        self.shader
    }

    fn stmt(&mut self, stmt: Stmt, out: &mut Block) {
        match stmt {
            Stmt::Let(id) => {
                self.value(id, out);
                out.stmts.push(Stmt::Let(id));
            }
            Stmt::Call { func, ref args, ref outputs, result: Some(result), span } if is_host(func) => {
                match self.statement(func, args, outputs, result, span, out) {
                    Some(()) => self.changed = true,
                    None => out.stmts.push(stmt),
                }
            }
            other => out.stmts.push(other),
        }
    }
}

impl Cases<'_> {
    /// What each argument can be; `None` when there are too many cases, or unknown ones.
    fn choices(&mut self, func: FuncId, args: &[Arg], span: Span, out: &mut Block) -> Option<Vec<Choice>> {
        let mut total = 1;
        let mut choices: Vec<Choice> = Vec::with_capacity(args.len());
        for (at, arg) in args.iter().enumerate() {
            let Arg::Value(v) = arg else { return None };
            let value = &self.shader.values[v.0 as usize];
            let ty = value.ty;
            let choice = match &value.inst {
                Inst::Const(c) => (None, vec![c.clone()]),
                _ => match self.can_be(*v, ty) {
                    Some(constants) => (Some(*v), constants),
                    None if ty == Ty::Int => self.position(func, &choices, at, *v, span, out)?,
                    None => return None,
                },
            };
            total *= choice.1.len();
            if total == 0 || total > MAX_CASES {
                return None;
            }
            choices.push(choice);
        }
        Some(choices)
    }

    /// Any int, as a position or a length in texts that are known: those beyond the longest count as the nearest that does not
    /// differ from them.
    fn position(
        &mut self,
        func: FuncId,
        before: &[Choice],
        at: usize,
        v: ValueId,
        span: Span,
        out: &mut Block,
    ) -> Option<Choice> {
        let length = |c: &Const| if let Const::Str(s) = c { i32::try_from(s.len()).ok() } else { None };
        let longest = before.first()?.1.iter().map(length).try_fold(0, |longest, n| Some(longest.max(n?)))?;
        let (low, high) = match (builtins::row(func).name, at) {
            ("substr", 1) => (-longest, longest),
            ("substr", 2) => (0, longest),
            ("getchar", 1) => (-1, longest),
            _ => return None,
        };
        if (i64::from(high) - i64::from(low)) >= MAX_CASES as i64 {
            return None;
        }
        let [lowest, highest] = [low, high].map(|n| self.shader.emit_constant(Const::Int(n), span, out));
        let below = self.shader.emit(Inst::Binary(BinaryOp::Lt, v, lowest), Ty::Int, span, out);
        let raised = self.shader.emit(Inst::Select(below, lowest, v), Ty::Int, span, out);
        let above = self.shader.emit(Inst::Binary(BinaryOp::Gt, raised, highest), Ty::Int, span, out);
        let inside = self.shader.emit(Inst::Select(above, highest, raised), Ty::Int, span, out);
        Some((Some(inside), (low..=high).map(Const::Int).collect()))
    }

    /// All that a value can be. Floats that are computed are not told apart: the device rounds elsewhere.
    fn can_be(&self, v: ValueId, ty: Ty) -> Option<Vec<Const>> {
        Some(match ty {
            Ty::Str => self.strings.trace(self.shader, vec![v], Vec::new())?.into_iter().map(Const::Str).collect(),
            Ty::Int => self.numbers.few(self.shader, v)?.into_iter().map(Const::Int).collect(),
            Ty::Float | Ty::Triple => self.strings.constants(self.shader, vec![v], Vec::new())?,
            Ty::Matrix | Ty::Closure => return None,
        })
    }

    fn value(&mut self, id: ValueId, out: &mut Block) {
        let Value { inst: Inst::Call(func, args), ty, span } = &self.shader.values[id.0 as usize] else { return };
        let (func, ty, span) = (*func, *ty, *span);
        if !is_host(func) {
            return;
        }
        let args = args.clone();
        let Some(choices) = self.choices(func, &args, span, out) else { return };
        let mut results = Vec::new();
        if !each_case(&choices, &mut |case| interp::fold_call(func, ty, case).map(|c| results.push(c)).is_some()) {
            return;
        }
        let mut results = results.into_iter();
        let inst = self.select(&choices, &mut results, ty, span, out);
        self.shader.values[id.0 as usize].inst = inst;
        self.changed = true;
    }

    /// The choice among the results, which come in the order of the cases.
    fn select(
        &mut self,
        choices: &[Choice],
        results: &mut dyn Iterator<Item = Const>,
        ty: Ty,
        span: Span,
        out: &mut Block,
    ) -> Inst {
        let Some(((told_by, texts), rest)) = choices.split_first() else {
            return Inst::Const(results.next().unwrap_or(Const::Int(0)));
        };
        let mut branches = Vec::new();
        for _ in texts {
            let inst = self.select(rest, results, ty, span, out);
            branches.push(self.shader.emit(inst, ty, span, out));
        }
        let Some(mut chosen) = branches.pop() else { return Inst::Const(Const::Int(0)) };
        let Some(told_by) = told_by else { return self.shader.values[chosen.0 as usize].inst.clone() };
        for (text, branch) in texts.iter().zip(branches).rev() {
            let same = self.is(*told_by, text, span, out);
            chosen = self.shader.emit(Inst::Select(same, branch, chosen), ty, span, out);
        }
        self.shader.values[chosen.0 as usize].inst.clone()
    }

    fn is(&mut self, value: ValueId, text: &Const, span: Span, out: &mut Block) -> ValueId {
        let text = self.shader.emit_constant(text.clone(), span, out);
        self.shader.emit(Inst::Binary(BinaryOp::Eq, value, text), Ty::Int, span, out)
    }

    /// Answers a question for the number of the point, which only the device knows.
    fn asks_for_index(
        &mut self,
        func: FuncId,
        choices: &[Choice],
        output: LocalId,
        result: LocalId,
        span: Span,
        out: &mut Block,
    ) -> bool {
        let is = |i: usize, text: &str| {
            choices.get(i).is_some_and(|(_, texts)| matches!(texts.as_slice(), [Const::Str(s)] if s == text))
        };
        let asked = builtins::row(func).name == "attribute_get" && is(0, "") && is(1, "shading:index") && is(3, "int");
        let Some(func) = builtins::find("shading_index").filter(|_| asked && self.settings.grid) else { return false };
        let index = self.shader.emit(Inst::Call(func, Vec::new()), Ty::Int, span, out);
        out.stmts.push(Stmt::Store(output, index));
        let one = self.shader.emit_constant(Const::Int(1), span, out);
        out.stmts.push(Stmt::Store(result, one));
        true
    }

    /// Answers a question for an attribute that differs from object to object by userdata.
    fn asks_the_object(
        &mut self,
        func: FuncId,
        choices: &[Choice],
        output: LocalId,
        result: LocalId,
        span: Span,
        out: &mut Block,
    ) -> bool {
        let Some(known) = self.settings.attributes else { return false };
        if known.varying.is_empty() && !known.open || builtins::row(func).name != "attribute_get" {
            return false;
        }
        let constants: Option<Vec<&Const>> =
            choices.iter().map(|(by, texts)| texts.first().filter(|_| by.is_none())).collect();
        let Some([Const::Str(object), Const::Str(name), Const::Int(index), Const::Str(asked), ..]) =
            constants.as_deref()
        else {
            return false;
        };
        let bases =
            [Base::Int, Base::Float, Base::Color, Base::Point, Base::Vector, Base::Normal, Base::Matrix, Base::String];
        let keyword = asked.split('[').next().unwrap_or_default();
        let Some(base) = bases.into_iter().find(|b| b.keyword() == keyword) else { return false };
        let unknown = known.open && !crate::attributes::is_own(name);
        if !object.is_empty() || !unknown && !known.varying.contains(name) {
            return false;
        }
        let (ty, len) = (self.shader.locals[output.0 as usize].ty, self.shader.locals[output.0 as usize].len);
        let declared = Type { base, extent: len.map_or(Extent::Scalar, Extent::Fixed) };
        let values = match known.values_of(name, ty) {
            Some(values) if *index < 0 && len.is_none() && values.len() <= MAX_CASES => values.to_vec(),
            _ => Vec::new(),
        };
        let name = crate::attributes::userdata_name(name, *index, asked);
        let value = self.input(&name, Source::Userdata, declared, ty, len);
        let flag = self.input(&name, Source::HasUserdata, Type::scalar(Base::Int), Ty::Int, None);
        let has = self.shader.emit(Inst::Load(flag), Ty::Int, span, out);
        let mut then = Block::default();
        if len.is_some() {
            then.stmts.push(Stmt::CopyArray(output, value));
        } else {
            let value = self.shader.emit(Inst::Load(value), ty, span, &mut then);
            let value = self.one_of(value, values, span, &mut then);
            then.stmts.push(Stmt::Store(output, value));
        }
        out.stmts.push(Stmt::If(has, then, Block::default()));
        out.stmts.push(Stmt::Store(result, has));
        true
    }

    /// A value that is one of these, as a choice among them: what is a choice among constants, texts can be made of.
    fn one_of(&mut self, value: ValueId, mut values: Vec<Const>, span: Span, out: &mut Block) -> ValueId {
        let Some(last) = values.pop() else { return value };
        let ty = self.shader.values[value.0 as usize].ty;
        let mut chosen = self.shader.emit_constant(last, span, out);
        for constant in values.into_iter().rev() {
            let same = self.is(value, &constant, span, out);
            let constant = self.shader.emit_constant(constant, span, out);
            chosen = self.shader.emit(Inst::Select(same, constant, chosen), ty, span, out);
        }
        chosen
    }

    /// Refuses a question that only the scene could answer where it is not known yet.
    fn refuse_open(&mut self, func: FuncId, choices: &[Choice], span: Span) {
        if !self.settings.attributes.is_some_and(|a| a.open) || builtins::row(func).name != "attribute_get" {
            return;
        }
        let own = |c: &Const| matches!(c, Const::Str(name) if crate::attributes::is_own(name));
        if choices.get(1).is_some_and(|(_, names)| names.iter().all(own)) {
            return;
        }
        let what = "an attribute of a named object, or of a name that is chosen while the shader runs, where the scene is not known";
        let d = Diagnostic::not_yet("E3003", span, what).help("ask without an object, by a constant name");
        if !self.errors.contains(&d) {
            self.errors.push(d);
        }
    }

    /// The local of an input; the same question has the same one.
    fn input(&mut self, name: &str, source: Source, declared: Type, ty: Ty, len: Option<u32>) -> LocalId {
        let found = self.shader.inputs.iter().position(|i| i.name == name && i.source == source);
        let index = found.unwrap_or_else(|| {
            self.shader.inputs.push(Input { name: name.to_owned(), source, declared, ty, len, default: None });
            self.shader.inputs.len() - 1
        });
        let kind = LocalKind::Input(index as u32);
        let local = self.shader.locals.iter().position(|l| l.kind == kind).unwrap_or_else(|| {
            self.shader.locals.push(Local { name: "attribute".to_owned(), ty, len, kind });
            self.shader.locals.len() - 1
        });
        LocalId(local as u32)
    }

    /// A call that writes to an array: a branch per case.
    fn statement(
        &mut self,
        func: FuncId,
        args: &[Arg],
        outputs: &[LocalId],
        result: LocalId,
        span: Span,
        out: &mut Block,
    ) -> Option<()> {
        let [output] = outputs else { return None };
        let room = self.shader.locals[output.0 as usize].len.unwrap_or(1) as usize;
        let choices = self.choices(func, args, span, out)?;
        if self.asks_for_index(func, &choices, *output, result, span, out) {
            return Some(());
        }
        if self.asks_the_object(func, &choices, *output, result, span, out) {
            return Some(());
        }
        let chosen = choices.iter().any(|(by, _)| by.is_some());
        self.refuse_open(func, &choices, span);
        let settings = self.settings;
        let mut results = Vec::new();
        let mut elements = 0;
        let all = each_case(&choices, &mut |case| {
            let done = match builtins::row(func).name {
                "attribute_get" => attribute(settings.attributes, case, chosen),
                _ => interp::fold_call_with_output(func, case, room),
            };
            let Some(done) = done else { return false };
            elements += done.0.len();
            results.push(done);
            elements <= MAX_ELEMENTS
        });
        if !all {
            return None;
        }
        let mut results = results.into_iter();
        self.branches(&choices, &mut results, (*output, result), span, out);
        Some(())
    }

    fn branches(
        &mut self,
        choices: &[Choice],
        results: &mut dyn Iterator<Item = (Vec<Const>, Const)>,
        targets: (LocalId, LocalId),
        span: Span,
        out: &mut Block,
    ) {
        let Some(((told_by, texts), rest)) = choices.split_first() else {
            let Some((elements, value)) = results.next() else { return };
            let single = self.shader.locals[targets.0.0 as usize].len.is_none();
            for (i, element) in elements.into_iter().enumerate() {
                if single {
                    let element = self.shader.emit_constant(element, span, out);
                    out.stmts.push(Stmt::Store(targets.0, element));
                    continue;
                }
                let index = self.shader.emit_constant(Const::Int(i as i32), span, out);
                let element = self.shader.emit_constant(element, span, out);
                out.stmts.push(Stmt::StoreElem(targets.0, index, element));
            }
            let value = self.shader.emit_constant(value, span, out);
            return out.stmts.push(Stmt::Store(targets.1, value));
        };
        let mut blocks = Vec::new();
        for _ in texts {
            let mut block = Block::default();
            self.branches(rest, results, targets, span, &mut block);
            blocks.push(block);
        }
        let Some(mut chosen) = blocks.pop() else { return };
        if let Some(told_by) = told_by {
            for (text, block) in texts.iter().zip(blocks).rev() {
                let mut test = Block::default();
                let same = self.is(*told_by, text, span, &mut test);
                test.stmts.push(Stmt::If(same, block, chosen));
                chosen = test;
            }
        }
        out.stmts.extend(chosen.stmts);
    }
}

/// The answer of `attribute_get`. As in the reference, a shader's own names are known only where what is asked for is no
/// choice (`chosen`).
fn attribute(attributes: Option<&Attributes>, args: &[Const], chosen: bool) -> Option<(Vec<Const>, Const)> {
    use Const::{Int, Str};
    let [Str(object), Str(name), Int(index), Str(ty), shader, layer, group] = args else { return None };
    let own = match name.as_str() {
        "shader:shadername" => Some(shader),
        "shader:layername" => Some(layer),
        "shader:groupname" => Some(group),
        _ => None,
    };
    let question = Question { object, name, index: *index, ty };
    let found = match own {
        Some(text) => (ty == "string" && !chosen).then(|| vec![text.clone()]),
        None => attributes.map_or_else(|| Attributes::default().find(&question), |a| a.find(&question)),
    };
    Some(match found {
        Some(elements) => (elements, Int(1)),
        None => (Vec::new(), Int(0)),
    })
}

/// Calls `see` on the arguments of each case, the last argument changing fastest, until it says no; whether it never did.
fn each_case(choices: &[Choice], see: &mut dyn FnMut(&[Const]) -> bool) -> bool {
    fn go(choices: &[Choice], case: &mut Vec<Const>, see: &mut dyn FnMut(&[Const]) -> bool) -> bool {
        let Some(((_, texts), rest)) = choices.split_first() else { return see(case) };
        texts.iter().all(|text| {
            case.push(text.clone());
            let on = go(rest, case, see);
            case.pop();
            on
        })
    }
    go(choices, &mut Vec::new(), see)
}
