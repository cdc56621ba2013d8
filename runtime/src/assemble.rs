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
    "globals.h",
    "lobe.h",
    "maths.h",
    "real.h",
    "strings.h",
    "bsdf/bsdf.h",
    "bsdf/conductor.h",
    "bsdf/diffuse.h",
    "bsdf/distribution.h",
    "bsdf/frame.h",
    "bsdf/fresnel.h",
    "bsdf/microfacet.h",
    "bsdf/numeric.h",
    "bsdf/oren_nayar.h",
    "bsdf/phong.h",
    "bsdf/pick.h",
    "bsdf/reflection.h",
    "bsdf/refraction.h",
    "bsdf/sampling.h",
    "bsdf/translucent.h",
    "bsdf/transparent.h",
    "bsdf/ward.h",
    "osl/color.h",
    "osl/geometric.h",
    "osl/hash.h",
    "osl/math.h",
    "osl/matrix.h",
    "osl/noise.h",
    "osl/noise_cell.h",
    "osl/noise_hash.h",
    "osl/noise_perlin.h",
    "osl/noise_simplex.h",
    "osl/noise_words.h",
    "osl/ops.h",
    "osl/pattern.h",
    "osl/spline.h",
    "osl/state.h",
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

/// Replaces `#include "PATH"` by the header's text where it stands first, by nothing after that.
///
/// `#line` directives keep the driver's messages true to file and line; `name` is that of the outermost text.
pub fn assemble(name: &str, text: &str) -> Result<String, Error> {
    let mut out = String::with_capacity(4 * text.len());
    expand(name, text, &mut HashSet::new(), &mut out)?;
    Ok(out)
}

fn expand(name: &str, text: &str, seen: &mut HashSet<&'static str>, out: &mut String) -> Result<(), Error> {
    let _ = writeln!(out, "#line 1 \"{name}\"");
    // Open conditionals of this text, its include guard aside: it hides nothing the first time.
    let mut conditionals = 0u32;
    for (index, line) in text.lines().enumerate() {
        let Some(path) = included(line) else {
            let directive = line.trim_start().strip_prefix('#').map_or("", str::trim_start);
            if directive.starts_with("if") && !directive.starts_with("ifndef OSLCL_") {
                conditionals += 1;
            } else if directive.starts_with("endif") {
                conditionals = conditionals.saturating_sub(1);
            }
            out.push_str(line);
            out.push('\n');
            continue;
        };
        let Some((key, header)) = KERNELS.iter().find(|(n, _)| *n == path) else {
            return Err(Error { name: name.to_owned(), path: path.to_owned() });
        };
        if conditionals > 0 {
            // Its text may be left out by the driver's preprocessor, and with it what only it includes: nothing of this
            // counts as seen. The include guards drop repetitions.
            expand(key, header, &mut seen.clone(), out)?;
        } else if seen.insert(key) {
            expand(key, header, seen, out)?;
        }
        let _ = writeln!(out, "#line {} \"{name}\"", index + 2);
    }
    Ok(())
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
    fn what_a_conditional_includes_is_there_without_it_too() {
        let text = "#ifdef NO\n#include \"bsdf/diffuse.h\"\n#endif\n#include \"bsdf/frame.h\"\n";
        let text = assemble("a.cl", text).expect("assembles");
        let behind = &text[text.find("#endif\n#line").expect("the conditional ends")..];
        assert!(behind.contains("} Frame;"), "{text}");
    }

    #[test]
    fn an_unknown_header_is_an_error() {
        let error = assemble("a.cl", "#include \"nowhere.h\"").expect_err("no such header");
        assert_eq!(error.to_string(), "`a.cl` includes `nowhere.h`, which is no kernel header");
    }
}
