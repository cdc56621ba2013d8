//! What leaves the compiler: code, entry point, and what the code needs of a renderer.
//!
//! In: optimised IR, its code, the reflection. Out: [`Artifact`], also as JSON for tools and as [`Stored`] for files. It must not know how the code was
//! written.

mod effects;
mod inputs;
mod stored;
pub(crate) mod uses;

pub use effects::{Radiance, State};
pub use inputs::{Inputs, Slot};
pub use stored::{Inconsistent, Stored};
pub use uses::{Control, Use};

use crate::backend::Output;
use crate::backend::opencl_c::Code;
use crate::backend::spirv::Spirv;
use crate::ir::Shader;
use crate::messages::{Decoder, Site};
use crate::passes::{self, TextureUse, Traces};
use crate::reflect::ShaderInfo;
use serde::{Deserialize, Serialize};

/// Version of the interface between artifacts and kernels (kernels/lobe.h, kernels/globals.h, kernels/osl/). A renderer
/// refuses artifacts of another one.
pub const ABI_VERSION: u32 = 2;

/// A compiled shader.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Artifact {
    /// [`ABI_VERSION`] of the compiler that made it.
    pub abi_version: u32,
    /// The shader's name in OSL.
    pub name: String,
    /// `surface`, `displacement`, `volume` or `shader`.
    pub kind: String,
    /// Name of the function in `code`; differs between shaders and between instances of one shader.
    pub entry: String,
    /// OpenCL C 1.2, with `#include`s of kernel headers.
    pub code: String,
    /// The headers that `code` includes, relative to kernels/.
    pub includes: Vec<String>,
    /// The same as SPIR-V, where [`crate::Options::spirv`] asks for it. Not part of the JSON form: its words are files of their own.
    #[serde(skip)]
    pub spirv: Option<Spirv>,
    /// Names of the lobe types that can occur (`LOBE_*` of kernels/lobe.h in small letters), sorted, each once; `thin_film` when
    /// one of them can lie under a film.
    pub lobes: Vec<String>,
    /// Names of the closures for media that can occur, sorted, each once.
    pub volumes: Vec<String>,
    /// Fields of `ShaderGlobals` that the code reads: OSL's names of the globals.
    #[serde(deserialize_with = "stored::globals")]
    pub globals: Vec<&'static str>,
    /// What else of the renderer's state it reads.
    pub state: State,
    /// Noise kinds in use: `perlin`, `uperlin`, `cell`, `hash`, `simplex`, `usimplex`.
    pub noise: Vec<String>,
    /// Texture files that it can look up, by name.
    pub textures: Vec<TextureUse>,
    /// Point clouds that it can look into, by name. When there are any, the code needs what kernels/osl/points.h says.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub point_clouds: Vec<String>,
    /// What it asks of rays that it traces itself. When there are any, the code needs what kernels/osl/trace.h says.
    #[serde(default, skip_serializing_if = "Traces::is_empty")]
    pub traces: Traces,
    /// Radiance that it emits; on which side is for the renderer to say.
    pub emission: Radiance,
    /// Radiance of the environment.
    pub background: Radiance,
    /// Whether light can pass straight on.
    pub has_transparent: bool,
    /// Whether it can cut holes into alpha.
    pub has_holdout: bool,
    /// Outputs of a grid function, in order; empty for materials.
    pub outputs: Vec<Output>,
    /// What the renderer supplies beside the globals.
    pub inputs: Inputs,
    /// The calls that print, by the number in their records. When there are any, the code needs `HAS_MESSAGES` defined and
    /// the records' buffer in `ShaderGlobals` (kernels/osl/records.h).
    pub sites: Vec<Site>,
    /// The texts of the strings in the code, sorted.
    pub strings: Vec<String>,
    /// Where the shader uses what a renderer has to provide.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub uses: Vec<Use>,
    /// Parameters, defaults and metadata as written; of a group those of its last layer.
    pub info: ShaderInfo,
}

impl Artifact {
    /// Puts together what the back end wrote with what the IR tells.
    pub fn new(shader: &Shader, code: Code, info: ShaderInfo) -> Artifact {
        let effects = effects::of(shader);
        Artifact {
            abi_version: ABI_VERSION,
            name: shader.name.clone(),
            kind: shader.kind.clone(),
            entry: code.entry,
            code: code.text,
            includes: code.includes,
            spirv: None,
            lobes: effects.lobes,
            volumes: effects.volumes,
            globals: effects.globals,
            state: effects.state,
            noise: effects.noise,
            // Names that are not known were refused by the passes.
            textures: passes::textures(shader).unwrap_or_default(),
            point_clouds: passes::clouds(shader).unwrap_or_default(),
            traces: passes::traces(shader).unwrap_or_default(),
            emission: effects.emission,
            background: effects.background,
            has_transparent: effects.transparent,
            has_holdout: effects.holdout,
            outputs: code.outputs,
            inputs: inputs::of(shader),
            sites: code.sites,
            strings: inputs::strings(shader, code.strings),
            uses: Vec::new(),
            info,
        }
    }

    /// What turns the records that the code writes into messages. `more`: strings from elsewhere that may be among them.
    pub fn decoder<'a>(&'a self, more: impl IntoIterator<Item = &'a String>) -> Decoder<'a> {
        Decoder::new(&self.sites, self.strings.iter().chain(more))
    }

    /// As indented JSON: an object with the fields of [`Artifact`]. `emission` and `background` are `"none"`, `"varying"` or
    /// `{"constant": [r, g, b]}`; values in `info` have the shapes of [`crate::reflect`]; numbers that JSON cannot hold
    /// (infinities) are `null`.
    pub fn to_json(&self) -> String {
        // Serialising to memory fails only for maps with keys that are no strings, and there are no maps here.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}
