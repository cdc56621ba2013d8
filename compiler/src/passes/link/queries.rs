//! What a shader asks about its place in the group: `isconnected`, and the lengths of unsized arrays.
//!
//! In: a layer whose arrays have their lengths. Out: the layer with constants in place of the questions.

use crate::builtins;
use crate::ir::{Arg, Const, Inst, LocalId, Shader, ValueId};

/// Answers the questions; `connected` is `isconnected` of the parameter with an index.
pub(super) fn settle(shader: &mut Shader, connected: &dyn Fn(usize) -> i32) {
    let answers: Vec<(usize, i32)> =
        (0..shader.values.len()).filter_map(|i| Some((i, answer(shader, i, connected)?))).collect();
    for (i, answer) in answers {
        shader.values[i].inst = Inst::Const(Const::Int(answer));
    }
}

fn answer(shader: &Shader, index: usize, connected: &dyn Fn(usize) -> i32) -> Option<i32> {
    let Inst::Call(func, args) = &shader.values[index].inst else { return None };
    match (builtins::row(*func).name, args.as_slice()) {
        ("is_connected", [Arg::Value(ValueId(name))]) => {
            let Inst::Const(Const::Str(name)) = &shader.values[*name as usize].inst else { return Some(0) };
            Some(shader.params.iter().position(|p| p.name == *name).map_or(0, connected))
        }
        ("array_length", [Arg::Array(LocalId(l))]) => Some(shader.locals[*l as usize].len.unwrap_or(0) as i32),
        _ => None,
    }
}
