//! How a material's code gets into a program: as OpenCL C in front of the kernels, or as a SPIR-V module that is linked with
//! them.
//!
//! In: an artifact; a program's whole text. Out: a built program. It must not know scenes or stages.
//!
//! An artifact that has SPIR-V ([`Artifact::spirv`]) goes that way: its text is the bridge, which stands where its code would,
//! and its module is linked with the program. A device that takes SPIR-V links itself (clCompileProgram, clLinkProgram); for one
//! that takes the bitcode of SPIR 1.2 LLVM's tools link before it sees anything ([`tools`]); others have no such road.

pub mod tools;

use crate::device::{self, Device, Program};
use crate::preamble;
use crate::precision::Precision;
use crate::scene::MaterialId;
use oslcl_compiler::Artifact;
use std::collections::HashMap;

/// The roads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Road {
    /// OpenCL C: every device.
    #[default]
    OpenClC,
    /// SPIR-V.
    Spirv,
}

/// Why there is no program.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The device refuses.
    #[error(transparent)]
    Device(#[from] device::Error),
    /// LLVM's tools are missing or refuse.
    #[error(transparent)]
    Tools(#[from] tools::Error),
    /// The device takes neither SPIR-V nor SPIR.
    #[error(
        "`{device}` takes no SPIR-V, nor the bitcode of SPIR 1.2 (cl_khr_spir)\n  help: leave out `--road spirv`, or name \
         a device that does: Intel's CPU runtime, PoCL"
    )]
    NoRoad {
        /// The device's name.
        device: String,
    },
}

/// The modules of a scene's programs.
pub type Modules<'a> = HashMap<MaterialId, &'a [u32]>;

/// The text that stands for an artifact in a program: its code, or what binds its SPIR-V module to the kernels.
pub fn text(artifact: &Artifact) -> &str {
    preamble::code(artifact)
}

/// The module that a program with the artifact's text is linked with.
pub fn module(artifact: &Artifact, precision: Precision) -> Option<&[u32]> {
    artifact.spirv.as_ref().map(|s| if precision.is_double() { &s.double[..] } else { &s.single[..] })
}

/// The modules of materials' artifacts.
pub fn modules(artifacts: &[Option<Artifact>], precision: Precision) -> Modules<'_> {
    let numbered = (0..).map(MaterialId).zip(artifacts);
    numbered.filter_map(|(id, artifact)| Some((id, module(artifact.as_ref()?, precision)?))).collect()
}

/// Whether programs can come to a device this way.
pub fn check(device: &Device, road: Road) -> Result<(), Error> {
    if road == Road::OpenClC || device.takes_spirv() {
        return Ok(());
    }
    if !device.takes_spir() {
        return Err(Error::NoRoad { device: device.info.name.clone() });
    }
    tools::find(&device.platform_version(), tools::Purpose::Device)?;
    Ok(())
}

/// The road that a program with these modules takes, with all on it that decides what the driver gets to see.
pub fn describe(device: &Device, modules: &[&[u32]]) -> Result<String, Error> {
    if modules.is_empty() {
        return Ok("opencl".to_owned());
    }
    if device.takes_spirv() {
        return Ok("spirv".to_owned());
    }
    check(device, Road::Spirv)?;
    Ok(format!("spir by {:?}", tools::find(&device.platform_version(), tools::Purpose::Device)?))
}

/// Builds a program from its text and the modules that it calls.
pub fn build(device: &Device, label: &str, source: &str, options: &str, modules: &[&[u32]]) -> Result<Program, Error> {
    if modules.is_empty() {
        return Ok(Program::build(device, label, source, options)?);
    }
    if device.takes_spirv() {
        return Ok(Program::link(device, label, source, options, modules)?);
    }
    check(device, Road::Spirv)?;
    let options = with_device(device, options);
    let bitcode =
        tools::find(&device.platform_version(), tools::Purpose::Device)?.link(label, source, &options, modules)?;
    Ok(Program::load(device, label, &bitcode, tools::LOAD_OPTIONS)?)
}

/// The options, and what the device's own compiler would know of it.
fn with_device(device: &Device, options: &str) -> String {
    let fma = if device.has_fma() { " -D FP_FAST_FMAF=1" } else { "" };
    format!("{options}{fma}")
}
