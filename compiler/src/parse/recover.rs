//! Goes on after a syntax error: which part of the text to leave out so that the rest can be read.
//!
//! In: the text and the byte at which the grammar gave up. Out: the bytes of the statement, declaration or parameter around
//! it. What is left out becomes blanks, so that all other bytes keep their places. It must not know the tree.

use std::ops::Range;

/// What opens a nested part.
#[derive(Clone, Copy, PartialEq)]
enum Open {
    /// `{` of statements, or the file itself.
    Block,
    /// `{` of a list of values.
    List,
    /// `(`
    Paren,
    /// `[`
    Bracket,
}

/// A part that is open.
struct Level {
    open: Open,
    /// Where its present statement, parameter or value starts.
    start: usize,
}

/// One token: its bytes, and what it is.
struct Token<'a> {
    at: usize,
    text: &'a str,
}

/// Tokens as far as brackets and words go; other signs come one by one.
fn tokens(text: &str, from: usize) -> impl Iterator<Item = Token<'_>> {
    let bytes = text.as_bytes();
    let mut i = from;
    std::iter::from_fn(move || {
        while bytes.get(i).is_some_and(u8::is_ascii_whitespace) {
            i += 1;
        }
        let at = i;
        match *bytes.get(i)? {
            b'"' => {
                i += 1;
                while i < bytes.len() && bytes[i] != b'"' && bytes[i] != b'\n' {
                    i += if bytes[i] == b'\\' { 2 } else { 1 };
                }
                i = (i + 1).min(bytes.len());
                while !text.is_char_boundary(i) {
                    i += 1;
                }
            }
            b if b.is_ascii_alphanumeric() || b == b'_' => {
                while bytes.get(i).is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_') {
                    i += 1;
                }
            }
            _ => i += text[i..].chars().next().map_or(1, char::len_utf8),
        }
        Some(Token { at, text: &text[at..i] })
    })
}

/// Whether a `{` behind this word, in a part of this kind, opens a list.
fn opens_list(before: &str, inside: Open) -> bool {
    matches!(before, "=" | "return") || inside != Open::Block && matches!(before, "," | "(" | "{")
}

/// Whether the statement that starts with this word goes on with the next.
fn goes_on(first: &str, next: &str) -> bool {
    matches!((first, next), ("if", "else") | ("do", "while"))
}

/// The first word at or behind a byte.
fn word(text: &str, at: usize) -> &str {
    tokens(text, at).next().map_or("", |t| t.text)
}

/// The levels that are open at byte `at`, outermost first.
fn levels(text: &str, at: usize) -> Vec<Level> {
    let mut levels = vec![Level { open: Open::Block, start: 0 }];
    let mut before = "";
    for token in tokens(text, 0).take_while(|t| t.at < at) {
        let inside = levels.last().map_or(Open::Block, |l| l.open);
        let end = token.at + token.text.len();
        let push = |levels: &mut Vec<Level>, open| levels.push(Level { open, start: end });
        match token.text {
            "{" if opens_list(before, inside) => push(&mut levels, Open::List),
            "{" => push(&mut levels, Open::Block),
            "(" => push(&mut levels, Open::Paren),
            "[" => push(&mut levels, Open::Bracket),
            ")" | "]" if matches!(inside, Open::Paren | Open::Bracket) => {
                levels.pop();
            }
            "}" => {
                // What is still open inside ends with it.
                while levels.len() > 1
                    && matches!(levels.last(), Some(l) if l.open != Open::Block && inside != Open::List)
                {
                    levels.pop();
                }
                if levels.len() > 1 {
                    levels.pop();
                }
                if let Some(level) = levels.last_mut().filter(|l| l.open == Open::Block && inside != Open::List)
                    && !goes_on(word(text, level.start), word(text, end))
                {
                    level.start = end;
                }
            }
            ";" if inside == Open::Block => levels.last_mut().into_iter().for_each(|l| l.start = end),
            "," if inside == Open::Paren => levels.last_mut().into_iter().for_each(|l| l.start = end),
            _ => {}
        }
        before = token.text;
    }
    levels
}

/// The bytes to leave out around an error at byte `at`. Empty at the end of the text.
pub(super) fn region(text: &str, at: usize) -> Range<usize> {
    let levels = levels(text, at);
    // A parameter of a function or shader of the file: the others and the body are worth reading.
    if let [file, params, ..] = levels.as_slice()
        && file.open == Open::Block
        && params.open == Open::Paren
        && let Some(end) = parameter_end(text, at, levels.len() - 2)
    {
        return params.start..end;
    }
    let block = levels.iter().rposition(|l| l.open == Open::Block).unwrap_or(0);
    let start = levels[block].start;
    start..statement_end(text, start, at, &levels[block + 1..])
}

/// Behind the `,`, or before the `)`, that ends the parameter around `at`; `depth` parts are open in it.
fn parameter_end(text: &str, at: usize, mut depth: usize) -> Option<usize> {
    for token in tokens(text, at) {
        match token.text {
            "(" | "[" => depth += 1,
            "{" if depth > 0 => depth += 1,
            ")" if depth == 0 => return Some(token.at),
            "," if depth == 0 => return Some(token.at + 1),
            ")" | "]" | "}" if depth > 0 => depth -= 1,
            "{" | "}" | "]" | ";" => return None,
            _ => {}
        }
    }
    None
}

fn statement_end(text: &str, start: usize, at: usize, inner: &[Level]) -> usize {
    let first = word(text, start);
    let mut parens = inner.iter().filter(|l| l.open == Open::Paren).count();
    let mut lists = inner.iter().filter(|l| l.open == Open::List).count();
    // Semicolons between the parentheses of a `for`.
    let mut header =
        if first == "for" && parens > 0 { 2usize.saturating_sub(text[start..at].matches(';').count()) } else { 0 };
    let mut blocks = 0;
    let mut before = "";
    for token in tokens(text, at) {
        let end = token.at + token.text.len();
        match token.text {
            "(" => parens += 1,
            ")" => parens = parens.saturating_sub(1),
            "{" if blocks == 0 && opens_list(before, if parens > 0 { Open::Paren } else { Open::Block }) => lists += 1,
            "{" if lists > 0 => lists += 1,
            "{" => blocks += 1,
            "}" if lists > 0 => lists -= 1,
            "}" if blocks == 0 => return token.at.max(start),
            "}" => {
                blocks -= 1;
                if blocks == 0 && !goes_on(first, word(text, end)) {
                    return end;
                }
            }
            ";" if blocks == 0 && header > 0 && parens > 0 => header -= 1,
            ";" if blocks == 0 && !goes_on(first, word(text, end)) => return end,
            _ => {}
        }
        before = token.text;
    }
    text.len()
}

/// Whether what stands at a byte is no start of anything, but the rest of what was left out before it.
pub(super) fn is_rest(text: &str, at: usize) -> bool {
    let next = word(text, at);
    matches!(next, "else" | "while") || !next.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
}

/// Leaves a part of the text out; false when there was nothing but blanks.
pub(super) fn blank(text: &mut String, region: Range<usize>) -> bool {
    let part = &text[region.clone()];
    if part.trim().is_empty() {
        return false;
    }
    let blanks: String = part.bytes().map(|b| if b == b'\n' { '\n' } else { ' ' }).collect();
    text.replace_range(region, &blanks);
    true
}

/// The words of a part of the text: names that may have been declared there.
pub(super) fn names(text: &str, region: Range<usize>) -> impl Iterator<Item = &str> {
    tokens(&text[..region.end], region.start)
        .map(|t| t.text)
        .filter(|t| t.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_'))
}

/// As many `}` as close what is open at the end of the text.
pub(super) fn closing(text: &str) -> String {
    let open = levels(text, text.len());
    open.iter()
        .skip(1)
        .rev()
        .map(|l| match l.open {
            Open::Block | Open::List => '}',
            Open::Paren => ')',
            Open::Bracket => ']',
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text without the region around the first `@`.
    fn check(input: &str, rest: &str) {
        let at = input.find('@').expect("the test marks a place");
        let mut text = input.to_string();
        blank(&mut text, region(input, at));
        let words: Vec<&str> = text.split_whitespace().collect();
        assert_eq!(words.join(" "), rest, "{input}");
    }

    #[test]
    fn leaves_out_the_statement_around() {
        check("shader s() { a; b @ c; d; }", "shader s() { a; d; }");
        check("shader s() { a; b = f(1, {2 @}, 3); d; }", "shader s() { a; d; }");
        check("shader s() { if (a @) { b; } else { c; } d; }", "shader s() { d; }");
        check("shader s() { if (a) { b; @ } c; }", "shader s() { if (a) { b; } c; }");
        check("shader s() { for (i = 0; i @; i++) { b; } c; }", "shader s() { c; }");
        check("shader s() { do { b; } while (@); c; }", "shader s() { c; }");
        check("shader s() { float a[2] = {1 @ 2}; c; }", "shader s() { c; }");
        check("struct S { float a; int @; float b; }; c", "struct S { float a; float b; }; c");
        check("float f() { a; } float @; float g() { b; }", "float f() { a; } float g() { b; }");
    }

    #[test]
    fn leaves_out_the_parameter_around() {
        check("shader s(float a = 1, int @ = 2, int c = 3) { d; }", "shader s(float a = 1, int c = 3) { d; }");
        check("shader s(float a = f(1, 2) @) { d; }", "shader s( ) { d; }");
        check("shader s(float a = 1 [[int b = 1, int @]], int c = 3) { d; }", "shader s( int c = 3) { d; }");
    }
}
