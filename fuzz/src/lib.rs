//! What the fuzz targets share.
//!
//! In: bytes. Out: nothing, or a crash that is worth mending. Input that is no UTF-8 text is no input: the reader of files
//! refuses it before the compiler.

use oslcl_compiler::Includes;
use std::sync::Arc;

/// The longest input. What grows beyond reason does so with much shorter ones.
pub const MAX_BYTES: usize = 16 << 10;

/// Headers that fuzzed sources can include: themselves, so that includes nest, and one that exists.
pub struct Headers;

impl Includes for Headers {
    fn read(&self, path: &str, _from: Option<&str>, _system: bool) -> Option<(String, Arc<str>)> {
        match path {
            "a.h" => Some(("a.h".into(), "#ifndef A\n#define A 1\nfloat from_a(float x) { return x; }\n#endif\n".into())),
            "b.h" => Some(("b.h".into(), "#include \"b.h\"\n".into())),
            _ => None,
        }
    }
}

/// The text of an input.
pub fn text(data: &[u8]) -> Option<&str> {
    std::str::from_utf8(data).ok().filter(|t| t.len() <= MAX_BYTES)
}

/// Runs what recurses as deep as its input nests, as the compiler's facade does.
pub fn on_large_stack(work: impl FnOnce() + Send) {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(oslcl_compiler::parse::STACK_BYTES);
        match thread.spawn_scoped(scope, work).map(|t| t.join()) {
            Ok(Ok(())) => {}
            Ok(Err(panic)) => std::panic::resume_unwind(panic),
            Err(e) => panic!("cannot start a thread: {e}"),
        }
    });
}
