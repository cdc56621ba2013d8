//! Strings that are only printed need not be made: `printf("%s", format("%g", x))` prints `x`.
//!
//! In: folded IR. Out: a `print` whose values are calls of `format` or `concat` has these calls' formats and values in their place.

use super::closures::parts;
use crate::builtins::{self, FuncId};
use crate::ir::{Arg, Block, Const, Inst, Rewriter, Shader, Stmt, ValueId};

/// Kind and owner come before the format.
const FORMAT: usize = 2;

/// Deepest calls inside each other.
const MAX_DEPTH: u32 = 32;

/// Rewrites the calls of `print`.
pub(super) fn printed(shader: &mut Shader) {
    let Some(print) = builtins::find("print") else { return };
    let mut found = false;
    for block in shader.blocks() {
        block.walk(&mut |s| {
            if let Stmt::Call { func, args, .. } = s {
                found |= *func == print && args.iter().any(|a| text_of(shader, a, 0).is_some());
            }
        });
    }
    if found {
        Printed { shader, print }.rewrite();
    }
}

struct Printed<'a> {
    shader: &'a mut Shader,
    print: FuncId,
}

impl Rewriter for Printed<'_> {
    fn shader(&mut self) -> &mut Shader {
        self.shader
    }

    fn stmt(&mut self, stmt: Stmt, out: &mut Block) {
        let spread = match &stmt {
            Stmt::Call { func, args, span, .. } if *func == self.print => match constant(self.shader, args.get(FORMAT))
            {
                Some(format) => spread(self.shader, format, &args[FORMAT + 1..], 0).map(|s| (s, *span)),
                None => None,
            },
            _ => None,
        };
        match (stmt, spread) {
            (Stmt::Call { func, mut args, outputs, result, .. }, Some(((format, values), span))) => {
                args.truncate(FORMAT);
                args.push(Arg::Value(self.shader.emit_constant(Const::Str(format), span, out)));
                args.extend(values);
                out.stmts.push(Stmt::Call { func, args, outputs, result, span });
            }
            (stmt, _) => out.stmts.push(stmt),
        }
    }
}

fn constant<'a>(shader: &'a Shader, arg: Option<&Arg>) -> Option<&'a str> {
    match arg {
        Some(Arg::Value(v)) => match &shader.values[v.0 as usize].inst {
            Inst::Const(Const::Str(s)) => Some(s),
            _ => None,
        },
        _ => None,
    }
}

/// A format with the values that are strings made on the way replaced by what they are made of; `None` when there is nothing to
/// replace, or when the values do not fit.
fn spread(shader: &Shader, format: &str, values: &[Arg], depth: u32) -> Option<(String, Vec<Arg>)> {
    let (mut text, mut list) = (String::new(), Vec::new());
    let mut changed = false;
    let mut values = values.iter();
    for part in parts(format) {
        if !part.starts_with('%') || part == "%%" {
            text.push_str(part);
            continue;
        }
        let value = values.next()?;
        match text_of(shader, value, depth).filter(|_| part == "%s") {
            Some((inner, mut more)) => {
                changed = true;
                text.push_str(&inner);
                list.append(&mut more);
            }
            None => {
                text.push_str(part);
                list.push(*value);
            }
        }
    }
    (changed && values.next().is_none()).then_some((text, list))
}

/// The format and the values of a string that a call of `format` or `concat` makes.
pub(super) fn text_of(shader: &Shader, arg: &Arg, depth: u32) -> Option<(String, Vec<Arg>)> {
    let Arg::Value(ValueId(v)) = arg else { return None };
    let Inst::Call(func, args) = &shader.values[*v as usize].inst else { return None };
    if depth > MAX_DEPTH {
        return None;
    }
    match builtins::row(*func).name {
        "format" => {
            let format = constant(shader, args.first())?;
            Some(
                spread(shader, format, &args[1..], depth + 1)
                    .unwrap_or_else(|| (format.to_owned(), args[1..].to_vec())),
            )
        }
        "concat" => {
            let (mut text, mut list) = (String::new(), Vec::new());
            for arg in args {
                if let Some(part) = constant(shader, Some(arg)) {
                    text.push_str(&part.replace('%', "%%"));
                } else if let Some((inner, mut more)) = text_of(shader, arg, depth + 1) {
                    text.push_str(&inner);
                    list.append(&mut more);
                } else {
                    text.push_str("%s");
                    list.push(*arg);
                }
            }
            Some((text, list))
        }
        _ => None,
    }
}
