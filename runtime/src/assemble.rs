//! The kernel sources that the binary carries, and their assembly into one text per program.
//!
//! In: source text with `#include "..."` lines. Out: the same text with each header in place, once. OpenCL drivers find no
//! files, so nothing is left for them to include. It must not know devices.

use std::collections::HashSet;
use std::fmt::Write;

macro_rules! embed {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../kernels/", $name)))),*]
    };
}

/// Every file of kernels/, by its path there.
static KERNELS: &[(&str, &str)] = embed![
    "compensated.h",
    "context.h",
    "cubes.h",
    "geometry.h",
    "footprint.h",
    "globals.h",
    "lights.h",
    "lobe.h",
    "lobe_state.h",
    "maths.h",
    "maths_fast.h",
    "path_random.h",
    "random.h",
    "real.h",
    "strings.h",
    "surface.h",
    "traces.h",
    "triangle.h",
    "userdata.h",
    "bsdf/albedo.h",
    "bsdf/bsdf.h",
    "bsdf/burley_diffuse.h",
    "bsdf/chiang_hair.h",
    "bsdf/conductor.h",
    "bsdf/dielectric.h",
    "bsdf/diffuse.h",
    "bsdf/distribution.h",
    "bsdf/facets.h",
    "bsdf/frame.h",
    "bsdf/fresnel.h",
    "bsdf/generalized_schlick.h",
    "bsdf/microfacet.h",
    "bsdf/numeric.h",
    "bsdf/oren_nayar.h",
    "bsdf/oren_nayar_diffuse.h",
    "bsdf/phong.h",
    "bsdf/pick.h",
    "bsdf/reflection.h",
    "bsdf/refraction.h",
    "bsdf/sampling.h",
    "bsdf/sheen.h",
    "bsdf/thin_film.h",
    "bsdf/translucent.h",
    "bsdf/transparent.h",
    "bsdf/ward.h",
    "osl/color.h",
    "osl/environment.h",
    "osl/geometric.h",
    "osl/hash.h",
    "osl/math.h",
    "osl/matrix.h",
    "osl/noise.h",
    "osl/noise_cell.h",
    "osl/noise_gabor.h",
    "osl/noise_gabor_slopes.h",
    "osl/noise_hash.h",
    "osl/noise_perlin.h",
    "osl/noise_perlin_d.h",
    "osl/noise_perlin_slopes.h",
    "osl/noise_simplex.h",
    "osl/noise_simplex_d.h",
    "osl/noise_simplex_slopes.h",
    "osl/noise_slopes.h",
    "osl/noise_words.h",
    "osl/ops.h",
    "osl/pattern.h",
    "osl/points.h",
    "osl/records.h",
    "osl/spline.h",
    "osl/spline_slope.h",
    "osl/state.h",
    "osl/texture.h",
    "osl/texture3d.h",
    "osl/texture_data.h",
    "osl/texture_sample.h",
    "osl/trace.h",
    "stages/accumulate.cl",
    "stages/accumulate.h",
    "stages/displace.cl",
    "stages/environment.cl",
    "stages/environment.h",
    "stages/environment_light.cl",
    "stages/environment_map.cl",
    "stages/follow.h",
    "stages/follow_path.cl",
    "stages/light_power.cl",
    "stages/ray_gen.cl",
    "stages/ray_gen.h",
    "stages/resolve.cl",
    "stages/sample_light.cl",
    "stages/sample_light.h",
    "stages/sample_next.cl",
    "stages/sample_next.h",
    "stages/select_bsdf.cl",
    "stages/select_bsdf.h",
    "stages/shade.cl",
    "stages/shade_light.cl",
    "stages/shade_light.h",
    "stages/trace.cl",
    "stages/trace.h",
    "stages/trace_shadow.cl",
    "stages/trace_shadow.h",
];

/// The text of a kernel file, by its path below kernels/.
pub fn kernel(path: &str) -> Option<&'static str> {
    KERNELS.iter().find(|(name, _)| *name == path).map(|(_, text)| *text)
}

/// A text that includes what is not in kernels/.
#[derive(Debug, thiserror::Error)]
#[error("`{name}` includes `{path}`, which is no kernel header")]
pub struct Error {
    name: String,
    path: String,
}

/// Replaces `#include "PATH"` by the header's text where it stands first, by nothing after that. What stands under an `#if`
/// may not count in the end, so it is put in place each time: the header's own guard keeps it from counting twice.
///
/// `#line` directives keep the driver's messages true to file and line; `name` is that of the outermost text.
pub fn assemble(name: &str, text: &str) -> Result<String, Error> {
    assemble_with(name, text, &[])
}

/// As [`assemble`], with more headers: pairs of path and text.
pub fn assemble_with(name: &str, text: &str, more: &[(&str, &str)]) -> Result<String, Error> {
    let mut out = String::with_capacity(4 * text.len());
    expand(name, text, more, true, &mut HashSet::new(), &mut out)?;
    Ok(out)
}

/// `always`: the text counts whatever is defined.
fn expand<'a>(
    name: &str,
    text: &str,
    more: &[(&'a str, &'a str)],
    always: bool,
    seen: &mut HashSet<&'a str>,
    out: &mut String,
) -> Result<(), Error> {
    let _ = writeln!(out, "#line 1 \"{name}\"");
    // The guard around a header is no condition.
    let mut depth = if has_guard(text) { -1 } else { 0 };
    for (index, line) in text.lines().enumerate() {
        let Some(path) = included(line) else {
            let directive = line.trim_start();
            if directive.starts_with("#if") {
                depth += 1;
            } else if directive.starts_with("#endif") {
                depth -= 1;
            }
            out.push_str(line);
            out.push('\n');
            continue;
        };
        let Some((key, header)) = KERNELS.iter().chain(more).find(|(n, _)| *n == path) else {
            return Err(Error { name: name.to_owned(), path: path.to_owned() });
        };
        let counts = always && depth <= 0;
        if !seen.contains(key) {
            if counts {
                seen.insert(key);
            }
            expand(key, header, more, counts, seen, out)?;
        }
        let _ = writeln!(out, "#line {} \"{name}\"", index + 2);
    }
    Ok(())
}

/// Whether the first directives are `#ifndef X` and `#define X`.
fn has_guard(text: &str) -> bool {
    let mut directives = text.lines().map(str::trim).filter(|l| l.starts_with('#'));
    let first = directives.next().and_then(|l| l.strip_prefix("#ifndef "));
    let second = directives.next().and_then(|l| l.strip_prefix("#define "));
    first.is_some() && first == second
}

/// The path of an `#include "PATH"` line.
fn included(line: &str) -> Option<&str> {
    let rest = line.trim_start().strip_prefix("#include")?.trim();
    rest.strip_prefix('"')?.strip_suffix('"')
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn files(folder: &Path, root: &Path, out: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
            if entry.path().is_dir() {
                files(&entry.path(), root, out);
            } else {
                let path = entry.path();
                out.push(path.strip_prefix(root).expect("below the root").to_string_lossy().replace('\\', "/"));
            }
        }
    }

    #[test]
    fn every_kernel_file_is_embedded() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernels");
        let mut there = Vec::new();
        files(&root, &root, &mut there);
        there.sort();
        let mut here: Vec<String> = KERNELS.iter().map(|(n, _)| (*n).to_owned()).collect();
        here.sort();
        assert_eq!(there, here);
    }

    #[test]
    fn headers_stand_once_and_lines_are_kept() {
        let text = assemble("a.cl", "#include \"real.h\"\n#include \"real.h\"\nint x;").expect("assembles");
        assert_eq!(text.matches("typedef float real;").count(), 1);
        assert!(text.ends_with("#line 3 \"a.cl\"\nint x;\n"), "{text}");
    }

    #[test]
    fn a_header_under_a_condition_comes_again_where_it_counts() {
        let text = assemble("a.cl", "#ifdef A\n#include \"real.h\"\n#endif\n#include \"real.h\"\n").expect("assembles");
        assert_eq!(text.matches("typedef float real;").count(), 2);
        // Headers without a guard could not come twice.
        for (name, text) in KERNELS.iter().filter(|(name, _)| name.ends_with(".h")) {
            assert!(has_guard(text), "{name} has no guard");
        }
    }

    #[test]
    fn an_unknown_header_is_an_error() {
        let error = assemble("a.cl", "#include \"nowhere.h\"").expect_err("no such header");
        assert_eq!(error.to_string(), "`a.cl` includes `nowhere.h`, which is no kernel header");
    }
}
