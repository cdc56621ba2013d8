//! Traced rays: `trace`, and `getmessage` of what the last of them met.
//!
//! In: folded IR before `dialogue`. Out: the same without `trace_call` and without messages from "trace". Each call becomes one
//! of a function of the renderer's: that of the nearest surface where some message is read that only it can tell, else whether
//! anything is met at all. What it met last is kept in variables, which all layers of a group share, as in the reference.
//! [`traces`] lists what the renderer has to know for the calls that are left. Names must be constants.

use super::Rays;
use super::review::add;
use super::strings::Strings;
use crate::builtins::{self, FuncId};
use crate::diag::Diagnostic;
use crate::ir::{
    Arg, BinaryOp, Block, Const, Global, Inst, Local, LocalId, LocalKind, Rewriter, Shader, Stmt, Ty, ValueId,
};
use crate::source::Span;
use crate::suggest;
use std::collections::BTreeSet;

/// What can be asked of the surface that was met: names and types in OSL's words, in the order of `trace_nearest`'s outputs.
pub(super) const FACTS: [(&str, &str, Ty); 10] = [
    ("hitdist", "float", Ty::Float),
    ("P", "point", Ty::Triple),
    ("N", "normal", Ty::Triple),
    ("Ng", "normal", Ty::Triple),
    ("I", "vector", Ty::Triple),
    ("dPdu", "vector", Ty::Triple),
    ("dPdv", "vector", Ty::Triple),
    ("u", "float", Ty::Float),
    ("v", "float", Ty::Float),
    ("geom:name", "string", Ty::Str),
];

/// What a shader asks of traced rays.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Traces {
    /// Whether it traces rays at all.
    pub calls: bool,
    /// What it asks of the surfaces that rays meet, by the names of messages (`P`, `geom:name`), in a fixed order.
    pub asked: Vec<String>,
    /// The sets of objects that it traces, each once, sorted; not the set of all.
    pub sets: Vec<String>,
}

impl Traces {
    /// Whether it asks for nothing.
    pub fn is_empty(&self) -> bool {
        !self.calls
    }
}

/// Reads a shader after all passes. A set that is none of a known choice is an error.
pub fn traces(shader: &Shader) -> Result<Traces, Vec<Diagnostic>> {
    let mut found = Traces::default();
    let mut sets: Vec<(ValueId, Span)> = Vec::new();
    let mut outputs: Vec<LocalId> = Vec::new();
    let mut read = BTreeSet::new();
    let set_of = |args: &[Arg]| match args.last() {
        Some(Arg::Value(v)) => Some(*v),
        _ => None,
    };
    for block in shader.blocks() {
        block.walk(&mut |s| match s {
            Stmt::Let(id) => {
                let value = &shader.values[id.0 as usize];
                value.inst.locals(&mut |l| _ = read.insert(l));
                if let Inst::Call(func, args) = &value.inst
                    && builtins::row(*func).name == "trace_any"
                {
                    sets.extend(set_of(args).map(|v| (v, value.span)));
                }
            }
            Stmt::Call { func, args, outputs: to, span, .. } if builtins::row(*func).name == "trace_nearest" => {
                sets.extend(set_of(args).map(|v| (v, *span)));
                outputs.extend(to);
            }
            _ => {}
        });
    }
    found.calls = !sets.is_empty();
    let facts = FACTS.iter().enumerate();
    let is_read = |place: usize| outputs.chunks(FACTS.len()).any(|to| to.get(place).is_some_and(|l| read.contains(l)));
    found.asked = facts.filter(|(i, _)| is_read(*i)).map(|(_, (name, ..))| (*name).to_owned()).collect();
    let strings = Strings::of(shader);
    let mut names = BTreeSet::new();
    let mut errors = Vec::new();
    for (set, span) in sets {
        match strings.trace(shader, vec![set], Vec::new()) {
            Some(texts) => names.extend(texts),
            None => {
                let what = "a set of `trace` that is not known at compile time";
                let d = Diagnostic::not_yet("E3003", span, what);
                add(&mut errors, d.help("choose among constants, by parameters or conditions"));
            }
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    found.sets = names.into_iter().filter(|n| !n.is_empty()).collect();
    Ok(found)
}

/// Carries the calls out; what is to be said about them is returned.
pub(super) fn answer(shader: &mut Shader, rays: Rays) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let (Some(call), Some(get)) = (builtins::find("trace_call"), builtins::find("message_get")) else {
        return Ok(Vec::new());
    };
    let (mut any, mut asks) = (false, Vec::new());
    let mut errors = Vec::new();
    for block in shader.blocks() {
        block.walk(&mut |s| match s {
            Stmt::Call { func, .. } if *func == call => any = true,
            Stmt::Call { func, args, span, .. } if *func == get && text(shader, args, 0) == Some("trace") => {
                match text(shader, args, 1) {
                    Some(name) => asks.push(name.to_owned()),
                    None => {
                        let what = "a name of what a ray met that is not known at compile time";
                        let d = Diagnostic::not_yet("E3003", *span, what);
                        add(&mut errors, d.help("choose the name by a parameter, or ask for one name each"));
                    }
                }
            }
            _ => {}
        });
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    if !any && asks.is_empty() {
        return Ok(Vec::new());
    }
    let nearest = asks.iter().any(|a| a != "hit");
    let state = shader.add_variable("traced".to_owned(), Ty::Int, None);
    let facts = match nearest && rays == Rays::Scene {
        true => FACTS.iter().map(|(name, _, ty)| shader.add_variable(format!("met_{name}"), *ty, None)).collect(),
        false => Vec::new(),
    };
    let mut answers = Answers { shader, rays, call, get, state, facts, warnings: Vec::new() };
    answers.rewrite();
    Ok(answers.warnings)
}

/// The text of an argument that is a constant.
fn text<'a>(shader: &'a Shader, args: &[Arg], at: usize) -> Option<&'a str> {
    match args.get(at) {
        Some(Arg::Value(v)) => match &shader.values[v.0 as usize].inst {
            Inst::Const(Const::Str(s)) => Some(s),
            _ => None,
        },
        _ => None,
    }
}

struct Answers<'a> {
    shader: &'a mut Shader,
    rays: Rays,
    call: FuncId,
    get: FuncId,
    /// 0: no ray yet, 1: the last one met nothing, 2: it met something.
    state: LocalId,
    /// Of the last ray, as [`FACTS`]; empty where nobody asks.
    facts: Vec<LocalId>,
    warnings: Vec<Diagnostic>,
}

impl Rewriter for Answers<'_> {
    fn shader(&mut self) -> &mut Shader {
        self.shader
    }

    fn stmt(&mut self, stmt: Stmt, out: &mut Block) {
        match stmt {
            Stmt::Call { func, args, result, span, .. } if func == self.call => self.trace(&args, result, span, out),
            Stmt::Call { func, args, outputs, result, span }
                if func == self.get && text(self.shader, &args, 0) == Some("trace") =>
            {
                let (Some(output), Some(result)) = (outputs.first(), result) else { return };
                let zero = self.int(0, span, out);
                out.stmts.push(Stmt::Store(result, zero));
                let name = text(self.shader, &args, 1).unwrap_or_default().to_owned();
                let ty = text(self.shader, &args, 2).unwrap_or_default().to_owned();
                let ask = Ask { name, ty, output: *output, result, span };
                match self.rays {
                    Rays::Pretended => self.pretend(&ask, out),
                    Rays::Scene | Rays::Nothing => self.tell(&ask, out),
                }
            }
            other => out.stmts.push(other),
        }
    }
}

/// A call of `getmessage`.
struct Ask {
    name: String,
    ty: String,
    output: LocalId,
    result: LocalId,
    span: Span,
}

impl Answers<'_> {
    fn int(&mut self, v: i32, span: Span, out: &mut Block) -> ValueId {
        self.shader.emit_constant(Const::Int(v), span, out)
    }

    fn binary(&mut self, op: BinaryOp, a: ValueId, b: ValueId, span: Span, out: &mut Block) -> ValueId {
        self.shader.emit(Inst::Binary(op, a, b), Ty::Int, span, out)
    }

    fn warn(&mut self, span: Span, message: String, help: &str) {
        add(&mut self.warnings, Diagnostic::warning("W3003", span, message).help(help));
    }

    /// `args`: from, direction, nearest, farthest, shade, set.
    fn trace(&mut self, args: &[Arg], result: Option<LocalId>, span: Span, out: &mut Block) {
        let hit = match self.rays {
            Rays::Pretended => self.function("trace_hit", args[..2].to_vec(), span, out),
            Rays::Nothing => {
                let message = "`trace` finds nothing in a shader that runs before the scene is built";
                self.warn(span, message.to_owned(), "displacement shaders make the surfaces that rays could meet");
                self.int(0, span, out)
            }
            Rays::Scene => {
                self.shading(&args[4], span);
                let mut list = args[..4].to_vec();
                list.push(args[5]);
                self.ray(list, span, out)
            }
        };
        if let Some(result) = result {
            out.stmts.push(Stmt::Store(result, hit));
        }
        let one = self.int(1, span, out);
        let state = self.binary(BinaryOp::Add, hit, one, span, out);
        out.stmts.push(Stmt::Store(self.state, state));
    }

    /// A call of a row without outputs.
    fn function(&mut self, name: &str, args: Vec<Arg>, span: Span, out: &mut Block) -> ValueId {
        match builtins::find(name) {
            Some(func) => self.shader.emit(Inst::Call(func, args), Ty::Int, span, out),
            None => self.int(0, span, out),
        }
    }

    /// Whether a ray of a scene meets something.
    fn ray(&mut self, args: Vec<Arg>, span: Span, out: &mut Block) -> ValueId {
        let Some(func) = builtins::find("trace_nearest").filter(|_| !self.facts.is_empty()) else {
            return self.function("trace_any", args, span, out);
        };
        let hit = self.shader.add_variable("met".to_owned(), Ty::Int, None);
        out.stmts.push(Stmt::Call { func, args, outputs: self.facts.clone(), result: Some(hit), span });
        self.shader.emit(Inst::Load(hit), Ty::Int, span, out)
    }

    /// Tells of an option that wants shaders run on what rays meet.
    fn shading(&mut self, shade: &Arg, span: Span) {
        let Arg::Value(v) = shade else { return };
        if !matches!(self.shader.values[v.0 as usize].inst, Inst::Const(Const::Int(0))) {
            let message = "`trace` does not run the shader of what it meets: \"shade\" counts as 0";
            self.warn(span, message.to_owned(), "`getmessage(\"trace\", ...)` knows geometry alone");
        }
    }

    /// A message about the last ray of a scene.
    fn tell(&mut self, ask: &Ask, out: &mut Block) {
        let known = FACTS.iter().position(|(name, ..)| *name == ask.name);
        let declared = if ask.name == "hit" { Some("int") } else { known.map(|k| FACTS[k].1) };
        let Some(declared) = declared else {
            let names: Vec<&str> = ["hit"].into_iter().chain(FACTS.iter().map(|f| f.0)).collect();
            let message =
                format!("nothing named \"{}\" is known of what `trace` meets: its shader does not run", ask.name);
            let help = suggest::known_names(&ask.name, &names);
            add(&mut self.warnings, Diagnostic::warning("W3003", ask.span, message).help(help));
            return;
        };
        if declared != ask.ty {
            let message = format!("\"{}\" of what `trace` meets is {}, not {}", ask.name, a(declared), a(&ask.ty));
            self.warn(ask.span, message, "as the reference implementation has it, `getmessage` then finds nothing");
            return;
        }
        let state = self.shader.emit(Inst::Load(self.state), Ty::Int, ask.span, out);
        let least = self.int(if known.is_some() { 2 } else { 1 }, ask.span, out);
        let there = self.binary(BinaryOp::Ge, state, least, ask.span, out);
        let mut then = Block::default();
        let value = match known.and_then(|k| self.facts.get(k).copied()) {
            Some(fact) => {
                let ty = self.shader.locals[fact.0 as usize].ty;
                Some(self.shader.emit(Inst::Load(fact), ty, ask.span, &mut then))
            }
            None if known.is_none() => {
                let one = self.int(1, ask.span, &mut then);
                Some(self.binary(BinaryOp::Sub, state, one, ask.span, &mut then))
            }
            // Nothing is ever met.
            None => None,
        };
        then.stmts.extend(value.map(|v| Stmt::Store(ask.output, v)));
        let one = self.int(1, ask.span, &mut then);
        then.stmts.push(Stmt::Store(ask.result, one));
        out.stmts.push(Stmt::If(there, then, Block::default()));
    }

    /// The answers of the reference's testshade: where u > 0.5 there is a teapot.
    fn pretend(&mut self, ask: &Ask, out: &mut Block) {
        let span = ask.span;
        let u = self.global(Global::U, span, out);
        let half = self.shader.emit_constant(Const::Float(0.5), span, out);
        let there = self.binary(BinaryOp::Gt, u, half, span, out);
        let (mut then, mut rest) = (Block::default(), Block::default());
        let value = match (ask.name.as_str(), ask.ty.as_str()) {
            ("hitdist", "float") => Some(half),
            ("hit", "int") => Some(self.int(1, span, &mut then)),
            ("geom:name", "string") => {
                Some(self.shader.emit_constant(Const::Str("teapot".to_owned()), span, &mut then))
            }
            ("N", "normal") => {
                let v = self.global(Global::V, span, &mut then);
                let one = self.shader.emit_constant(Const::Float(1.0), span, &mut then);
                let quarter = self.shader.emit_constant(Const::Float(0.25), span, &mut then);
                let [x, z] =
                    [v, u].map(|c| self.shader.emit(Inst::Binary(BinaryOp::Sub, one, c), Ty::Float, span, &mut then));
                Some(self.shader.emit(Inst::Triple([x, quarter, z]), Ty::Triple, span, &mut then))
            }
            _ => None,
        };
        then.stmts.extend(value.map(|v| Stmt::Store(ask.output, v)));
        let one = self.int(1, span, &mut then);
        then.stmts.push(Stmt::Store(ask.result, one));
        if ask.name == "hit" && ask.ty == "int" {
            let zero = self.int(0, span, &mut rest);
            rest.stmts.push(Stmt::Store(ask.output, zero));
        }
        out.stmts.push(Stmt::If(there, then, rest));
    }

    /// The value of a global.
    fn global(&mut self, global: Global, span: Span, out: &mut Block) -> ValueId {
        let kind = LocalKind::Global(global);
        let at = self.shader.locals.iter().position(|l| l.kind == kind).unwrap_or_else(|| {
            self.shader.locals.push(Local { name: global.name().to_owned(), ty: Ty::Float, len: None, kind });
            self.shader.locals.len() - 1
        });
        self.shader.emit(Inst::Load(LocalId(at as u32)), Ty::Float, span, out)
    }
}

/// A type with its article.
fn a(ty: &str) -> String {
    format!("{} {ty}", if ty.starts_with('i') { "an" } else { "a" })
}
