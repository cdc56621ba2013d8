//! Snapshots of the compiler's stages over tests/corpus, and of its messages over tests/corpus/errors.
//!
//! A snapshot holds what its input is about: the first word of a file's name decides which stages are shown.
//! `INSTA_UPDATE=always` writes them anew; read every difference.

mod common;

use common::{Beside, corpus, lowered, name, optimised, shaders, text, tree};
use oslcl_compiler::diag::render_plain;
use oslcl_compiler::{Entry, Master, NoIncludes, Options, compile, ir, parse};
use std::path::Path;

/// Snapshots longer than this want a smaller input.
const MAX_LINES: usize = 150;

fn snapshot(stage: &str, path: &Path, content: &str) {
    let lines = content.lines().count();
    assert!(lines <= MAX_LINES, "{} {stage}: {lines} lines", name(path));
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    insta::with_settings!({
        snapshot_path => corpus().join("snapshots"),
        prepend_module_to_snapshot => false,
        omit_expression => true,
    }, {
        insta::assert_snapshot!(format!("{stem}.{stage}"), content);
    });
}

/// The corpus files whose name starts with one of the prefixes; at least one each.
fn select(prefixes: &[&str]) -> Vec<std::path::PathBuf> {
    let all = shaders(&corpus());
    for prefix in prefixes {
        assert!(all.iter().any(|p| name(p).starts_with(prefix)), "no corpus file starts with {prefix}");
    }
    all.into_iter().filter(|p| prefixes.iter().any(|prefix| name(p).starts_with(prefix))).collect()
}

#[test]
fn syntax_trees() {
    let prefixes = [
        "lex_",
        "pp_",
        "meta_",
        "expr_precedence",
        "expr_comma",
        "fn_nested",
        "fn_forward",
        "stmt_if",
        "struct_nested",
        "params_init",
        "params_closure",
    ];
    for path in select(&prefixes) {
        let file = tree(&name(&path), &text(&path)).expect("parses");
        // The functions of stdosl.h come first and are none of the input's.
        let dump = parse::dump(&file);
        let own = dump.find("function void artistic_ior").map_or(0, |at| {
            let behind = at + dump[at..].find('\n').map_or(0, |n| n + 1);
            behind
                + dump[behind..]
                    .match_indices('\n')
                    .map(|(i, _)| i + 1)
                    .find(|i| !dump[behind + i..].starts_with(' '))
                    .unwrap_or(0)
        });
        snapshot("tree", &path, dump[own..].trim_start_matches(")\n"));
    }
}

#[test]
fn lowered_ir() {
    let prefixes = [
        "struct_nested",
        "struct_param",
        "array_copy",
        "fn_output",
        "fn_overload",
        "fn_nested",
        "fn_return",
        "expr_short_circuit",
        "expr_assign_value",
        "expr_comma",
        "stmt_exit",
        "stmt_scopes",
        "params_init",
        "params_closure",
    ];
    for path in select(&prefixes) {
        snapshot("ir", &path, &ir::print(&lowered(&name(&path), &text(&path)).expect("lowers")));
    }
}

#[test]
fn optimised_ir() {
    let prefixes =
        ["closure_control", "closure_loop", "closure_function", "closure_array", "fold_", "lex_", "pp_", "stmt_exit"];
    for path in select(&prefixes) {
        snapshot("optimised", &path, &ir::print(&optimised(&name(&path), &text(&path)).expect("optimises")));
    }
}

#[test]
fn opencl_c() {
    let prefixes = [
        "array_",
        "closure_",
        "expr_",
        "fn_",
        "fold_",
        "derivatives",
        "globals_",
        "issue_",
        "kind_",
        "lib_",
        "names_",
        "noise_perlin",
        "noise_unnamed",
        "noise_chosen",
        "op_",
        "print_",
        "params_",
        "stmt_",
        "struct_",
        "uninitialised",
    ];
    for path in select(&prefixes) {
        let options = Options { file_name: name(&path), ..Options::default() };
        let master = Master::new(&text(&path), &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
        let outputs: Vec<String> = master
            .info()
            .params
            .iter()
            .filter(|p| p.output && !p.ty.starts_with("closure"))
            .flat_map(|p| {
                let fields: Vec<String> = p.fields.iter().map(|f| format!("{}.{}", p.name, f.name)).collect();
                if fields.is_empty() { vec![p.name.clone()] } else { fields }
            })
            .collect();
        // What has outputs is about them; the rest is about lobes.
        let entry = if outputs.is_empty() || name(&path).starts_with("closure") {
            Entry::Material
        } else {
            Entry::Grid(outputs)
        };
        let output = master.instance(&Options { entry, ..options }).unwrap_or_else(|e| panic!("{e}"));
        snapshot("cl", &path, &output.artifact.code);
    }
}

#[test]
fn reflection() {
    for path in select(&["meta_", "struct_param", "params_types"]) {
        let options = Options { file_name: name(&path), ..Options::default() };
        let output = compile(&text(&path), &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
        let info = serde_json::to_value(&output.artifact.info).expect("serialises");
        // One line per entry: the shape counts, not the indentation.
        let mut out = String::new();
        for (key, value) in info.as_object().expect("an object") {
            match value.as_array() {
                Some(items) => items.iter().for_each(|item| out.push_str(&format!("{key}: {item}\n"))),
                None => out.push_str(&format!("{key}: {value}\n")),
            }
        }
        snapshot("info", &path, &out);
    }
}

#[test]
fn messages() {
    let folder = corpus().join("errors");
    for path in shaders(&folder) {
        let options = Options { file_name: name(&path), ..Options::default() };
        let rendered = match compile(&text(&path), &options, &Beside(folder.clone())) {
            Ok(output) => {
                assert!(!output.warnings.is_empty(), "{} compiles and nothing is said of it", name(&path));
                render_plain(&output.sources, &output.warnings)
            }
            Err(failure) => failure.to_string(),
        };
        snapshot("errors", &path, &rendered);
    }
}
