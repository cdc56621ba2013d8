//! The parser and its recovery: any text gives a tree or syntax errors whose places exist.
#![no_main]

use libfuzzer_sys::fuzz_target;
use oslcl_compiler::diag::render_plain;
use oslcl_compiler::preprocess::{Options, preprocess};
use oslcl_compiler::{SourceMap, parse};
use oslcl_fuzz::{Headers, on_large_stack, text};

fuzz_target!(|data: &[u8]| {
    let Some(source) = text(data) else { return };
    let mut sources = SourceMap::default();
    let options = Options { without_stdosl: true, ..Options::default() };
    let Ok(pre) = preprocess("fuzz.osl", source, &options, &Headers, &mut sources) else { return };
    on_large_stack(|| {
        let parsed = parse::recover(&pre);
        render_plain(&sources, &parsed.errors);
        drop(parsed);
    });
});
