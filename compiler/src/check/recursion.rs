//! OSL has no recursion: finds functions that reach themselves and shows the chain.

use super::Checker;
use super::typed::FunctionId;
use crate::diag::Diagnostic;
use crate::source::Span;

impl Checker {
    pub(super) fn check_recursion(&mut self) {
        let count = self.functions.len();
        let mut edges: Vec<Vec<(FunctionId, Span)>> = vec![Vec::new(); count];
        for (from, to, span) in &self.calls {
            edges[from.0 as usize].push((*to, *span));
        }
        // 0 unseen, 1 on the present path, 2 done.
        let mut state = vec![0u8; count];
        for start in 0..count {
            if state[start] != 0 {
                continue;
            }
            let mut path: Vec<(usize, usize, Option<Span>)> = vec![(start, 0, None)];
            state[start] = 1;
            while let Some((node, next, _)) = path.last_mut() {
                let here = *node;
                let Some((to, span)) = edges[here].get(*next).copied() else {
                    state[here] = 2;
                    path.pop();
                    continue;
                };
                *next += 1;
                match state[to.0 as usize] {
                    0 => {
                        state[to.0 as usize] = 1;
                        path.push((to.0 as usize, 0, Some(span)));
                    }
                    1 => {
                        let first = path.iter().position(|p| p.0 == to.0 as usize).unwrap_or(0);
                        self.report_recursion(&path[first..], to, span);
                    }
                    _ => {}
                }
            }
        }
    }

    fn report_recursion(&mut self, path: &[(usize, usize, Option<Span>)], to: FunctionId, span: Span) {
        let name = |i: usize| self.functions[i].name.clone();
        let mut chain: Vec<String> = path.iter().map(|p| name(p.0)).collect();
        chain.push(name(to.0 as usize));
        let message = format!("`{}` calls itself: {}", name(to.0 as usize), chain.join(" -> "));
        let mut d = Diagnostic::error("E2010", span, message).help("OSL has no recursion; use a loop");
        for (step, p) in path.iter().enumerate().skip(1) {
            if let Some(at) = p.2 {
                d = d.label(at, format!("`{}` calls `{}` here", chain[step - 1], chain[step]));
            }
        }
        self.error(d);
    }
}
