//! Back ends: verified IR to the code of a target.
//!
//! A back end knows the IR, the table of built-ins, and what back ends share: `analysis` of uses, names and headers of the
//! kernels' functions, the list of outputs. It must know neither the syntax tree nor another back end.

mod analysis;
mod entry;
mod headers;
pub(crate) mod lobes;
mod names;
pub mod opencl_c;
mod slots;
pub mod spirv;

pub use crate::strings::string_id;
pub use entry::{Entry, Output, listed as outputs};
