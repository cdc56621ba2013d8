//! Back ends: verified IR to the text of a target.
//!
//! A back end knows the IR and the table of built-ins. It must know neither the syntax tree nor another back end.

pub mod opencl_c;

pub use crate::strings::string_id;
