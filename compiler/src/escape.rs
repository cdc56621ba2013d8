//! Escape sequences of strings in OSL sources and compiled shaders: some of C's.
//!
//! In: texts. Out: texts with sequences, and back. It must not know what they are for.

/// A string's inside with what cannot stand in one line escaped.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            '\u{b}' => out.push_str("\\v"),
            '\u{8}' => out.push_str("\\b"),
            '\r' => out.push_str("\\r"),
            '\u{c}' => out.push_str("\\f"),
            '\u{7}' => out.push_str("\\a"),
            '\\' | '"' => {
                out.push('\\');
                out.push(c);
            }
            c => out.push(c),
        }
    }
    out
}

/// Takes [`escape`] back; also octal escapes. A backslash before any other character stays, as in the reference implementation: regular
/// expressions have many.
pub fn unescape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        if c != '\\' {
            out.push(c);
            continue;
        }
        match chars.next() {
            Some('n') => out.push('\n'),
            Some('t') => out.push('\t'),
            Some('v') => out.push('\u{b}'),
            Some('b') => out.push('\u{8}'),
            Some('r') => out.push('\r'),
            Some('f') => out.push('\u{c}'),
            Some('a') => out.push('\u{7}'),
            Some(digit @ '0'..='7') => {
                let mut code = digit as u32 - '0' as u32;
                for _ in 0..2 {
                    match chars.peek() {
                        Some(d @ '0'..='7') => code = code * 8 + (*d as u32 - '0' as u32),
                        _ => break,
                    }
                    chars.next();
                }
                out.extend(char::from_u32(code));
            }
            Some(other @ ('\\' | '"')) => out.push(other),
            Some(other) => out.extend(['\\', other]),
            None => out.push('\\'),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_go_both_ways() {
        let text = "I have\n\"Escape\"\tsequences\\ \u{7}\u{8}\r\u{b}\u{c} ü";
        assert_eq!(unescape(&escape(text)), text);
        assert_eq!(unescape("\\101\\x\\.\\"), "A\\x\\.\\");
    }
}
