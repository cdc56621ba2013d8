//! Compiles Open Shading Language to OpenCL C. See docs/ARCHITECTURE.md for the map.

#![forbid(unsafe_code)]

pub mod ast;
pub mod builtins;
pub mod check;
pub mod diag;
pub mod interp;
pub mod ir;
pub mod lower;
pub mod parse;
pub mod passes;
pub mod preprocess;
pub mod reflect;
pub mod source;
pub mod suggest;
pub mod types;
