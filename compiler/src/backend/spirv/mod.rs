//! Writes a shader as a SPIR-V module, and the text that binds it to the kernels.
//!
//! In: verified IR after `passes` (no closure values, lobe slots instead), and the name of the function in OpenCL C. Out:
//! [`Spirv`]. It must know neither the syntax tree nor another back end. docs/adr/0019-spirv.md says why it is as it is.
//!
//! The module (SPIR-V 1.0; Kernel, Addresses, Linkage, Int8, Int64; Float64 in double precision; OpenCL.std) exports one
//! function `ENTRY_il` and imports those of the *bridge*, which are OpenCL C. Arithmetic, control flow, variables and tables are
//! instructions; kernels' structs and functions are the bridge's.
//!
//! Codes: `E4301` a call with more arguments than SPIR-V has, `E4302` an array too long for a constant, `E4303` a shader too
//! large for a module, `E4399` IR that the passes should have refused.

mod bridge;
mod entry;
mod inst;
mod lobes;
mod module;
mod records;
mod stmt;
mod words;
mod writer;

use super::Entry;
use crate::diag::Diagnostic;
use crate::ir::Shader;

/// The size of a `real` in a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Width {
    Single,
    Double,
}

impl Width {
    fn bits(self) -> u32 {
        match self {
            Width::Single => 32,
            Width::Double => 64,
        }
    }
}

/// A shader as SPIR-V.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Spirv {
    /// The module whose reals are 32-bit floats: words in the host's order.
    #[serde(with = "words")]
    pub single: Vec<u32>,
    /// The module whose reals are 64-bit floats.
    #[serde(with = "words")]
    pub double: Vec<u32>,
    /// OpenCL C that the module is linked with, in place of the artifact's code: what the module imports, and the
    /// artifact's entry, which calls it. In front of it belong the same macros.
    pub bridge: String,
    /// The headers that the bridge includes, relative to kernels/.
    pub includes: Vec<String>,
}

/// The name of a module's function.
fn exported(entry: &str) -> String {
    format!("{entry}_il")
}

/// Writes a shader; `name` is the entry's name in OpenCL C.
pub fn emit(shader: &Shader, entry: &Entry, name: &str) -> Result<Spirv, Vec<Diagnostic>> {
    let _span = tracing::debug_span!("emit SPIR-V", shader = shader.name).entered();
    let (single, bridge, includes) = entry::write(shader, entry, name, Width::Single)?;
    let (double, ..) = entry::write(shader, entry, name, Width::Double)?;
    Ok(Spirv { single, double, bridge, includes })
}
