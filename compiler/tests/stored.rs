//! Artifacts in files: what is read back is equal in every field, SPIR-V and the types of parameters included.

use oslcl_compiler::artifact::Stored;
use oslcl_compiler::{Artifact, Entry, Includes, NoIncludes, Options, compile};
use std::path::Path;
use std::sync::Arc;

/// The corpus's own headers.
struct Beside;

impl Includes for Beside {
    fn read(&self, path: &str, from: Option<&str>, _system: bool) -> Option<(String, Arc<str>)> {
        let file = Path::new(from?).parent()?.join(path);
        let text = std::fs::read_to_string(&file).ok()?;
        Some((file.to_string_lossy().into_owned(), text.into()))
    }
}

fn is_kept(artifact: &Artifact) {
    let mut bytes = Vec::new();
    ciborium::into_writer(&Stored::from(artifact.clone()), &mut bytes).expect("memory takes all");
    let stored: Stored = ciborium::from_reader(&bytes[..]).expect("it reads back");
    let again = Artifact::try_from(stored).expect("its parts belong together");
    // With NaN nothing is equal; their text is.
    assert!(&again == artifact || format!("{again:?}") == format!("{artifact:?}"), "{} differs", artifact.name);
}

#[test]
fn every_shader_of_the_corpus_reads_back() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut count = 0;
    for folder in ["tests/corpus", "tests/corpus/run", "shaders-osl"] {
        for entry in std::fs::read_dir(root.join(folder)).expect("a folder").flatten() {
            let path = entry.path();
            if path.extension().is_none_or(|e| e != "osl") {
                continue;
            }
            let source = std::fs::read_to_string(&path).expect("a shader");
            let file_name = path.to_string_lossy().into_owned();
            for entry in [Entry::Material, Entry::Grid(vec!["Ci".to_owned()])] {
                let options = Options {
                    file_name: file_name.clone(),
                    entry,
                    spirv: true,
                    interactive: true,
                    ..Options::default()
                };
                if let Ok(output) = compile(&source, &options, &Beside) {
                    is_kept(&output.artifact);
                    count += 1;
                }
            }
        }
    }
    assert!(count > 40, "only {count} artifacts");
}

#[test]
fn messages_keep_the_types_of_their_constants() {
    // An array of three numbers is no triple, nor one of sixteen a matrix; infinities have no JSON.
    let source =
        "struct s { float a; color b; }; surface says(float big = 1e39, s t = { 1, 2 }, float list[3] = { 1, 2, 3 }) {
        float a[3] = { 1, 2, 3 }; color c = color(1, 2, 3); matrix m = 2;
        printf(\"%g %g %g %s\\n\", a, c, m, \"text\"); Ci = big * t.a * list[1] * diffuse(N); }";
    let options = Options { spirv: true, interactive: true, ..Options::default() };
    let output = compile(source, &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
    assert!(!output.artifact.sites.is_empty());
    is_kept(&output.artifact);
}
