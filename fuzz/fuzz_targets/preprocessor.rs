//! The preprocessor alone: any text gives text or findings whose places exist.
#![no_main]

use libfuzzer_sys::fuzz_target;
use oslcl_compiler::SourceMap;
use oslcl_compiler::diag::render_plain;
use oslcl_compiler::preprocess::{Options, preprocess};
use oslcl_fuzz::{Headers, text};

fuzz_target!(|data: &[u8]| {
    let Some(source) = text(data) else { return };
    let mut sources = SourceMap::default();
    let options = Options { without_stdosl: true, ..Options::default() };
    match preprocess("fuzz.osl", source, &options, &Headers, &mut sources) {
        Ok(pre) => {
            for (i, _) in pre.text.char_indices().step_by(97) {
                sources.locate(pre.span(i, i + 1));
            }
        }
        Err(found) => assert!(!render_plain(&sources, &found).is_empty()),
    }
});
