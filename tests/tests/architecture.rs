//! Holds the walls of docs/ARCHITECTURE.md: which folder must not mention what.
//!
//! A source line breaks a wall when its code (not its comments) has one of the folder's forbidden words. Kernels are
//! held by their `#include` lines. Files longer than the house allows are refused too.

use std::fs;
use std::path::{Path, PathBuf};

/// A folder or file, what must not be named in it, and why.
struct Wall {
    place: &'static str,
    forbidden: &'static [&'static str],
    why: &'static str,
    except: &'static [&'static str],
}

const WALLS: &[Wall] = &[
    Wall {
        place: "compiler/src/parse",
        forbidden: &["crate::ir", "crate::types", "crate::check", "crate::lower", "crate::backend"],
        why: "the parser knows neither types nor IR",
        except: &[],
    },
    Wall {
        place: "compiler/src/ast",
        forbidden: &["crate::ir", "crate::types", "pest"],
        why: "the syntax tree knows neither types nor IR nor pest",
        except: &[],
    },
    Wall {
        place: "compiler/src/check",
        forbidden: &["crate::ir", "pest::", "crate::backend"],
        why: "the checker knows neither IR nor pest nor targets",
        except: &[],
    },
    Wall {
        place: "compiler/src/oso",
        forbidden: &["crate::ir", "crate::lower", "crate::passes", "crate::backend", "pest::"],
        why: ".oso is a form of the typed tree: it knows neither IR nor targets",
        except: &[],
    },
    Wall {
        place: "compiler/src/ir",
        forbidden: &["crate::ast", "crate::parse", "crate::check", "crate::lower", "crate::backend"],
        why: "the IR knows neither the syntax tree nor targets",
        except: &[],
    },
    Wall {
        place: "compiler/src/passes",
        forbidden: &["crate::ast", "crate::parse", "crate::check", "crate::lower", "crate::backend"],
        why: "passes know neither the syntax tree nor targets",
        except: &[],
    },
    Wall {
        place: "compiler/src/interp",
        forbidden: &["crate::ast", "crate::parse", "crate::check", "crate::lower", "crate::backend"],
        why: "the interpreter runs the IR alone",
        except: &[],
    },
    Wall {
        place: "compiler/src/backend",
        forbidden: &["crate::ast", "crate::parse", "crate::check", "crate::lower"],
        why: "back ends accept IR only",
        except: &[],
    },
    Wall {
        place: "compiler/src/backend/spirv",
        forbidden: &["opencl_c"],
        why: "back ends do not know each other",
        except: &[],
    },
    Wall {
        place: "compiler/src/backend/opencl_c",
        forbidden: &["spirv"],
        why: "back ends do not know each other",
        except: &[],
    },
    Wall {
        place: "compiler/src",
        forbidden: &["std::fs", "std::env", "std::time", "std::net", "std::process", "opencl3", "println!", "unsafe {"],
        why: "the compiler does no IO, reads no clock and knows no device",
        except: &[],
    },
    Wall {
        place: "runtime/src",
        forbidden: &["opencl3", "unsafe {", "unsafe fn", "unsafe impl"],
        why: "only runtime/src/device touches OpenCL and `unsafe`",
        except: &["runtime/src/device"],
    },
    Wall {
        place: "runtime/src/device",
        forbidden: &["crate::scene", "crate::plan", "crate::accel", "crate::wavefront", "oslcl_compiler"],
        why: "the device knows bytes, programs and kernels only",
        except: &[],
    },
    Wall {
        place: "runtime/src/cache",
        forbidden: &["crate::device", "crate::scene", "crate::plan", "crate::roads", "oslcl_compiler"],
        why: "kept programs are keys and bytes",
        except: &[],
    },
    Wall {
        place: "runtime/src/package",
        forbidden: &["crate::device", "crate::plan", "crate::wavefront", "crate::programs"],
        why: "packages are compiled shaders, for any device",
        except: &[],
    },
    Wall {
        place: "runtime/src/package/take.rs",
        forbidden: &["Master", "Group", "compile(", "instance("],
        why: "no compiler runs for a shader of a package",
        except: &[],
    },
    Wall {
        place: "runtime/src/plan",
        forbidden: &["crate::device"],
        why: "the plan is testable with no device",
        except: &[],
    },
    Wall {
        place: "runtime/src/textures",
        forbidden: &["crate::scene", "crate::plan", "crate::device", "crate::wavefront"],
        why: "textures are files, and words for any device",
        except: &[],
    },
    Wall {
        place: "runtime/src/points",
        forbidden: &["crate::scene", "crate::plan", "crate::device", "crate::wavefront"],
        why: "point clouds are files, and words for any device",
        except: &[],
    },
    Wall {
        place: "runtime/src/scene",
        forbidden: &["crate::device", "crate::plan", "crate::accel", "oslcl_compiler"],
        why: "a scene is data",
        except: &[],
    },
    Wall {
        place: "runtime/src",
        forbidden: &[
            "oslcl_compiler::ir",
            "oslcl_compiler::ast",
            "oslcl_compiler::check",
            "oslcl_compiler::lower",
            "oslcl_compiler::passes",
            "oslcl_compiler::parse",
            "oslcl_compiler::interp",
        ],
        why: "the runtime sees Artifact, Diagnostic and the facade",
        except: &[],
    },
    Wall {
        place: "kernels/bsdf",
        forbidden: &["queue", "path_state", "pixel", "stages/"],
        why: "BSDFs know neither queues nor path state nor pixels",
        except: &[],
    },
    Wall {
        place: "kernels/osl",
        forbidden: &["queue", "path_state", "pixel", "stages/", "bsdf/"],
        why: "the function library of OSL stands alone",
        except: &[],
    },
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ lies in the workspace").to_owned()
}

fn files_below(place: &Path, endings: &[&str], out: &mut Vec<PathBuf>) {
    if place.is_file() {
        out.push(place.to_owned());
    }
    let Ok(entries) = fs::read_dir(place) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.is_dir() {
            files_below(&path, endings, out);
        } else if path.extension().is_some_and(|e| endings.iter().any(|x| e == *x)) {
            out.push(path);
        }
    }
}

/// The code of a line: what stands before a comment. Good enough for words that never stand in a string with `//`.
fn code_of(line: &str) -> &str {
    line.split("//").next().unwrap_or("")
}

fn breaches(wall: &Wall, name: &str, text: &str) -> Vec<String> {
    if wall.except.iter().any(|e| name.starts_with(e)) {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        for word in wall.forbidden.iter().filter(|w| code_of(line).contains(**w)) {
            found.push(format!("{name}:{}: `{word}`: {}", number + 1, wall.why));
        }
    }
    found
}

#[test]
fn walls_stand() {
    let root = root();
    let mut found = Vec::new();
    for wall in WALLS {
        let mut files = Vec::new();
        files_below(&root.join(wall.place), &["rs", "cl", "h"], &mut files);
        files_below(&root.join(format!("{}.rs", wall.place)), &["rs"], &mut files);
        assert!(!files.is_empty(), "no files in {}: the wall is out of date", wall.place);
        for file in files {
            let text = fs::read_to_string(&file).expect("a source file is readable");
            let name = file.strip_prefix(&root).expect("below the root").to_string_lossy().into_owned();
            found.extend(breaches(wall, &name, &text));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_breach_is_found() {
    let wall = Wall { place: "x", forbidden: &["opencl3"], why: "w", except: &["x/device"] };
    assert_eq!(breaches(&wall, "x/a.rs", "// opencl3\nuse opencl3::x;\n").len(), 1);
    assert!(breaches(&wall, "x/device/a.rs", "use opencl3::x;").is_empty());
}

#[test]
fn stages_do_not_include_each_other() {
    let mut files = Vec::new();
    files_below(&root().join("kernels/stages"), &["cl"], &mut files);
    assert!(!files.is_empty());
    for file in files {
        let text = fs::read_to_string(&file).expect("a source file is readable");
        assert!(
            !text.lines().any(|l| l.contains("#include") && l.contains(".cl\"")),
            "{} includes a stage",
            file.display()
        );
    }
}

#[test]
fn files_stay_readable() {
    let root = root();
    let mut files = Vec::new();
    for folder in ["compiler/src", "runtime/src", "tests/src", "tests/tests", "kernels"] {
        files_below(&root.join(folder), &["rs", "cl", "h"], &mut files);
    }
    let tables = ["compiler/src/builtins/table.rs"];
    for file in files {
        let name = file.strip_prefix(&root).expect("below the root").to_string_lossy().into_owned();
        let text = fs::read_to_string(&file).expect("a source file is readable");
        if !tables.contains(&name.as_str()) {
            assert!(text.lines().count() <= 1000, "{name} has over 1,000 lines");
        }
        if name.ends_with(".rs") {
            assert!(text.starts_with("//!"), "{name} does not open with its purpose");
        }
    }
}
