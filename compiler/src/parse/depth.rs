//! Refuses input that nests deeper than recursive passes can follow, before any of them starts.
//!
//! One scan over the text counts what makes the grammar or the tree recurse: brackets, prefix operators in a row,
//! operators in one statement (a left-deep tree), `else` branches in a row.

use crate::diag::Diagnostic;
use crate::preprocess::Preprocessed;

/// Brackets inside each other.
const MAX_BRACKETS: usize = 1_000;

/// Operators of one statement at one bracket level.
const MAX_OPERATORS: usize = 10_000;

/// `else` branches, or headers, in a row.
const MAX_ELSE: usize = 2_000;

pub(super) fn limit(pre: &Preprocessed) -> Result<(), Diagnostic> {
    let bytes = pre.text.as_bytes();
    // Per open bracket: which, and operators in it since the last `;`, `,` or brace.
    let mut open = vec![(b'{', 0usize)];
    // `else` in the present chain of branches, and headers (`if (a) while (b) ...`) without a statement between them.
    let (mut elses, mut headers) = (0, 0);
    // The last byte before the present token that is no blank.
    let mut last = b';';
    let mut i = 0;
    while i < bytes.len() {
        let start = i;
        let byte = bytes[i];
        i += 1;
        match byte {
            b' ' | b'\t' | b'\r' | b'\n' => continue,
            b'"' => {
                while i < bytes.len() && bytes[i] != b'"' {
                    i += if bytes[i] == b'\\' { 2 } else { 1 };
                }
                i += 1;
            }
            b'(' | b'[' | b'{' => {
                // `a[0][0]...` is as deep a tree as `a.x.x...`.
                if byte == b'[' {
                    count_operator(pre, &mut open, start)?;
                }
                open.push((byte, 0));
                if open.len() > MAX_BRACKETS {
                    return Err(too_deep(pre, start, "brackets are", MAX_BRACKETS));
                }
            }
            b')' | b']' | b'}' => {
                if open.len() > 1 {
                    open.pop();
                }
                if byte == b'}' {
                    reset(&mut open);
                }
            }
            b';' | b',' => {
                reset(&mut open);
                // Not the `;` of a `for (;;)`.
                if byte == b';' && open.last().is_some_and(|(bracket, _)| *bracket == b'{') {
                    headers = 0;
                }
            }
            b'+' | b'-' | b'*' | b'/' | b'%' | b'!' | b'~' | b'<' | b'>' | b'=' | b'&' | b'|' | b'^' | b'?' | b'.' => {
                count_operator(pre, &mut open, start)?;
            }
            b'a'..=b'z' | b'A'..=b'Z' | b'_' => {
                while i < bytes.len() && (bytes[i].is_ascii_alphanumeric() || bytes[i] == b'_') {
                    i += 1;
                }
                match &bytes[start..i] {
                    b"else" => {
                        elses += 1;
                        headers = 0;
                        if elses > MAX_ELSE {
                            return Err(too_deep(pre, start, "`else` branches are", MAX_ELSE));
                        }
                    }
                    b"if" | b"for" | b"while" | b"do" => {
                        // A header where a statement starts, and not behind `else`, begins a new chain.
                        if matches!(last, b';' | b'{' | b'}') {
                            (elses, headers) = (0, 0);
                        }
                        headers += 1;
                        if headers > MAX_ELSE {
                            return Err(too_deep(pre, start, "statements are", MAX_ELSE));
                        }
                    }
                    b"not" | b"and" | b"or" => count_operator(pre, &mut open, start)?,
                    _ => {}
                }
            }
            _ => {}
        }
        last = byte;
    }
    Ok(())
}

fn count_operator(pre: &Preprocessed, open: &mut [(u8, usize)], at: usize) -> Result<(), Diagnostic> {
    if let Some((_, count)) = open.last_mut() {
        *count += 1;
        if *count > MAX_OPERATORS {
            return Err(too_deep(pre, at, "operators of one expression are", MAX_OPERATORS));
        }
    }
    Ok(())
}

fn reset(open: &mut [(u8, usize)]) {
    if let Some((_, count)) = open.last_mut() {
        *count = 0;
    }
}

fn too_deep(pre: &Preprocessed, at: usize, what: &str, limit: usize) -> Diagnostic {
    Diagnostic::error("E1002", pre.span(at, at + 1), format!("nested too deeply: {what} limited to {limit}"))
        .help("split the expression or move parts into functions or variables")
}
