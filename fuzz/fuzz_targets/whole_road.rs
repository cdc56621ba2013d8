//! From source to OpenCL C: any text gives code or findings, for materials and for grids of its outputs.
#![no_main]

use libfuzzer_sys::fuzz_target;
use oslcl_compiler::{Entry, Master, Options, batch};
use oslcl_fuzz::{Headers, text};

fuzz_target!(|data: &[u8]| {
    let Some(source) = text(data) else { return };
    let work = || {
        let Ok(master) = Master::new(source, &Options::default(), &Headers) else { return };
        let outputs: Vec<String> =
            master.info().params.iter().filter(|p| p.output).map(|p| p.name.clone()).collect();
        for entry in [Entry::Material, Entry::Grid(outputs)] {
            match master.instance(&Options { entry, ..Options::default() }) {
                Ok(output) => assert!(output.artifact.code.contains(&output.artifact.entry)),
                Err(failure) => assert!(!failure.diagnostics.is_empty()),
            }
        }
    };
    if let Err(failure) = batch(work) {
        panic!("{failure}");
    }
});
