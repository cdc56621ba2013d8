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

/// A level of names.
struct Level {
    names: HashMap<String, Symbol>,
    /// Declarations of it and of the level around are in one scope.
    joined: bool,
}

/// The scopes, outermost first.
#[derive(Default)]
pub(super) struct Scopes {
    stack: Vec<Level>,
}

/// Levels up to the one of the globals: names that syntax errors hide, globals. Those of the file and a shader are joined to it.
const FILE_LEVEL: usize = 2;

impl Scopes {
    pub fn enter(&mut self) {
        self.stack.push(Level { names: HashMap::new(), joined: false });
    }

    /// A level whose names end with it, but must not be those of the level around: a shader's parameters are in the scope of
    /// the file and the built-in names, the statements of a body in the scope of its parameters.
    pub fn enter_joined(&mut self) {
        self.stack.push(Level { names: HashMap::new(), joined: true });
    }

    pub fn leave(&mut self) {
        self.stack.pop();
    }

    /// The innermost meaning of a name.
    pub fn find(&self, name: &str) -> Option<&Symbol> {
        self.stack.iter().rev().find_map(|s| s.names.get(name))
    }

    /// The meaning in the innermost scope alone.
    pub fn find_here(&self, name: &str) -> Option<&Symbol> {
        for level in self.stack.iter().rev() {
            if let Some(symbol) = level.names.get(name) {
                return Some(symbol);
            }
            if !level.joined {
                break;
            }
        }
        None
    }

    /// Whether the innermost scope is that of the file, which has the names of the built-in functions too.
    pub fn at_file(&self) -> bool {
        self.stack.iter().rev().take_while(|level| level.joined).count() + FILE_LEVEL == self.stack.len()
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
            scope.names.insert(name.to_string(), symbol);
        }
    }

    /// Adds an overload to the innermost scope.
    pub fn declare_function(&mut self, name: &str, id: FunctionId) {
        if let Some(scope) = self.stack.last_mut() {
            match scope.names.get_mut(name) {
                Some(Symbol::Functions(list)) => list.push(id),
                _ => {
                    scope.names.insert(name.to_string(), Symbol::Functions(vec![id]));
                }
            }
        }
    }

    /// All overloads of a name, innermost scope first, newest first.
    pub fn functions(&self, name: &str) -> Vec<FunctionId> {
        let mut out = Vec::new();
        for scope in self.stack.iter().rev() {
            if let Some(Symbol::Functions(list)) = scope.names.get(name) {
                out.extend(list.iter().rev());
            }
        }
        out
    }

    /// The names of all symbols for which `keep` holds, for suggestions.
    pub fn names(&self, keep: impl Fn(&Symbol) -> bool) -> impl Iterator<Item = &str> {
        self.stack.iter().flat_map(|s| s.names.iter()).filter(move |(_, s)| keep(s)).map(|(n, _)| n.as_str())
    }
}
