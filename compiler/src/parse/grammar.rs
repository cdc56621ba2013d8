//! The parser that pest generates from `grammar.pest`.

#![allow(missing_docs)] // Generated items.

#[derive(pest_derive::Parser)]
#[grammar = "parse/grammar.pest"]
pub struct Grammar;
