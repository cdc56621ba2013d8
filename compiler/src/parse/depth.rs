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

/// `else if` in a row.
const MAX_ELSE: usize = 2_000;

pub(super) fn limit(pre: &Preprocessed) -> Result<(), Diagnostic> {
    let bytes = pre.text.as_bytes();
    // Operators since the last `;`, `,` or brace, per open bracket.
    let mut operators = vec![0usize];
    let mut elses = 0;
    let mut headers_since_else = 0;
    let mut i = 0;
    while i < bytes.len() {
        let start = i;
        let byte = bytes[i];
        i += 1;
        match byte {
            b'"' => {
                while i < bytes.len() && bytes[i] != b'"' {
                    i += if bytes[i] == b'\\' { 2 } else { 1 };
                }
                i += 1;
            }
            b'(' | b'[' | b'{' => {
                operators.push(0);
                if operators.len() > MAX_BRACKETS {
                    return Err(too_deep(pre, start, "brackets are", MAX_BRACKETS));
                }
            }
            b')' | b']' | b'}' => {
                if operators.len() > 1 {
                    operators.pop();
                }
                if byte == b'}' {
                    reset(&mut operators);
                }
            }
            b';' | b',' => reset(&mut operators),
            b'+' | b'-' | b'*' | b'/' | b'%' | b'!' | b'~' | b'<' | b'>' | b'=' | b'&' | b'|' | b'^' | b'?' | b'.' => {
                if let Some(count) = operators.last_mut() {
                    *count += 1;
                    if *count > MAX_OPERATORS {
                        return Err(too_deep(pre, start, "operators of one expression are", MAX_OPERATORS));
                    }
                }
            }
            b'a'..=b'z' | b'A'..=b'Z' | b'_' => {
                while i < bytes.len() && (bytes[i].is_ascii_alphanumeric() || bytes[i] == b'_') {
                    i += 1;
                }
                match &bytes[start..i] {
                    // An `else` continues the chain of the one before unless a fresh `if` chain started between them;
                    // counting those in blocks of the chain too only makes the limit stricter.
                    b"else" => {
                        elses += 1;
                        headers_since_else = 0;
                    }
                    b"if" | b"for" | b"while" | b"do" => {
                        headers_since_else += 1;
                        if headers_since_else > 1 {
                            elses = 0;
                        }
                        if headers_since_else > MAX_ELSE {
                            return Err(too_deep(pre, start, "statements are", MAX_ELSE));
                        }
                    }
                    b"not" | b"and" | b"or" => {
                        if let Some(count) = operators.last_mut() {
                            *count += 1;
                        }
                    }
                    _ => {}
                }
                if elses > MAX_ELSE {
                    return Err(too_deep(pre, start, "`else` branches are", MAX_ELSE));
                }
            }
            _ => {}
        }
        // Headers without a statement between them (`if (a) if (b) ...`) nest; others do not.
        if byte == b';' {
            headers_since_else = headers_since_else.min(1);
        }
    }
    Ok(())
}

fn reset(operators: &mut [usize]) {
    if let Some(count) = operators.last_mut() {
        *count = 0;
    }
}

fn too_deep(pre: &Preprocessed, at: usize, what: &str, limit: usize) -> Diagnostic {
    Diagnostic::error("E1002", pre.span(at, at + 1), format!("nested too deeply: {what} limited to {limit}"))
        .help("split the expression or move parts into functions or variables")
}
