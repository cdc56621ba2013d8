//! Writes a shader as readable OpenCL C 1.2.
//!
//! In: verified IR after `passes` (no closure values, lobe slots instead). Out: [`Code`]: one function, the `#include`s it
//! needs, and its tables. No generic address space, no variables at program scope but `__constant` tables. It must know
//! neither the syntax tree nor another back end.
//!
//! Kernel functions that the text calls, besides `osl_NAME_RET_ARGS` of the built-ins (kernels/osl/):
//!
//! | operator | int | float | triple | matrix |
//! |---|---|---|---|---|
//! | `+ - *`, unary `-` | `op_add_i op_sub_i op_mul_i op_neg_i` | C's | C's | `op_mul_m`, `op_neg_m` |
//! | `/` | `op_div_i` | `op_div_f` | `op_div_v` | `op_div_m` |
//! | `%` | `op_rem_i` | | | |
//! | `<< >>` | `op_shl_i op_shr_i` | | | |
//! | `== !=` | C's | C's | `op_eq_v` | `op_eq_m` |
//! | `?:` | C's | C's | `op_select_v` | `op_select_m` |
//! | component | | | `.x .y .z`, `op_get_v op_set_v` | `op_get_m op_set_m` |
//! | conversion | `op_int_f` (from float) | `(real)` | `(real3)` | `op_matrix_f` (diagonal), `make_mat4` |
//! | table in constant memory | | | `vload3` | `op_load_m` |
//!
//! They stand in kernels/osl/ops.h and kernels/osl/matrix.h. Division by a constant that is neither 0 nor -1 (ints) is C's.
//!
//! Codes: `E4201` two strings with one id, `E4202` control flow nested too deeply, `E4203` no such output parameter, `E4204`
//! an output that is no number, `E4299` IR that the passes should have refused.

mod arrays;
mod entry;
mod inputs;
mod inst;
mod literal;
mod lobes;
mod records;
mod stmt;
mod writer;

use super::{Entry, Output};
use crate::diag::Diagnostic;
use crate::ir::Shader;
use crate::messages::Site;
use crate::source::SourceMap;

/// What [`emit`] writes.
#[derive(Clone, Debug, PartialEq)]
pub struct Code {
    /// Name of the function.
    pub entry: String,
    /// The text: `#include`s, tables, the function.
    pub text: String,
    /// The headers that the text includes, relative to kernels/, in order.
    pub includes: Vec<String>,
    /// Of a grid function.
    pub outputs: Vec<Output>,
    /// The calls that print, by the number in their records.
    pub sites: Vec<Site>,
    /// The texts of the strings that the text holds, sorted.
    pub strings: Vec<String>,
}

/// Writes a shader. With `lines`, `#line` directives lead from the text back to the OSL source.
pub fn emit(shader: &Shader, entry: &Entry, lines: Option<&SourceMap>) -> Result<Code, Vec<Diagnostic>> {
    let _span = tracing::debug_span!("emit", shader = shader.name).entered();
    match entry {
        Entry::Material => entry::material(shader, lines),
        Entry::Grid(outputs) => entry::grid(shader, outputs, lines),
    }
}
