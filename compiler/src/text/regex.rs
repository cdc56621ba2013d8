//! `regex_search` and `regex_match`: the reference's std::regex (ECMAScript's syntax, bytes) by way of the regex crate.
//!
//! In: subject and pattern. Out: whether they match, and where. Back references and look-around, which the crate refuses, count
//! as a pattern that never matches, as does one that is malformed.

use regex::bytes::{Regex, RegexBuilder};

/// Whether the pattern is found in the subject (`full`: is all of it), and `count` offsets of the match and its groups, each
/// as begin and end; of what did not take part the reference gives the subject's end, and the pattern's length for groups that
/// the pattern does not have.
pub(super) fn search(subject: &str, pattern: &str, full: bool, count: usize) -> (bool, Vec<i32>) {
    let regex = compile(pattern, full);
    let found = regex.as_ref().and_then(|r| r.captures(subject.as_bytes()));
    let size = |n: usize| i32::try_from(n).unwrap_or(i32::MAX);
    let groups = found.as_ref().map_or(0, regex::bytes::Captures::len);
    let offsets = (0..count).map(|i| match found.as_ref().filter(|_| i / 2 < groups) {
        Some(captures) => {
            let (begin, end) = captures.get(i / 2).map_or((subject.len(), subject.len()), |m| (m.start(), m.end()));
            size(if i % 2 == 0 { begin } else { end })
        }
        None => size(pattern.len()),
    });
    (found.is_some(), offsets.collect())
}

fn compile(pattern: &str, full: bool) -> Option<Regex> {
    let pattern = translated(pattern);
    let pattern = if full { format!(r"\A(?:{pattern})\z") } else { pattern };
    RegexBuilder::new(&pattern).unicode(false).build().ok()
}

/// The pattern with what only the regex crate takes as special made plain.
fn translated(pattern: &str) -> String {
    let mut out = String::with_capacity(pattern.len());
    let mut chars = pattern.chars().peekable();
    let mut in_class = false;
    while let Some(c) = chars.next() {
        match c {
            '\\' => {
                out.push(c);
                out.extend(chars.next());
            }
            '[' if in_class && chars.peek() != Some(&':') => out.push_str(r"\["),
            '&' | '~' if in_class => {
                out.push('\\');
                out.push(c);
            }
            '[' if in_class => {
                // A named class, up to its own bracket.
                out.push(c);
                for c in chars.by_ref() {
                    out.push(c);
                    if c == ']' {
                        break;
                    }
                }
            }
            '[' => {
                in_class = true;
                out.push(c);
            }
            ']' => {
                in_class = false;
                out.push(c);
            }
            // A dot does not take line ends, of which the crate knows one.
            '.' if !in_class => out.push_str(r"[^\n\r]"),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matches_as_the_reference_does() {
        for (subject, pattern, full, search_) in [
            ("foo", "f", false, true),
            ("foo", "f[Oo]{2}", true, true),
            ("foo", ".*o", true, true),
            ("foobar.baz", "bark", false, false),
            ("a&b", "[&[]", false, true),
            ("ab1", "[[:alpha:]]+\\d", true, true),
            ("x", "(", false, false),
        ] {
            assert_eq!(search(subject, pattern, true, 0).0, full, "{subject} {pattern}");
            assert_eq!(search(subject, pattern, false, 0).0, search_, "{subject} {pattern}");
        }
        let (found, offsets) = search("foobar.baz", "(f[Oo]{2}).*(.az)", false, 8);
        assert!(found);
        assert_eq!(offsets, [0, 10, 0, 3, 7, 10, 17, 17]);
    }
}
