//! Names in force: variables, functions (overloaded) and structs, by scope.

use super::typed::{FunctionId, VarId};
use crate::types::StructId;
use std::collections::HashMap;

/// What a name means in one scope.
#[derive(Clone, Debug)]
pub(super) enum Symbol {
    Var(VarId),
    Functions(Vec<FunctionId>),
    Struct(StructId),
    /// Its declaration was reported already: its uses are not.
    Broken,
}

/// The scopes, outermost first.
#[derive(Default)]
pub(super) struct Scopes {
    stack: Vec<HashMap<String, Symbol>>,
}

impl Scopes {
    pub fn enter(&mut self) {
        self.stack.push(HashMap::new());
    }

    pub fn leave(&mut self) {
        self.stack.pop();
    }

    /// The innermost meaning of a name.
    pub fn find(&self, name: &str) -> Option<&Symbol> {
        self.stack.iter().rev().find_map(|s| s.get(name))
    }

    /// The meaning in the innermost scope alone.
    pub fn find_here(&self, name: &str) -> Option<&Symbol> {
        self.stack.last().and_then(|s| s.get(name))
    }

    pub fn declare_var(&mut self, name: &str, id: VarId) {
        self.declare(name, Symbol::Var(id));
    }

    pub fn declare_struct(&mut self, name: &str, id: StructId) {
        self.declare(name, Symbol::Struct(id));
    }

    /// Makes uses of a name whose declaration failed go unreported.
    pub fn declare_broken(&mut self, name: &str) {
        if self.find_here(name).is_none() {
            self.declare(name, Symbol::Broken);
        }
    }

    fn declare(&mut self, name: &str, symbol: Symbol) {
        if let Some(scope) = self.stack.last_mut() {
            scope.insert(name.to_string(), symbol);
        }
    }

    /// Adds an overload to the innermost scope.
    pub fn declare_function(&mut self, name: &str, id: FunctionId) {
        if let Some(scope) = self.stack.last_mut() {
            match scope.get_mut(name) {
                Some(Symbol::Functions(list)) => list.push(id),
                _ => {
                    scope.insert(name.to_string(), Symbol::Functions(vec![id]));
                }
            }
        }
    }

    /// All overloads of a name, innermost scope first, newest first.
    pub fn functions(&self, name: &str) -> Vec<FunctionId> {
        let mut out = Vec::new();
        for scope in self.stack.iter().rev() {
            if let Some(Symbol::Functions(list)) = scope.get(name) {
                out.extend(list.iter().rev());
            }
        }
        out
    }

    /// The names of all symbols for which `keep` holds, for suggestions.
    pub fn names(&self, keep: impl Fn(&Symbol) -> bool) -> impl Iterator<Item = &str> {
        self.stack.iter().flat_map(|s| s.iter()).filter(move |(_, s)| keep(s)).map(|(n, _)| n.as_str())
    }
}
