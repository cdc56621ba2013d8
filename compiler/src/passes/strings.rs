//! Follows strings back to the constants they can be: a choice among known texts works on the device.
//!
//! In: IR. Out: for values and locals, all texts (or other constants) that they can hold, whatever the flow of control.

use crate::ir::{Const, Inst, LocalId, LocalKind, Shader, Stmt, Ty, ValueId};
use std::collections::{BTreeSet, HashMap, HashSet};

/// Where the strings of each local come from, whatever the flow of control.
pub(super) struct Strings {
    values: HashMap<LocalId, Vec<ValueId>>,
    copies: HashMap<LocalId, Vec<LocalId>>,
    /// Locals that something other than the shader may write.
    foreign: HashSet<LocalId>,
}

impl Strings {
    pub fn of(shader: &Shader) -> Strings {
        Strings::of_types(shader, &|ty| ty == Ty::Str)
    }

    /// As [`Strings::of`], for locals of other types.
    pub fn of_types(shader: &Shader, wanted: &dyn Fn(Ty) -> bool) -> Strings {
        let mut strings = Strings { values: HashMap::new(), copies: HashMap::new(), foreign: HashSet::new() };
        let is_wanted = |l: &LocalId| wanted(shader.locals[l.0 as usize].ty);
        for block in shader.blocks() {
            block.walk(&mut |s| match s {
                Stmt::Store(l, v) | Stmt::StoreElem(l, _, v) if is_wanted(l) => {
                    strings.values.entry(*l).or_default().push(*v);
                }
                Stmt::CopyArray(to, from) if is_wanted(to) => strings.copies.entry(*to).or_default().push(*from),
                Stmt::Call { outputs, result, .. } => strings.foreign.extend(outputs.iter().chain(result)),
                _ => {}
            });
        }
        strings.foreign.extend(shader.params.iter().filter(|p| p.varying).map(|p| p.local));
        // What the renderer supplies may be anything.
        let supplied = |kind| matches!(kind, LocalKind::Input(_) | LocalKind::Global(_));
        let inputs = shader.locals.iter().enumerate().filter(|(_, l)| supplied(l.kind));
        strings.foreign.extend(inputs.map(|(i, _)| LocalId(i as u32)));
        strings
    }

    /// What is stored to a local, as values and as whole arrays; `None` when something else may write it.
    pub fn stored(&self, local: LocalId) -> Option<(&[ValueId], &[LocalId])> {
        fn list<T>(map: &HashMap<LocalId, Vec<T>>, local: LocalId) -> &[T] {
            map.get(&local).map_or(&[], Vec::as_slice)
        }
        (!self.foreign.contains(&local)).then(|| (list(&self.values, local), list(&self.copies, local)))
    }

    /// All texts that these values and locals can be; see [`Strings::constants`].
    pub fn trace(&self, shader: &Shader, values: Vec<ValueId>, locals: Vec<LocalId>) -> Option<BTreeSet<String>> {
        let text = |c| match c {
            Const::Str(s) => Some(s),
            _ => None,
        };
        self.constants(shader, values, locals)?.into_iter().map(text).collect()
    }

    /// All constants that these values and locals can be; `None` when something else may be among them. What is read
    /// without having been stored does not count: its value is undefined.
    pub fn constants(&self, shader: &Shader, mut values: Vec<ValueId>, mut locals: Vec<LocalId>) -> Option<Vec<Const>> {
        let mut found = Vec::new();
        let (mut seen_values, mut seen_locals) = (HashSet::new(), HashSet::new());
        loop {
            if let Some(v) = values.pop() {
                if !seen_values.insert(v) {
                    continue;
                }
                match &shader.values[v.0 as usize].inst {
                    Inst::Const(c) if found.contains(c) => {}
                    Inst::Const(c) => found.push(c.clone()),
                    Inst::Load(l) | Inst::LoadElem(l, _) => locals.push(*l),
                    Inst::Select(_, a, b) => values.extend([*a, *b]),
                    _ => return None,
                }
            } else if let Some(l) = locals.pop() {
                if !seen_locals.insert(l) {
                    continue;
                }
                let (stored, copied) = self.stored(l)?;
                values.extend(stored);
                locals.extend(copied);
            } else {
                return Some(found);
            }
        }
    }

    /// Whether one is a constant that the other cannot be. The empty string is also what was never stored.
    pub fn never_equal(&self, shader: &Shader, a: ValueId, b: ValueId) -> bool {
        let (constant, other) = match (&shader.values[a.0 as usize].inst, &shader.values[b.0 as usize].inst) {
            (Inst::Const(Const::Str(s)), _) => (s, b),
            (_, Inst::Const(Const::Str(s))) => (s, a),
            _ => return false,
        };
        !constant.is_empty()
            && self.trace(shader, vec![other], Vec::new()).is_some_and(|names| !names.contains(constant))
    }
}
