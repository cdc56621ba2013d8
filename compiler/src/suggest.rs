//! "Did you mean": the known name nearest to a misspelt one.

use crate::diag::Diagnostic;
use crate::source::Span;

/// "not supported yet" for a name that is none of those known; `what` says what kind of name.
pub fn unknown_name(what: &str, name: &str, known: &[&str], span: Span) -> Diagnostic {
    Diagnostic::not_yet("E3003", span, format!("{what} \"{name}\"")).help(known_names(name, known))
}

/// The nearest of the known names, and all of them.
pub fn known_names(name: &str, known: &[&str]) -> String {
    let near = closest(name, known.iter().copied()).map_or(String::new(), |n| format!("did you mean \"{n}\"? "));
    let all: Vec<String> = known.iter().map(|c| format!("\"{c}\"")).collect();
    format!("{near}known here: {}", all.join(", "))
}

/// The candidate with the least edit distance to `name`, when it is close enough to be a slip: at most a third of the
/// letters, at most 3. Case does not count, so that `n` finds `N`.
pub fn closest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (name.chars().count() / 3).min(3);
    candidates
        .filter(|c| *c != name && c.len().abs_diff(name.len()) <= limit)
        .map(|c| (distance(&name.to_lowercase(), &c.to_lowercase()), c))
        .filter(|(d, _)| *d <= limit)
        .min_by_key(|(d, c)| (*d, *c))
        .map(|(_, c)| c)
}

/// Edit distance with swaps of neighbours as one edit (optimal string alignment).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![vec![0usize; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let change = (a[i - 1] != b[j - 1]) as usize;
                let mut best = (rows[i - 1][j] + 1).min(rows[i][j - 1] + 1).min(rows[i - 1][j - 1] + change);
                if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                    best = best.min(rows[i - 2][j - 2] + 1);
                }
                best
            };
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::closest;

    #[test]
    fn finds_slips_but_not_strangers() {
        let names = ["diffuse", "refraction", "reflection", "N"];
        assert_eq!(closest("difuse", names.into_iter()), Some("diffuse"));
        assert_eq!(closest("reflectoin", names.into_iter()), Some("reflection"));
        assert_eq!(closest("texture", names.into_iter()), None);
        assert_eq!(closest("n", names.into_iter()), Some("N"));
        assert_eq!(closest("x", names.into_iter()), None);
    }
}
