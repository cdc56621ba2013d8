//! What a shader on a grid gets beside the points: userdata and the values of interactive parameters.
//!
//! In: values by name, an artifact that says where they lie. Out: the text of a function that fills a point's userdata, and
//! the numbers of interactive parameters. It must not know devices.

use oslcl_compiler::artifact::Slot;
use oslcl_compiler::types::{Base, Type};
use oslcl_compiler::{Artifact, Binding, Userdata};
use std::fmt::Write as _;

/// Where a point's userdata comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Given {
    /// The same at all points.
    Constant(Binding),
    /// OpenCL C: the value, and where it is there ("" : everywhere). They may read the `ShaderGlobals` that `sg` points to.
    Code {
        /// A float or an int.
        value: &'static str,
        /// A condition.
        when: &'static str,
    },
}

/// Userdata that the points of a grid have.
#[derive(Clone, Debug, PartialEq)]
pub struct PointData {
    /// Its name and type.
    pub declared: Userdata,
    /// Its values.
    pub given: Given,
}

/// What a shader gets beside the points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Supplies {
    /// Userdata. The compiler has to know of it, too: [`Supplies::declared`].
    pub userdata: Vec<PointData>,
    /// Values of interactive parameters by name (`layer.param` in a group); the others keep what they were compiled with.
    pub interactive: Vec<(String, Binding)>,
}

impl Supplies {
    /// The userdata that the reference's testshade has: `s` and `t` are u and v, and some is there at some points only.
    pub fn of_testshade() -> Supplies {
        let data = |name: &str, base: Base, value: &'static str, when: &'static str| PointData {
            declared: Userdata {
                name: name.to_owned(),
                ty: Type::scalar(base),
                sometimes: !when.is_empty(),
                // Globals bring their derivatives along.
                same_as: value.strip_prefix("sg->").filter(|_| when.is_empty()).map(str::to_owned),
            },
            given: Given::Code { value, when },
        };
        let userdata = vec![
            data("face_idx", Base::Int, "(int)(4 * sg->u)", ""),
            data("s", Base::Float, "sg->u", ""),
            data("t", Base::Float, "sg->v", ""),
            data("red", Base::Float, "sg->u", "sg->P.x > (real)0.5"),
            data("green", Base::Float, "sg->v", "sg->P.x < (real)0.5"),
            data("blue", Base::Float, "1 - sg->u", "(int)(sg->P.y * 12) % 2 == 0"),
        ];
        Supplies { userdata, interactive: Vec::new() }
    }

    /// What the compiler's `Options.userdata` should hold.
    pub fn declared(&self) -> Vec<Userdata> {
        self.userdata.iter().map(|d| d.declared.clone()).collect()
    }

    /// The function that fills the userdata of an artifact; empty when it has none.
    pub(crate) fn code(&self, artifact: &Artifact) -> String {
        let inputs = &artifact.inputs;
        if inputs.userdata_slots == 0 {
            return String::new();
        }
        let mut text = String::from("\nstatic inline void shade_userdata(const ShaderGlobals *sg, real *slots)\n{\n");
        let _ = writeln!(text, "    for (int i = 0; i < {}; i++) slots[i] = 0;", inputs.userdata_slots);
        for slot in &inputs.userdata {
            if let Some(data) = self.userdata.iter().rev().find(|d| d.declared.name == slot.name) {
                fill(&mut text, slot, &data.given);
            }
        }
        text.push_str("}\n");
        text
    }

    /// The numbers of the interactive slots, and for each whether it holds an int.
    pub(crate) fn interactive(&self, artifact: &Artifact) -> Vec<(f64, bool)> {
        let mut out = vec![(0.0, false); artifact.inputs.interactive_slots as usize];
        let mut put = |at: u32, value: f64, int: bool| {
            if let Some(slot) = out.get_mut(at as usize) {
                *slot = (value, int);
            }
        };
        for slot in &artifact.inputs.interactive {
            let set = self.interactive.iter().rev().find(|(name, _)| *name == slot.name);
            let numbers = set.and_then(|(_, value)| value.numbers(slot));
            if let Some(has) = slot.has {
                put(has, f64::from(u8::from(numbers.is_some())), true);
            }
            for (i, value) in numbers.as_ref().unwrap_or(&slot.default).iter().enumerate() {
                put(slot.offset + i as u32, *value, slot.is_int());
            }
        }
        out
    }

    /// The strings among the values, which a shader may print.
    pub(crate) fn strings(&self) -> Vec<String> {
        let constants = self.userdata.iter().filter_map(|d| match &d.given {
            Given::Constant(value) => Some(value),
            Given::Code { .. } => None,
        });
        let mut out = Vec::new();
        for value in constants.chain(self.interactive.iter().map(|(_, v)| v)) {
            match value {
                Binding::Str(s) => out.push(s.clone()),
                Binding::Strs(list) => out.extend(list.iter().cloned()),
                _ => {}
            }
        }
        out
    }
}

/// Statements that fill a slot.
fn fill(text: &mut String, slot: &Slot, given: &Given) {
    let mut put = |at: u32, value: &str, int: bool| {
        let _ = match int {
            true => writeln!(text, "    *(int *)(slots + {at}) = {value};"),
            false => writeln!(text, "    slots[{at}] = {value};"),
        };
    };
    match given {
        Given::Code { value, when } => {
            put(slot.offset, value, slot.is_int());
            if let Some(has) = slot.has {
                put(has, if when.is_empty() { "1" } else { when }, true);
            }
        }
        Given::Constant(value) => {
            let Some(numbers) = value.numbers(slot) else { return };
            for (i, number) in numbers.iter().enumerate() {
                let number =
                    if slot.is_int() { format!("(int){}", *number as i64) } else { format!("(real){number:?}") };
                put(slot.offset + i as u32, &number, slot.is_int());
            }
            if let Some(has) = slot.has {
                put(has, "1", true);
            }
        }
    }
}
