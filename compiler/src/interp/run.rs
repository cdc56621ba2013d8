//! Executes a shader: parameters' inits, then the body.
//!
//! In: a verified shader without closure values (after `passes::optimise`), and [`Globals`]. Out: what its locals hold at
//! the end. It recurses as deep as blocks nest. IR that is not as verified gives an error, never a panic.

use super::{Globals, call, call_with_outputs, ops, points, state, texture};
use crate::builtins;
use crate::ir::{Arg, Block, Const, Inst, LocalId, LocalKind, Loop, Shader, SlotArg, Stmt, Ty, ValueId};
use crate::messages::{self, Kind};
use crate::text;

/// Turns of all loops together before a run is given up.
pub const MAX_TURNS: u64 = 1_000_000;

/// Why a run has no outcome.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// It went on for too long.
    #[error("shader `{shader}` does not end within {MAX_TURNS} turns of its loops")]
    Endless {
        /// Its name.
        shader: String,
    },
    /// Nobody here knows the function.
    #[error("shader `{shader}` calls `{function}`, which the interpreter does not have for these arguments")]
    Unknown {
        /// Its name.
        shader: String,
        /// The built-in.
        function: String,
    },
    /// Closure values, or IR that is not as verified.
    #[error("shader `{shader}` holds {what}, which the interpreter does not run")]
    Malformed {
        /// Its name.
        shader: String,
        /// What.
        what: &'static str,
    },
}

/// A lobe slot at the end of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Slot {
    /// Its weight in Ci.
    pub weight: [f64; 3],
    /// One per formal argument.
    pub args: Vec<Const>,
}

/// What a run leaves behind.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The shader's locals, in order; arrays as [`Const::Array`]. Closures hold an int.
    locals: Vec<Const>,
    /// The shader's lobe slots, in order.
    pub slots: Vec<Slot>,
    /// What it said, in order.
    pub messages: Vec<(Kind, String)>,
}

impl Outcome {
    /// What a local holds.
    pub fn local(&self, local: LocalId) -> Option<&Const> {
        self.locals.get(local.0 as usize)
    }

    /// The sum of the slots' weights.
    pub fn ci(&self) -> [f64; 3] {
        self.slots.iter().fold([0.0; 3], |sum, slot| [0, 1, 2].map(|k| sum[k] + slot.weight[k]))
    }
}

/// How a block ended.
#[derive(PartialEq)]
enum Flow {
    On,
    Break,
    Continue,
}

struct Run<'a> {
    shader: &'a Shader,
    globals: &'a Globals,
    locals: Vec<Const>,
    values: Vec<Option<Const>>,
    turns: u64,
    messages: Vec<(Kind, String)>,
}

/// Runs a shader on one point.
pub fn run(shader: &Shader, globals: &Globals) -> Result<Outcome, Error> {
    // A closure that no pass removed holds an int until something uses it, which is an error.
    let empty = |ty: Ty| ops::zero(ty).unwrap_or(Const::Int(0));
    let input = |index: u32| globals.input(shader.inputs.get(index as usize)?);
    let start = |local: &crate::ir::Local| match (local.kind, local.len) {
        (LocalKind::Input(i), None) => input(i).unwrap_or_else(|| empty(local.ty)),
        (LocalKind::Input(i), Some(len)) => {
            input(i).unwrap_or_else(|| Const::Array(vec![empty(local.ty); len as usize]))
        }
        (LocalKind::Global(g), None) => globals.value(g).unwrap_or_else(|| empty(local.ty)),
        (_, None) => empty(local.ty),
        (_, Some(len)) => Const::Array(vec![empty(local.ty); len as usize]),
    };
    let locals = shader.locals.iter().map(start).collect();
    let mut run =
        Run { shader, globals, locals, values: vec![None; shader.values.len()], turns: 0, messages: Vec::new() };
    for block in shader.blocks() {
        run.block(block)?;
    }
    let mut slots = Vec::with_capacity(shader.slots.len());
    for slot in &shader.slots {
        let Const::Triple(weight) = *run.local(slot.weight)? else {
            return Err(run.malformed("a weight of no triple"));
        };
        let mut args = Vec::with_capacity(slot.args.len());
        for arg in &slot.args {
            args.push(match arg {
                SlotArg::Const(c) => c.clone(),
                SlotArg::Local(l) => run.local(*l)?.clone(),
            });
        }
        slots.push(Slot { weight, args });
    }
    Ok(Outcome { locals: run.locals, slots, messages: run.messages })
}

impl Run<'_> {
    fn malformed(&self, what: &'static str) -> Error {
        Error::Malformed { shader: self.shader.name.clone(), what }
    }

    fn local(&self, local: LocalId) -> Result<&Const, Error> {
        self.locals.get(local.0 as usize).ok_or_else(|| self.malformed("an unknown local"))
    }

    fn local_mut(&mut self, local: LocalId) -> Result<&mut Const, Error> {
        let error = self.malformed("an unknown local");
        self.locals.get_mut(local.0 as usize).ok_or(error)
    }

    fn value(&self, value: ValueId) -> Result<&Const, Error> {
        let known = self.values.get(value.0 as usize).and_then(Option::as_ref);
        known.ok_or_else(|| self.malformed("a value that is used before it is computed"))
    }

    /// The index of an element, clamped.
    fn index(&self, local: LocalId, index: ValueId) -> Result<usize, Error> {
        match (self.local(local)?, self.value(index)?) {
            (Const::Array(items), Const::Int(i)) if !items.is_empty() => Ok(ops::clamp(*i, items.len())),
            _ => Err(self.malformed("an element of no array")),
        }
    }

    fn block(&mut self, block: &Block) -> Result<Flow, Error> {
        for stmt in &block.stmts {
            let flow = self.stmt(stmt)?;
            if flow != Flow::On {
                return Ok(flow);
            }
        }
        Ok(Flow::On)
    }

    fn stmt(&mut self, stmt: &Stmt) -> Result<Flow, Error> {
        match stmt {
            Stmt::Let(v) => {
                let value = self.inst(*v)?;
                self.values[v.0 as usize] = Some(value);
            }
            Stmt::Store(l, v) => *self.local_mut(*l)? = self.value(*v)?.clone(),
            Stmt::StoreElem(l, i, v) => {
                let (i, value) = (self.index(*l, *i)?, self.value(*v)?.clone());
                if let Const::Array(items) = self.local_mut(*l)? {
                    items[i] = value;
                }
            }
            Stmt::CopyArray(to, from) => {
                let source = self.local(*from)?.clone();
                let (Const::Array(source), Const::Array(target)) = (source, self.local_mut(*to)?) else {
                    return Err(self.malformed("a copy of no array"));
                };
                for (to, from) in target.iter_mut().zip(source) {
                    *to = from;
                }
            }
            Stmt::Call { func, args, outputs, result, .. } => {
                let name = builtins::row(*func).name;
                let args = self.args(args)?;
                if name == "print" {
                    let said = messages::said(&args).ok_or_else(|| self.malformed("a message of no kind"))?;
                    self.messages.push(said);
                    return Ok(Flow::On);
                }
                let unknown = || Error::Unknown { shader: self.shader.name.clone(), function: name.to_owned() };
                if let (Some(result), [first, ..]) = (result, outputs.as_slice())
                    && name.starts_with("cloud_")
                {
                    let mut rooms = Vec::with_capacity(outputs.len());
                    for output in outputs {
                        rooms.push(if let Const::Array(items) = self.local(*output)? { items.len() } else { 0 });
                    }
                    let like = if let Const::Array(items) = self.local(*first)? { items.first() } else { None };
                    let access = self.globals.textures.as_ref();
                    let (value, written) = points::call(name, &args, &rooms, like, access).ok_or_else(unknown)?;
                    *self.local_mut(*result)? = value;
                    for (output, elements) in outputs.iter().zip(written) {
                        if let Const::Array(items) = self.local_mut(*output)? {
                            items.iter_mut().zip(elements).for_each(|(to, from)| *to = from);
                        }
                    }
                    return Ok(Flow::On);
                }
                if let (Some(result), [output]) = (result, outputs.as_slice()) {
                    let room = if let Const::Array(items) = self.local(*output)? { items.len() } else { 0 };
                    let (elements, value) = text::call_with_output(name, &args, room).ok_or_else(unknown)?;
                    *self.local_mut(*result)? = value;
                    if let Const::Array(items) = self.local_mut(*output)? {
                        items.iter_mut().zip(elements).for_each(|(to, from)| *to = from);
                    }
                    return Ok(Flow::On);
                }
                let values = call_with_outputs(name, &args).ok_or_else(unknown)?;
                for (output, value) in outputs.iter().zip(values) {
                    *self.local_mut(*output)? = value;
                }
            }
            Stmt::If(cond, a, b) => {
                let taken = if ops::is_true(self.value(*cond)?) { a } else { b };
                return self.block(taken);
            }
            Stmt::Loop(l) => self.loop_(l)?,
            Stmt::Break => return Ok(Flow::Break),
            Stmt::Continue => return Ok(Flow::Continue),
        }
        Ok(Flow::On)
    }

    fn loop_(&mut self, l: &Loop) -> Result<(), Error> {
        loop {
            if !l.tested_after && !self.goes_on(l)? {
                return Ok(());
            }
            if self.block(&l.body)? == Flow::Break {
                return Ok(());
            }
            if l.tested_after && !self.goes_on(l)? {
                return Ok(());
            }
            self.block(&l.step)?;
            self.turns += 1;
            if self.turns > MAX_TURNS {
                return Err(Error::Endless { shader: self.shader.name.clone() });
            }
        }
    }

    fn goes_on(&mut self, l: &Loop) -> Result<bool, Error> {
        self.block(&l.head)?;
        Ok(ops::is_true(self.value(l.cond)?))
    }

    fn args(&self, args: &[Arg]) -> Result<Vec<Const>, Error> {
        let value = |arg: &Arg| match arg {
            Arg::Value(v) => self.value(*v).cloned(),
            Arg::Array(l) => self.local(*l).cloned(),
        };
        args.iter().map(value).collect()
    }

    fn inst(&self, v: ValueId) -> Result<Const, Error> {
        let shader = self.shader;
        let value = shader.values.get(v.0 as usize).ok_or_else(|| self.malformed("an unknown value"))?;
        match &value.inst {
            Inst::Const(c) => Ok(c.clone()),
            Inst::Load(l) => self.local(*l).cloned(),
            Inst::LoadElem(l, i) => {
                let i = self.index(*l, *i)?;
                match self.local(*l)? {
                    Const::Array(items) => Ok(items[i].clone()),
                    _ => Err(self.malformed("an element of no array")),
                }
            }
            Inst::Call(func, args) => {
                let name = builtins::row(*func).name;
                let args = self.args(args)?;
                state::call(name, &args, self.globals)
                    .or_else(|| texture::call(name, value.ty, &args, self.globals.textures.as_ref()))
                    .or_else(|| points::count(name, &args, self.globals.textures.as_ref()))
                    // Where a chain of comparisons with names ends, none of them is the one.
                    .or_else(|| (name == "unknown_name").then_some(Const::Int(1)))
                    .or_else(|| call(name, value.ty, &args))
                    .ok_or_else(|| Error::Unknown { shader: shader.name.clone(), function: name.to_owned() })
            }
            Inst::Albedo(id, _) => Err(Error::Unknown {
                shader: shader.name.clone(),
                function: format!("the albedo of {}", builtins::closure(*id).name),
            }),
            inst => {
                let mut args = Vec::with_capacity(4);
                let mut missing = None;
                inst.operands(&mut |o| match self.value(o) {
                    Ok(c) => args.push(c.clone()),
                    Err(e) => missing = Some(e),
                });
                match missing {
                    Some(e) => Err(e),
                    None => ops::evaluate(inst, value.ty, &args)
                        .ok_or_else(|| self.malformed("closure values or operands of other types")),
                }
            }
        }
    }
}
