//! docs/errors.md lists exactly the codes that the compiler's sources use.

use std::collections::BTreeSet;
use std::path::Path;

fn sources(folder: &Path, out: &mut String) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources").flatten() {
        let path = entry.path();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push_str(&std::fs::read_to_string(&path).expect("a readable source"));
        }
    }
}

/// `E` or `W` and four digits.
fn is_code(word: &str) -> bool {
    word.len() == 5 && word.starts_with(['E', 'W']) && word[1..].bytes().all(|b| b.is_ascii_digit())
}

#[test]
fn the_page_lists_the_codes_of_the_sources() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut text = String::new();
    sources(&root.join("src"), &mut text);
    let used: BTreeSet<&str> = text.split('"').filter(|w| is_code(w)).collect();
    let page = std::fs::read_to_string(root.join("../docs/errors.md")).expect("the page");
    let rows: Vec<&str> = page.lines().filter_map(|l| l.strip_prefix("| ")?.get(..5)).filter(|w| is_code(w)).collect();
    let listed: BTreeSet<&str> = rows.iter().copied().collect();
    assert_eq!(rows.len(), listed.len(), "a code has two rows");
    assert_eq!(listed, used);
}
