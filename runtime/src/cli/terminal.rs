//! Writing to standard output and standard error without panics: both may be closed.
//!
//! In: text. Out: the same text, there. It must not know what it says.

use super::Error;
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};

/// Writes text to standard output.
pub fn print(text: &str) -> Result<(), Error> {
    print_with(|out| out.write_all(text.as_bytes()))
}

/// Writes to standard output, buffered.
pub fn print_with(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Error> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    write(&mut out).and_then(|()| out.flush()).map_err(Error::Print)
}

/// Writes text to standard error. Nobody is left to tell when that fails.
pub fn say(text: &str) {
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// Shows what is being done, in a line that the next one replaces; nothing where standard error is no terminal.
pub fn progress(what: &str) {
    if io::stderr().is_terminal() {
        say(&format!("\r\x1b[K{what}"));
    }
}

/// Whether to use colours and boxes on standard error.
pub fn is_fancy() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
}

/// Says why the program ends without success.
pub fn say_error(error: impl Display) {
    let (red, plain) = if is_fancy() { ("\x1b[1;31m", "\x1b[0m") } else { ("", "") };
    say(&format!("{red}error:{plain} {error}\n"));
}
