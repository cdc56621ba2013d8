//! Calls that print: a function of the bridge writes the record (kernels/osl/records.h). The sites are the artifact's.

use super::bridge::{Param, Ret};
use super::inst::MAX_ARGUMENTS;
use super::writer::Writer;
use crate::diag::Diagnostic;
use crate::ir::{Arg, Inst, Stmt, Ty};
use crate::messages::words_of;
use crate::source::Span;

impl Writer<'_> {
    /// Writes a call of `print`.
    pub(super) fn print(&mut self, stmt: &Stmt, args: &[Arg], span: Span) {
        let shader = self.shader;
        let number = self.sites.get(&std::ptr::from_ref(stmt)).copied().unwrap_or(0);
        let mut params = vec![Param::Globals];
        let mut given = vec![self.globals];
        let mut lengths = Vec::new();
        let mut words = 0;
        for arg in args {
            match arg {
                // The site has it.
                Arg::Value(v) if matches!(shader.values[v.0 as usize].inst, Inst::Const(_)) => {}
                Arg::Value(v) => {
                    let ty = self.value_ty(*v);
                    words += words_of(ty);
                    params.push(Param::Value(ty));
                    given.push(self.argument(ty, self.value(*v)));
                    lengths.push((ty, None));
                }
                Arg::Array(l) => {
                    let local = &shader.locals[l.0 as usize];
                    let len = local.len.unwrap_or(0);
                    words = words_of(local.ty).saturating_mul(len).saturating_add(words);
                    params.push(Param::Place(local.ty));
                    given.push(self.place(*l));
                    lengths.push((local.ty, Some(len)));
                }
            }
        }
        if !Self::fits(given.len()) {
            let message =
                format!("this call has more than the {MAX_ARGUMENTS} arguments that functions of SPIR-V have");
            self.errors.push(Diagnostic::error("E4301", span, message));
            return;
        }
        self.bridge.includes.insert("osl/records.h");
        let body = |texts: &[String]| {
            let mut body = format!("    Record record = record_open(sg, {number}, {words});\n");
            for (text, (ty, len)) in texts[1..].iter().zip(&lengths) {
                let write = match ty {
                    Ty::Float => "record_f",
                    Ty::Triple => "record_v",
                    Ty::Matrix => "record_m",
                    _ => "record_i",
                };
                body.push_str(&match len {
                    None => format!("    {write}(&record, {text});\n"),
                    Some(n) => format!("    for (int i = 0; i < {n}; i++) {write}(&record, ({text})[i]);\n"),
                });
            }
            body
        };
        let name = format!("print{number}");
        let function = self.bridge.function(&mut self.module, &name, Ret::Nothing, &params, body);
        self.call_nothing(function, &given);
    }
}
