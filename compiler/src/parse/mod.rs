//! Parses preprocessed OSL to the syntax tree.
//!
//! In: [`Preprocessed`] text. Out: [`ast::File`], or syntax errors. No pest type leaves this module; it must know neither
//! types nor the IR.
//!
//! Codes: `E1001` unexpected token, `E1002` nested too deeply, `E1003` integer out of range,
//! `E1005` reserved word.

mod build;
mod depth;
mod dump;
mod grammar;
mod message;
mod recover;

pub use dump::dump;

use crate::ast;
use crate::diag::Diagnostic;
use crate::preprocess::Preprocessed;
use grammar::{Grammar, Rule};
use pest::Parser;

/// Stack that parsing and everything after it may need for the deepest input that [`parse`] accepts, in bytes.
pub const STACK_BYTES: usize = 512 << 20;

/// What was read of a file, errors or not.
#[derive(Clone, Debug, Default)]
pub struct Parsed {
    /// The tree, without what could not be read.
    pub file: ast::File,
    /// Syntax errors.
    pub errors: Vec<Diagnostic>,
}

/// Most syntax errors of one run.
const MAX_ERRORS: usize = 20;

/// Most bytes read over and over after syntax errors.
const MAX_AGAIN: usize = 8 << 20;

/// Parses a preprocessed file; the first syntax errors when there are some.
///
/// The caller provides a stack of [`STACK_BYTES`] when the input may be hostile; deeper nesting than it carries is an error.
pub fn parse(pre: &Preprocessed) -> Result<ast::File, Vec<Diagnostic>> {
    let parsed = recover(pre);
    if parsed.errors.is_empty() { Ok(parsed.file) } else { Err(parsed.errors) }
}

/// As [`parse`], and goes on after errors: the statement or parameter around each is left out, and the names in it are
/// [`ast::File::broken`].
pub fn recover(pre: &Preprocessed) -> Parsed {
    let mut parsed = Parsed::default();
    if let Err(d) = depth::limit(pre) {
        parsed.errors.push(d);
        return parsed;
    }
    let Err(first) = read(pre, &pre.text, &mut parsed) else { return parsed };
    let mut error = first;
    let mut text = pre.text.clone();
    let mut broken = std::collections::BTreeSet::new();
    // Behind what was left out last: an error right there follows from it.
    let mut behind = None;
    for _ in 0..(MAX_AGAIN / text.len().max(1)).clamp(1, 2 * MAX_ERRORS) {
        let at = message::place(&error);
        let follows = behind.is_some_and(|b: usize| b <= at && text[b..at].trim().is_empty());
        if !(follows && recover::is_rest(&text, at)) {
            parsed.errors.push(message::describe(&error, pre, &text));
        }
        if parsed.errors.len() >= MAX_ERRORS {
            break;
        }
        let region = recover::region(&text, at);
        broken.extend(recover::names(&text, region.clone()).map(str::to_string));
        behind = Some(region.end);
        if !recover::blank(&mut text, region) {
            let closing = recover::closing(&text);
            if closing.is_empty() {
                break;
            }
            text.push_str(&closing);
        }
        match read(pre, &text, &mut parsed) {
            Ok(()) => {
                parsed.file.broken = broken.into_iter().collect();
                return parsed;
            }
            Err(next) => error = next,
        }
    }
    // What is left can't be made sense of.
    parsed.file = ast::File::default();
    parsed
}

/// Reads a text of the same places as `pre.text`.
fn read(pre: &Preprocessed, text: &str, parsed: &mut Parsed) -> Result<(), Box<pest::error::Error<Rule>>> {
    let mut pairs = Grammar::parse(Rule::file, text).map_err(Box::new)?;
    // The grammar's start rule yields exactly one pair.
    let Some(file) = pairs.next() else { return Ok(()) };
    let (file, problems) = build::Builder::new(pre).file(file);
    parsed.file = file;
    parsed.errors.extend(problems);
    Ok(())
}
