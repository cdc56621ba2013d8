//! What shaders say, on its way to the user.
//!
//! In: messages in order. Out: text on standard output and standard error, lines of files for `fprintf`. It must not know who
//! said it.

use super::super::super::{Error, terminal};
use super::args::Args;
use oslcl_runtime::shade::{Kind, Message};
use oslcl_runtime::{files, points};
use std::collections::VecDeque;
use std::fs::OpenOptions;
use std::io::Write;

/// Errors and warnings that are remembered, each kind on its own: one that was said before is not said again, unless the
/// option `error_repeats` is on.
const HISTORY: usize = 25;

/// Says all messages.
pub fn say(args: &Args, messages: &[Message]) -> Result<(), Error> {
    let repeats = args.options.iter().any(|(name, value)| name == "error_repeats" && value != "0");
    let (mut errors, mut warnings) = (VecDeque::new(), VecDeque::new());
    let mut printed = String::new();
    for message in messages {
        match &message.kind {
            Kind::Print => printed.push_str(&message.text),
            Kind::Error if repeats || is_new(&mut errors, &message.text) => {
                terminal::print(&std::mem::take(&mut printed))?;
                terminal::say(&format!("ERROR: {}\n", message.text));
            }
            Kind::Warning if repeats || is_new(&mut warnings, &message.text) => {
                printed.push_str(&format!("WARNING: {}\n", message.text));
            }
            Kind::Error | Kind::Warning => {}
            Kind::File(name) => append(name, &message.text)?,
            Kind::Cloud(_) => {}
        }
    }
    terminal::print(&printed)?;
    Ok(points::write(messages)?)
}

/// Whether a text is none of the last ones; remembers it.
fn is_new(history: &mut VecDeque<String>, text: &str) -> bool {
    if history.iter().any(|known| known == text) {
        return false;
    }
    if history.len() == HISTORY {
        history.pop_front();
    }
    history.push_back(text.to_owned());
    true
}

/// Adds text to the end of a file.
fn append(name: &str, text: &str) -> Result<(), Error> {
    let written = OpenOptions::new().create(true).append(true).open(name);
    written
        .and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|cause| Error::Write(files::Error { path: name.into(), cause: cause.into() }))
}
