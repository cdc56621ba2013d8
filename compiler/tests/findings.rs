//! Where findings stand: in tests/corpus/errors/lines_*.osl each line that ends in `// error` or `// warning` has such a
//! finding, and no other line has one.

mod common;

use common::{Beside, corpus, name, shaders, text};
use oslcl_compiler::{Options, compile};
use std::collections::BTreeSet;

#[test]
fn findings_stand_on_their_lines() {
    let folder = corpus().join("errors");
    let files: Vec<_> = shaders(&folder).into_iter().filter(|p| name(p).starts_with("lines_")).collect();
    assert!(!files.is_empty());
    for path in files {
        let source = text(&path);
        let mut wanted = BTreeSet::new();
        for (i, line) in source.lines().enumerate() {
            for word in ["error", "warning"] {
                if line.ends_with(&format!("// {word}")) {
                    wanted.insert((i as u32 + 1, word));
                }
            }
        }
        let options = Options { file_name: name(&path), ..Options::default() };
        let (found, sources) = match compile(&source, &options, &Beside(folder.clone())) {
            Ok(output) => (output.warnings, output.sources),
            Err(failure) => (failure.diagnostics, failure.sources),
        };
        let found: BTreeSet<_> = found
            .iter()
            .map(|d| {
                let label = d.labels.first().unwrap_or_else(|| panic!("{} has no place", d.message));
                (sources.line(label.span), if d.is_error() { "error" } else { "warning" })
            })
            .collect();
        let missing: Vec<_> = wanted.difference(&found).collect();
        let extra: Vec<_> = found.difference(&wanted).collect();
        assert!(missing.is_empty() && extra.is_empty(), "{}: missing {missing:?}, extra {extra:?}", name(&path));
    }
}

#[test]
fn many_syntax_errors_end() {
    // As many errors as lines, a parenthesis that never closes, and brackets of all kinds.
    for line in ["a = ;\n", "f(a, \n", "} {\n", "@\n", "if (\n", "{ [ (\n", "\"\\\n", "else {\n"] {
        let source = format!("shader s() {{\n{}}}\n", line.repeat(300));
        let failure = compile(&source, &Options::default(), &oslcl_compiler::NoIncludes).expect_err("errors");
        assert!(failure.diagnostics.len() <= 120, "{}", failure.diagnostics.len());
    }
}
