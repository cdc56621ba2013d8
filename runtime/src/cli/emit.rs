//! The forms of a compiled shader that `oslcl compile --emit` names, as files.
//!
//! In: a shader's artifact, or what another one is made of. Out: endings and bytes. It must not know where files go.

use super::args::EmitArg;
use oslcl_compiler::{Artifact, Failure, Master, Options};
use oslcl_runtime::assemble;
use oslcl_runtime::device::Device;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::roads::{self, tools};
use oslcl_runtime::shade;
use oslcl_runtime::textures;
use std::fmt::Write;

/// All forms, in the order in which their files are named.
pub(super) const KINDS: [EmitArg; 6] =
    [EmitArg::Opencl, EmitArg::Spirv, EmitArg::Bitcode, EmitArg::Binary, EmitArg::Ir, EmitArg::Json];

/// The ending of a form's file, by which a command line can ask for it.
pub(super) fn ending(kind: EmitArg) -> &'static str {
    match kind {
        EmitArg::Opencl => "cl",
        EmitArg::Spirv => "spv",
        EmitArg::Bitcode => "bc",
        EmitArg::Binary => "bin",
        EmitArg::Ir => "ir",
        EmitArg::Json => "json",
    }
}

/// Why a form cannot be had.
pub(super) enum Error {
    /// The shader does not compile for it.
    Compile(Failure),
    /// Anything else.
    Other(super::Error),
}

impl std::convert::From<shade::Error> for Error {
    fn from(e: shade::Error) -> Error {
        Error::Other(e.into())
    }
}

/// Where a shader comes from.
pub(super) enum From<'a> {
    /// A source, with these settings.
    Source(&'a Master, &'a Options),
    /// A package.
    Package,
}

/// A shader on its way to files.
pub(super) struct Job<'a> {
    pub from: From<'a>,
    pub artifact: &'a Artifact,
    pub precision: Precision,
    pub device: Option<&'a Device>,
}

impl Job<'_> {
    /// The files of a form: endings and bytes.
    pub(super) fn write(&self, kind: EmitArg) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        Ok(match kind {
            EmitArg::Opencl => vec![(".cl", self.text(&self.artifact.code)?.into_bytes())],
            EmitArg::Json => vec![(".json", self.artifact.to_json().into_bytes())],
            EmitArg::Ir => {
                let (master, options) = self.source("the intermediate representation")?;
                vec![(".ir", master.ir(options).map_err(Error::Compile)?.into_bytes())]
            }
            EmitArg::Spirv => {
                let (words, bridge) = self.spirv()?;
                let bytes = words.iter().flat_map(|w| w.to_le_bytes()).collect();
                vec![(".spv", bytes), (".spv.cl", bridge.into_bytes())]
            }
            EmitArg::Bitcode => {
                let (words, bridge) = self.spirv()?;
                let options = self.precision.build_options();
                let linked = tools::find("", tools::Purpose::File)
                    .and_then(|t| t.link(&self.artifact.name, &bridge, options, &[words]));
                vec![(".bc", linked.map_err(|e| Error::Other(roads::Error::from(e).into()))?)]
            }
            EmitArg::Binary => {
                // The command opens a device when a binary is asked for.
                let Some(device) = self.device else { return Ok(Vec::new()) };
                let (master, options) = self.source("a device's binary")?;
                let outputs = shade::default_outputs(master.info());
                let artifact = shade::compile(master, options, &outputs).map_err(Error::Compile)?;
                let program = shade::build(device, &artifact, self.precision, &shade::Supplies::default())?;
                vec![(".bin", program.binary(device).map_err(shade::Error::from)?)]
            }
        })
    }

    fn source(&self, what: &str) -> Result<(&Master, &Options), Error> {
        match self.from {
            From::Source(master, options) => Ok((master, options)),
            From::Package => Err(Error::Other(super::Error::Usage(format!(
                "{what} is made of a source, which a package does not have"
            )))),
        }
    }

    /// The module, and the text that it is linked with.
    fn spirv(&self) -> Result<(&[u32], String), Error> {
        let module = roads::module(self.artifact, self.precision).unwrap_or_default();
        Ok((module, self.text(roads::text(self.artifact))?))
    }

    fn text(&self, code: &str) -> Result<String, Error> {
        standalone(self.artifact, code).map_err(|e| Error::Other(super::Error::Shade(e.into())))
    }
}

/// The code with every header in place, and how to build it.
fn standalone(artifact: &Artifact, code: &str) -> Result<String, assemble::Error> {
    let mut head = format!(
        "// {} {}: function {}. The interface stands at `typedef struct ... ShadeResult` below.\n// Build options: {}, or for \
         64-bit floats: {}\n",
        artifact.kind,
        artifact.name,
        artifact.entry,
        Precision::Standard.build_options(),
        Precision::Reference.build_options()
    );
    for name in textures::macros(&artifact.textures) {
        let _ = writeln!(head, "#define {name}");
    }
    for lobe in &artifact.lobes {
        let _ = writeln!(head, "#define HAS_LOBE_{}", lobe.to_uppercase());
    }
    if artifact.state.derivatives {
        head.push_str("#define HAS_DERIVATIVES\n");
    }
    if !artifact.sites.is_empty() {
        head.push_str("#define HAS_MESSAGES\n");
    }
    assemble::assemble(&format!("{}.cl", artifact.entry), &(head + code))
}
