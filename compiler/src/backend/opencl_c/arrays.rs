//! Arrays: private ones with an initialiser, and tables in constant memory.
//!
//! A table lies flat (3 reals per triple, 16 per matrix), so that a compiler reads plain numbers, in linear time.

use super::literal;
use super::writer::{MAX_PRIVATE_TABLE, Writer, table_element};
use crate::backend::names::ctype;
use crate::ir::{Const, LocalId, Ty};

/// Numbers per line of a table.
const PER_LINE: usize = 8;

impl Writer<'_> {
    /// Declares an array local, at the top of the function.
    pub(super) fn declare_array(&mut self, l: LocalId, len: u32) {
        let ty = self.shader.locals[l.0 as usize].ty;
        let name = self.name(l).to_owned();
        let u = self.local_use(l);
        let fixed = if u.changes { "" } else { "const " };
        let mut initial = u.initial.clone();
        if self.is_table(l) {
            initial.resize(len as usize, None);
        }
        if len > MAX_PRIVATE_TABLE && !initial.is_empty() {
            self.write_table(ty, &name, &initial);
            if !self.is_table(l) {
                let count = initial.len();
                let element = table_element(self, ty, &name, "i");
                self.put(None, &format!("{} {name}[{len}] = {{{}}};", ctype(ty), self.zero_element(ty)));
                self.put(None, &format!("for (int i = 0; i < {count}; i++) {name}[i] = {element};"));
            }
            return;
        }
        let mut items: Vec<String> = Vec::new();
        for c in &initial {
            items.push(match c {
                Some(Const::Matrix(m)) => format!("{{{{{}}}}}", m.map(literal::real).join(", ")),
                Some(c) => self.constant(c),
                None => self.zero_element(ty).to_owned(),
            });
        }
        if items.is_empty() {
            items.push(self.zero_element(ty).to_owned());
        }
        self.put(None, &format!("{fixed}{} {name}[{len}] = {{{}}};", ctype(ty), items.join(", ")));
    }

    fn zero_element(&self, ty: Ty) -> &'static str {
        match ty {
            Ty::Float => "0.0",
            Ty::Triple => "(real3)(0.0)",
            Ty::Matrix => "{{0.0}}",
            _ => "0",
        }
    }

    fn write_table(&mut self, ty: Ty, name: &str, initial: &[Option<Const>]) {
        let (number, width) = match ty {
            Ty::Triple => ("real", 3),
            Ty::Matrix => ("real", 16),
            other => (ctype(other), 1),
        };
        let zero = if number == "real" { "0.0" } else { "0" };
        let mut parts = Vec::with_capacity(initial.len() * width);
        for c in initial {
            match c {
                Some(Const::Str(_)) => {
                    let text = c.as_ref().map(|c| self.constant(c)).unwrap_or_default();
                    parts.push(text);
                }
                Some(c) => parts.extend(literal::parts(c)),
                None => parts.extend(std::iter::repeat_n(zero.to_owned(), width)),
            }
        }
        self.tables.push_str(&format!("__constant {number} @_{name}[{}] = {{\n", parts.len()));
        for line in parts.chunks(PER_LINE) {
            self.tables.push_str(&format!("    {},\n", line.join(", ")));
        }
        self.tables.push_str("};\n\n");
    }
}
