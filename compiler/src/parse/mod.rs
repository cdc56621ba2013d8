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

pub use dump::dump;

use crate::ast;
use crate::diag::Diagnostic;
use crate::preprocess::Preprocessed;
use grammar::{Grammar, Rule};
use pest::Parser;

/// Stack that parsing and everything after it may need for the deepest input that [`parse`] accepts, in bytes.
pub const STACK_BYTES: usize = 512 << 20;

/// Parses a preprocessed file.
///
/// The caller provides a stack of [`STACK_BYTES`] when the input may be hostile; deeper nesting than it carries is an error.
pub fn parse(pre: &Preprocessed) -> Result<ast::File, Vec<Diagnostic>> {
    depth::limit(pre).map_err(|d| vec![d])?;
    let mut pairs = Grammar::parse(Rule::file, &pre.text).map_err(|e| vec![message::describe(&e, pre)])?;
    // The grammar's start rule yields exactly one pair.
    let Some(file) = pairs.next() else { return Ok(ast::File::default()) };
    build::Builder::new(pre).file(file)
}
