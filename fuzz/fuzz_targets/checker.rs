//! The front half: any text gives a checked and lowered shader, or findings whose places exist.
#![no_main]

use libfuzzer_sys::fuzz_target;
use oslcl_compiler::{Options, check_only};
use oslcl_fuzz::{Headers, text};

fuzz_target!(|data: &[u8]| {
    let Some(source) = text(data) else { return };
    match check_only(source, &Options::default(), &Headers) {
        Ok((warnings, sources)) => drop(oslcl_compiler::diag::render_plain(&sources, &warnings)),
        Err(failure) => {
            assert!(failure.diagnostics.iter().any(|d| d.is_error()));
            assert!(!failure.to_string().is_empty());
        }
    }
});
