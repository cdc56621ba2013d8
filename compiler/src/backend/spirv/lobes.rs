//! Lobes: a function of the bridge builds each, with the slot's arguments as its own.

use super::bridge::{Param, Ret};
use super::module::Word;
use super::writer::Writer;
use crate::backend::lobes::{Argument, constructor, header, is_zero};
use crate::builtins::{self, ClosureId, ClosureRole};
use crate::ir::{Inst, LobeSlot, SlotArg, Ty, ValueId};

impl Writer<'_> {
    /// A slot's arguments: how the bridge takes them, their ids, and which are the constant 0.
    fn slot_arguments(&mut self, slot: &LobeSlot) -> (Vec<Param>, Vec<Word>, Vec<bool>) {
        let (mut params, mut given, mut zeros) = (Vec::new(), Vec::new(), Vec::new());
        for arg in &slot.args {
            let (ty, value, zero) = match arg {
                SlotArg::Const(c) => (c.ty().unwrap_or(Ty::Int), self.constant_value(c), is_zero(c)),
                SlotArg::Local(l) => (self.shader.locals[l.0 as usize].ty, self.load(*l), false),
            };
            params.push(Param::Value(ty));
            given.push(self.argument(ty, value));
            zeros.push(zero);
        }
        (params, given, zeros)
    }

    /// Offers the lobe of a slot, or takes the only one.
    pub(super) fn lobe(&mut self, number: usize, slot: &LobeSlot, weight: Word, (out, choice): (Word, Option<Word>)) {
        let (arguments, values, zeros) = self.slot_arguments(slot);
        let mut params = vec![Param::Globals, Param::Result];
        let mut given = vec![self.globals, out];
        if let Some(choice) = choice {
            params.push(Param::Choice);
            given.push(choice);
        }
        params.push(Param::Value(Ty::Triple));
        given.push(weight);
        let fixed = params.len();
        params.extend(arguments);
        given.extend(values);
        self.bridge.includes.extend(["lobe.h", "bsdf/pick.h"]);
        let body = |texts: &[String]| {
            let weight = &texts[fixed - 1];
            let lobe = call(slot.closure, &texts[fixed..], &zeros);
            let take = if choice.is_some() {
                format!(
                    "        const Lobe lobe = {lobe};\n        lobe_offer(out, choice, &lobe, {weight}, -sg->I);\n"
                )
            } else {
                format!("        out->lobe = {lobe};\n        out->lobe.weight = {weight};\n")
            };
            format!("    if (lobe_counts({weight})) {{\n{take}    }}\n")
        };
        let name = format!("lobe{number}");
        let function = self.bridge.function(&mut self.module, &name, Ret::Nothing, &params, body);
        self.call_nothing(function, &given);
    }

    /// `Inst::Albedo`.
    pub(super) fn albedo(&mut self, id: ClosureId, args: &[ValueId]) -> Word {
        let row = builtins::closure(id);
        let ClosureRole::Lobe(lobe) = row.role else { return self.zero(Ty::Triple) };
        self.bridge.includes.extend(["lobe.h", header(lobe)]);
        let shader = self.shader;
        let zeros: Vec<bool> =
            args.iter().map(|v| matches!(&shader.values[v.0 as usize].inst, Inst::Const(c) if is_zero(c))).collect();
        let mut params = vec![Param::Globals];
        let mut given = vec![self.globals];
        let mut name = format!("{lobe}_albedo_");
        for v in args {
            let ty = self.value_ty(*v);
            params.push(Param::Value(ty));
            given.push(self.argument(ty, self.value(*v)));
        }
        name.extend(zeros.iter().map(|z| if *z { '0' } else { 'x' }));
        name.push_str(row.name);
        let body = |texts: &[String]| format!("{lobe}_albedo3({}, -sg->I)", call(id, &texts[1..], &zeros));
        let function = self.bridge.function(&mut self.module, &name, Ret::Value(Ty::Triple), &params, body);
        self.call(function, Ty::Triple, &given)
    }
}

/// The constructor's call on the bridge's arguments.
fn call(id: ClosureId, texts: &[String], zeros: &[bool]) -> String {
    let argument = |(text, zero): (&String, &bool)| Argument { text: text.clone(), is_zero: *zero };
    let arguments: Vec<Argument> = texts.iter().zip(zeros).map(argument).collect();
    constructor(id, &arguments)
}
