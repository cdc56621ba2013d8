//! Calls that print: the site for the host, and the code that writes its record (kernels/osl/records.h).
//!
//! In: the arguments of the IR's `print`. Out: a block of C, and a [`Site`] of the writer. What is known at compile time goes
//! into the site and costs the device nothing.

use super::writer::Writer;
use crate::ir::{Arg, Inst, Ty};
use crate::messages::{Site, SiteArg, words_of};
use crate::source::Span;

/// Arrays up to this length are recorded element by element.
const MAX_UNROLLED: u32 = 4;

impl Writer<'_> {
    /// Writes a call of `print`.
    pub(super) fn print(&mut self, args: &[Arg], span: Span) {
        let shader = self.shader;
        let mut site = Site { args: Vec::with_capacity(args.len()) };
        let mut words = 0;
        let mut lines = Vec::new();
        for arg in args {
            site.args.push(match arg {
                Arg::Value(v) => {
                    let value = &shader.values[v.0 as usize];
                    let text = self.operand(*v).text;
                    if let Inst::Const(c) = &value.inst {
                        SiteArg::Constant(c.clone())
                    } else {
                        words += words_of(value.ty);
                        lines.push(format!("{}(&record, {text});", function(value.ty)));
                        SiteArg::Value { ty: value.ty.code(), len: None }
                    }
                }
                Arg::Array(l) => {
                    let local = &shader.locals[l.0 as usize];
                    let len = local.len.unwrap_or(0);
                    words = words_of(local.ty).saturating_mul(len).saturating_add(words);
                    let write = function(local.ty);
                    if len <= MAX_UNROLLED {
                        for i in 0..len {
                            let element = self.element(*l, &i.to_string()).text;
                            lines.push(format!("{write}(&record, {element});"));
                        }
                    } else {
                        let element = self.element(*l, "i").text;
                        lines.push(format!("for (int i = 0; i < {len}; i++) {write}(&record, {element});"));
                    }
                    SiteArg::Value { ty: local.ty.code(), len: Some(len) }
                }
            });
        }
        self.includes.insert("osl/records.h");
        let number = self.sites.len();
        self.sites.push(site);
        if lines.is_empty() {
            return self.put(Some(span), &format!("record_open(sg, {number}, {words});"));
        }
        self.put(Some(span), "{");
        self.open(Some(span));
        self.put(Some(span), &format!("Record record = record_open(sg, {number}, {words});"));
        for line in lines {
            self.put(Some(span), &line);
        }
        self.close();
        self.put(None, "}");
    }
}

fn function(ty: Ty) -> &'static str {
    match ty {
        Ty::Float => "record_f",
        Ty::Triple => "record_v",
        Ty::Matrix => "record_m",
        _ => "record_i",
    }
}
