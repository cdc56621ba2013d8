//! What the code of a shader has built in about texture files: answers of `gettextureinfo`.
//!
//! In: the compiler's questions. Out: the same questions with their answers, to be asked again where the code is used. It must
//! not know files.

use oslcl_compiler::textures::{Info, InfoType, Lookup, Texel, Textures};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, Mutex, PoisonError};

/// A question about a file, and its answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fact {
    /// The file's name as the shader has it.
    pub file: String,
    /// What was asked.
    asked: Asked,
}

/// The questions of [`Textures`], with their answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Asked {
    Tiles(Option<(u32, u32)>),
    Info { tile: Option<(u32, u32)>, name: String, ty: InfoType, count: u64, answer: Option<Info> },
    Error { st: [f64; 2], subimage: i32, subimage_name: String, answer: String },
}

impl Fact {
    /// What is different now; `None`: nothing.
    pub fn changed(&self, now: &dyn Textures) -> Option<String> {
        let file = &self.file;
        match &self.asked {
            Asked::Tiles(then) => (now.tiles(file) != *then)
                .then(|| format!("the tiles of texture `{file}` are not those that it was compiled with")),
            Asked::Info { tile, name, ty, count, answer } => {
                let count = usize::try_from(*count).unwrap_or(usize::MAX);
                let new = now.info(file, *tile, name, *ty, count);
                (new != *answer).then(|| {
                    let [old, new] = [answer, &new].map(|a| a.as_ref().map_or("unknown".to_owned(), shown));
                    format!("`{name}` of texture `{file}` was {old} when it was compiled, and is {new}")
                })
            }
            Asked::Error { st, subimage, subimage_name, answer } => {
                (now.error(file, *st, *subimage, subimage_name) != *answer).then(|| {
                    format!("texture `{file}` is missing where it was not when it was compiled, or the other way round")
                })
            }
        }
    }
}

fn shown(info: &Info) -> String {
    match info {
        Info::Ints(v) => v.iter().map(i32::to_string).collect::<Vec<_>>().join(" "),
        Info::Floats(v) => v.iter().map(f64::to_string).collect::<Vec<_>>().join(" "),
        Info::Text(s) => format!("{s:?}"),
    }
}

/// Answers as another one does, and keeps what was asked.
pub(super) struct Recorder {
    from: Arc<dyn Textures>,
    facts: Mutex<Vec<Fact>>,
}

impl Recorder {
    pub fn new(from: Arc<dyn Textures>) -> Recorder {
        Recorder { from, facts: Mutex::default() }
    }

    /// All that was asked so far, each once.
    pub fn facts(&self) -> Vec<Fact> {
        self.facts.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn keep(&self, file: &str, asked: Asked) {
        let fact = Fact { file: file.to_owned(), asked };
        let mut facts = self.facts.lock().unwrap_or_else(PoisonError::into_inner);
        if !facts.contains(&fact) {
            facts.push(fact);
        }
    }
}

impl Textures for Recorder {
    fn tiles(&self, file: &str) -> Option<(u32, u32)> {
        let answer = self.from.tiles(file);
        self.keep(file, Asked::Tiles(answer));
        answer
    }

    fn info(&self, file: &str, tile: Option<(u32, u32)>, name: &str, ty: InfoType, count: usize) -> Option<Info> {
        let answer = self.from.info(file, tile, name, ty, count);
        let asked = Asked::Info { tile, name: name.to_owned(), ty, count: count as u64, answer: answer.clone() };
        self.keep(file, asked);
        answer
    }

    fn lookup(&self, lookup: &Lookup<'_>) -> Texel {
        // Devices look up; the compiler does not.
        self.from.lookup(lookup)
    }

    fn error(&self, file: &str, st: [f64; 2], subimage: i32, subimage_name: &str) -> String {
        let answer = self.from.error(file, st, subimage, subimage_name);
        let asked = Asked::Error { st, subimage, subimage_name: subimage_name.to_owned(), answer: answer.clone() };
        self.keep(file, asked);
        answer
    }
}
