//! The macros that the code of an artifact needs in front of it, whoever runs it.
//!
//! In: an artifact. Out: what has to be defined. It must not know what the code is run for.

use crate::textures;
use oslcl_compiler::Artifact;

/// Names, or names and values.
pub(crate) fn macros(artifact: &Artifact) -> Vec<String> {
    let inputs = &artifact.inputs;
    let mut out: Vec<String> = artifact.lobes.iter().map(|l| format!("HAS_LOBE_{}", l.to_uppercase())).collect();
    out.extend(textures::macros(&artifact.textures));
    for (on, name) in [
        (artifact.state.derivatives, "HAS_DERIVATIVES"),
        (!artifact.sites.is_empty(), "HAS_MESSAGES"),
        (inputs.interactive_slots > 0, "HAS_INTERACTIVE"),
        (!artifact.point_clouds.is_empty(), "HAS_POINT_CLOUDS"),
        (artifact.traces.calls, "HAS_TRACES"),
        (!artifact.traces.sets.is_empty(), "HAS_TRACE_SETS"),
        (artifact.traces.asked.iter().any(|a| a == "geom:name"), "HAS_TRACE_NAMES"),
    ] {
        if on {
            out.push(name.to_owned());
        }
    }
    if inputs.userdata_slots > 0 {
        out.push(format!("HAS_USERDATA {}", inputs.userdata_slots));
    }
    out
}

/// The text that stands for the artifact in a program: its code, or what binds its SPIR-V module to the kernels.
pub(crate) fn code(artifact: &Artifact) -> &str {
    artifact.spirv.as_ref().map_or(&artifact.code, |s| &s.bridge)
}

/// Whether an artifact's text has several lobes, of which it picks one (kernels/bsdf/pick.h).
pub(crate) fn chooses_lobes(code: &str) -> bool {
    code.contains("lobe_offer(")
}

/// The macros as text.
pub(crate) fn text(artifact: &Artifact) -> String {
    macros(artifact).iter().map(|m| format!("#define {m}\n")).collect()
}
