//! Processes that build programs: for drivers that build one at a time within a process, however many threads ask.
//!
//! In: texts, options, modules. Out: their binaries, in the cache of the device, from where whoever asked loads them. A process
//! that dies or refuses costs time and no more: its programs are built where they are wanted. It must not know plans or stages.
//!
//! A process reads a [`Request`] a line from its standard input and answers each with a line: `done`, or why not. It ends when
//! its input does, so that none stays behind.

use crate::device::Device;
use crate::programs;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{ChildStdin, ChildStdout, Command, Stdio};

/// Processes at a time. Each opens the device, which takes a while and does not get faster by being done side by side.
pub const MOST: usize = 12;

/// With fewer programs to build than this, opening the device once more takes longer than is won.
pub const WORTH_IT: usize = 4;

const DONE: &str = "done";

/// How a process is started that calls [`serve`] for the same device and cache.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// The program.
    pub program: PathBuf,
    /// Its arguments.
    pub args: Vec<OsString>,
    /// Also for drivers that build several programs at a time.
    pub always: bool,
}

/// A program to build.
#[derive(Debug, Serialize, Deserialize)]
pub struct Request<'a> {
    /// What it is called in messages.
    pub label: Cow<'a, str>,
    /// Its whole text.
    #[serde(borrow)]
    pub source: Cow<'a, str>,
    /// Build options.
    pub options: Cow<'a, str>,
    /// SPIR-V modules that are linked with it.
    pub modules: Vec<Vec<u32>>,
}

/// A running process.
///
/// It ends when this is dropped: its input ends then. Nobody waits for that, for it closes its device first.
pub struct Builder {
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Builder {
    /// Starts a process.
    pub fn start(recipe: &Recipe) -> io::Result<Builder> {
        let mut command = Command::new(&recipe.program);
        command.args(&recipe.args).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn()?;
        let (Some(requests), Some(answers)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(io::Error::other("the process has no input or output"));
        };
        // Somebody must ask how it ended, or the system remembers it as long as we run.
        std::thread::spawn(move || child.wait());
        Ok(Builder { requests, answers: BufReader::new(answers) })
    }

    /// Waits until the program is in the cache.
    pub fn build(&mut self, request: &Request) -> io::Result<()> {
        serde_json::to_writer(&mut self.requests, request)?;
        self.requests.write_all(b"\n")?;
        self.requests.flush()?;
        let mut answer = String::new();
        self.answers.read_line(&mut answer)?;
        match answer.trim_end() {
            DONE => Ok(()),
            "" => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the process has ended")),
            why => Err(io::Error::other(why.to_owned())),
        }
    }
}

/// Builds what `requests` asks for into the device's cache, until there is no more to read.
pub fn serve(device: &Device, requests: impl BufRead, mut answers: impl Write) -> io::Result<()> {
    for line in requests.lines() {
        let line = line?;
        let answer = match serde_json::from_str::<Request>(&line) {
            Err(e) => format!("not a request: {e}"),
            Ok(request) => {
                let modules: Vec<&[u32]> = request.modules.iter().map(Vec::as_slice).collect();
                let built = programs::build_one(device, &request.label, &request.source, &request.options, &modules);
                built.map_or_else(|e| e.to_string().replace('\n', " "), |_| DONE.to_owned())
            }
        };
        writeln!(answers, "{answer}")?;
        answers.flush()?;
    }
    Ok(())
}
