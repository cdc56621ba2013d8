//! Compiles Open Shading Language to OpenCL C. See docs/ARCHITECTURE.md for the map.

#![forbid(unsafe_code)]

pub mod ast;
pub mod builtins;
pub mod diag;
pub mod ir;
pub mod parse;
pub mod preprocess;
pub mod source;
pub mod types;
