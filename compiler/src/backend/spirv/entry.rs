//! The two kinds of functions: a material that offers its lobes, and a grid that stores outputs.

use super::bridge::{Param, Ret};
use super::module::{Op, Type, Word};
use super::writer::Writer;
use super::{Width, exported};
use crate::backend::entry::{Entry, Source, outputs, role};
use crate::builtins::ClosureRole;
use crate::diag::Diagnostic;
use crate::ir::{LobeSlot, LocalId, Shader, Ty, slots_of};

/// Words, bridge, headers.
type Written = (Vec<u32>, String, Vec<String>);

/// Writes a shader in one precision.
pub(super) fn write(shader: &Shader, entry: &Entry, name: &str, width: Width) -> Result<Written, Vec<Diagnostic>> {
    match entry {
        Entry::Material => material(shader, name, width),
        Entry::Grid(names) => grid(shader, names, name, width),
    }
}

fn material(shader: &Shader, name: &str, width: Width) -> Result<Written, Vec<Diagnostic>> {
    let params = [("sg", Type::BytePointer), ("pick", Type::Real), ("out", Type::BytePointer)];
    let mut w = Writer::new(shader, &[], name, width);
    w.bridge.includes.insert("lobe.h");
    let ids = w.module.begin(&params);
    w.globals = ids[0];
    let (pick, out) = (ids[1], ids[2]);
    body(&mut w);
    if w.module.is_open() {
        deliver(&mut w, pick, out);
    }
    let outer = "const ShaderGlobals *sg, real pick, ShadeResult *out";
    finish(w, &params, ("uchar *sg, real pick, uchar *out", outer, "(uchar *)sg, pick, (uchar *)out"))
}

/// Puts what the shader gives into the result.
fn deliver(w: &mut Writer, pick: Word, out: Word) {
    let shader = w.shader;
    let scatters = |s: &&LobeSlot| matches!(role(s), ClosureRole::Lobe(_) | ClosureRole::Transparent);
    let many = shader.slots.iter().filter(scatters).count() > 1;
    let nothing = |_: &[String]| {
        "    out->lobe.type = LOBE_NONE;\n    out->emission = out->background = out->holdout = (real3)(0.0);\n"
            .to_owned()
    };
    let begin = w.bridge.function(&mut w.module, "nothing", Ret::Nothing, &[Param::Result], nothing);
    w.call_nothing(begin, &[out]);
    let choice = many.then(|| {
        let real = w.module.ty(Type::Real);
        let three = w.module.array(real, 3);
        let choice = w.module.variable(three);
        let pointer = w.module.ty(Type::RealPointer);
        let zero = w.module.real(0.0);
        let mut first = choice;
        for (k, value) in [pick, zero, zero].into_iter().enumerate() {
            let k = w.module.int(k as i32);
            let place = w.module.inst(Op::InBoundsAccessChain, pointer, &[choice, k]);
            w.module.effect(Op::Store, &[place, value]);
            if first == choice {
                first = place;
            }
        }
        first
    });
    for (number, slot) in shader.slots.iter().enumerate() {
        let weight = w.load(slot.weight);
        let (name, body) = match role(slot) {
            ClosureRole::Emission => ("emission", "    out->emission += a2;\n"),
            ClosureRole::Background => ("background", "    out->background += a2;\n"),
            ClosureRole::Holdout => ("holdout", "    out->holdout += a2;\n"),
            ClosureRole::Lobe(_) | ClosureRole::Transparent => {
                w.lobe(number, slot, weight, (out, choice));
                continue;
            }
            ClosureRole::Debug | ClosureRole::Volume => continue,
            ClosureRole::Layer => {
                let message = "internal error: a layer reached the back end";
                w.errors.push(Diagnostic::error("E4399", slot.span, message));
                continue;
            }
        };
        let params = [Param::Globals, Param::Result, Param::Value(Ty::Triple)];
        let function = w.bridge.function(&mut w.module, name, Ret::Nothing, &params, |_| body.to_owned());
        w.call_nothing(function, &[w.globals, out, weight]);
    }
    if let Some(choice) = choice {
        let params = [Param::Result, Param::Choice];
        let body = |_: &[String]| "    lobe_finish(out, choice);\n".to_owned();
        let function = w.bridge.function(&mut w.module, "finish", Ret::Nothing, &params, body);
        w.call_nothing(function, &[out, choice]);
    }
}

fn grid(shader: &Shader, names: &[String], name: &str, width: Width) -> Result<Written, Vec<Diagnostic>> {
    let list = outputs(shader, names)?;
    let local = |source: &Source| match source {
        Source::Local(l) => Some(*l),
        Source::Field(_) | Source::Ci => None,
    };
    let results: Vec<LocalId> = list.iter().filter_map(|(s, _)| local(s)).collect();
    let params = [("sg", Type::BytePointer), ("outputs", Type::RealPointer)];
    let mut w = Writer::new(shader, &results, name, width);
    let ids = w.module.begin(&params);
    w.globals = ids[0];
    body(&mut w);
    for (source, output) in &list {
        if !w.module.is_open() {
            break;
        }
        match source {
            Source::Local(l) => store(&mut w, *l, ids[1], output.offset),
            Source::Field(g) => {
                let name = g.name();
                let body = |_: &[String]| format!("sg->{name}");
                let ret = Ret::Value(Ty::Triple);
                let function = w.bridge.function(&mut w.module, name, ret, &[Param::Globals], body);
                let value = w.call(function, Ty::Triple, &[w.globals]);
                let at = w.module.int(output.offset as i32);
                store_single(&mut w, Ty::Triple, value, ids[1], at);
            }
            Source::Ci => {
                let ty = w.module.ty(Type::Triple);
                let mut sum = None;
                for slot in &shader.slots {
                    let weight = w.load(slot.weight);
                    sum = Some(match sum {
                        None => weight,
                        Some(sum) => w.module.inst(Op::FAdd, ty, &[sum, weight]),
                    });
                }
                let value = match sum {
                    Some(sum) => sum,
                    None => w.zero(Ty::Triple),
                };
                let at = w.module.int(output.offset as i32);
                store_single(&mut w, Ty::Triple, value, ids[1], at);
            }
        }
    }
    let outer = "const ShaderGlobals *sg, real *outputs";
    finish(w, &params, ("uchar *sg, real *outputs", outer, "(uchar *)sg, outputs"))
}

/// Stores an output parameter from `outputs[offset]` on.
fn store(w: &mut Writer, l: LocalId, outputs: Word, offset: u32) {
    let local = &w.shader.locals[l.0 as usize];
    let ty = local.ty;
    let Some(len) = local.len else {
        let value = w.load(l);
        let at = w.module.int(offset as i32);
        return store_single(w, ty, value, outputs, at);
    };
    w.counted(len, |w, i| {
        let value = w.element(l, i);
        let at = w.scaled(i, slots_of(ty) as i32, offset as i32);
        store_single(w, ty, value, outputs, at);
    });
}

fn store_single(w: &mut Writer, ty: Ty, value: Word, outputs: Word, at: Word) {
    let parts: Vec<Word> = match ty {
        Ty::Triple => (0..3).map(|k| w.module.extract(Type::Real, value, k)).collect(),
        Ty::Matrix => {
            let real = w.module.ty(Type::Real);
            let element = |k| {
                let index = w.module.int(k);
                let pointer = w.matrix_element(value, index);
                w.module.inst(Op::Load, real, &[pointer])
            };
            (0..16).map(element).collect()
        }
        Ty::Float => vec![value],
        _ => vec![w.int_to_real(value)],
    };
    let pointer = w.module.ty(Type::RealPointer);
    let int = w.module.ty(Type::Int);
    for (k, part) in parts.into_iter().enumerate() {
        let k = w.module.int(k as i32);
        let index = w.module.inst(Op::IAdd, int, &[at, k]);
        let place = w.module.inst(Op::InBoundsPtrAccessChain, pointer, &[outputs, index]);
        w.module.effect(Op::Store, &[place, part]);
    }
}

/// Writes declarations, the parameters' inits and the body.
fn body(w: &mut Writer) {
    let shader = w.shader;
    w.declare_all();
    for param in &shader.params {
        w.block(&param.init);
    }
    w.block(&shader.body);
}

fn finish(
    w: Writer,
    params: &[(&str, Type)],
    (signature, outer, inner): (&str, &str, &str),
) -> Result<Written, Vec<Diagnostic>> {
    if !w.errors.is_empty() {
        return Err(w.errors);
    }
    let about = format!("{} {}", sanitised(&w.shader.kind), sanitised(&w.shader.name));
    let name = w.bridge.entry().to_owned();
    let (text, includes) = w.bridge.finish(&about, signature, outer, inner);
    Ok((w.module.finish(&exported(&name), params), text, includes))
}

fn sanitised(text: &str) -> String {
    crate::backend::names::sanitise(text)
}
