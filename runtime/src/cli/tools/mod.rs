//! The tools of the reference implementation under their own names and with their own options: `oslc`, `oslinfo`,
//! `testshade`, `testrender`.
//!
//! In: how the program was called. Out: what the tool prints and writes, and its exit code. The program is such a tool when
//! called by its name (by way of a link that `oslcl install-tools` makes) or as `oslcl TOOL ...`. A tool is one file here.

pub mod options;
mod oslc;
mod oslinfo;
mod testrender;
mod testshade;

use super::{Error, terminal};
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

/// A tool's name and what runs it; `None`: its place is kept, but it is not built yet.
type Tool = (&'static str, Option<fn(&[String]) -> Result<ExitCode, Error>>);

const TOOLS: &[Tool] = &[
    ("oslc", Some(oslc::run)),
    ("oslinfo", Some(oslinfo::run)),
    ("testshade", Some(testshade::run)),
    ("testrender", Some(testrender::run)),
];

/// Runs the tool that the arguments (with the program's own name first) ask for; `None` when they ask for none.
pub fn dispatch(args: &[OsString]) -> Option<Result<ExitCode, Error>> {
    let called = args.first().map(Path::new).and_then(Path::file_stem).and_then(|s| s.to_str()).unwrap_or("");
    let named = args.get(1).and_then(|a| a.to_str()).unwrap_or("");
    let find = |name: &str| TOOLS.iter().find(|(n, _)| *n == name);
    let (tool, rest) = match (find(called), find(named)) {
        (Some(tool), _) => (tool, &args[1..]),
        (None, Some(tool)) => (tool, &args[2..]),
        (None, None) => return None,
    };
    let mut texts = Vec::with_capacity(rest.len());
    for arg in rest {
        match arg.to_str() {
            Some(text) => texts.push(text.to_owned()),
            None => {
                let message = format!("the argument `{}` is not UTF-8 text", arg.to_string_lossy());
                return Some(Err(Error::Usage(message)));
            }
        }
    }
    let (name, run) = tool;
    Some(match run {
        Some(run) => run(&texts),
        None => Err(Error::Usage(format!("`{name}` is not built into this version of oslcl yet"))),
    })
}

/// `oslcl install-tools`: links in a folder, through which this program answers by the tools' names.
pub fn install(folder: &Path) -> Result<(), Error> {
    let failed = |path: &Path, cause: std::io::Error| {
        Error::Write(oslcl_runtime::files::Error { path: path.to_owned(), cause: cause.into() })
    };
    let program = std::env::current_exe().map_err(|e| failed(Path::new("oslcl"), e))?;
    std::fs::create_dir_all(folder).map_err(|e| failed(folder, e))?;
    for (name, run) in TOOLS {
        if run.is_none() {
            terminal::say(&format!("note: `{name}` is not built into this version of oslcl yet: no link is made\n"));
            continue;
        }
        let link = folder.join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
        replace_link(&program, &link).map_err(|e| failed(&link, e))?;
        terminal::print(&format!("{} -> {}\n", link.display(), program.display()))?;
    }
    Ok(())
}

/// Makes a link, in the place of an older link only: a program that happens to lie there is the user's.
#[cfg(unix)]
fn replace_link(program: &Path, link: &Path) -> std::io::Result<()> {
    match std::fs::symlink_metadata(link) {
        Ok(there) if there.file_type().is_symlink() => std::fs::remove_file(link)?,
        Ok(_) => {
            let message = "a file that is no link lies there; remove it first";
            return Err(std::io::Error::new(std::io::ErrorKind::AlreadyExists, message));
        }
        Err(_) => {}
    }
    std::os::unix::fs::symlink(program, link)
}

/// Systems where links need rights get copies.
#[cfg(not(unix))]
fn replace_link(program: &Path, link: &Path) -> std::io::Result<()> {
    std::fs::copy(program, link).map(|_| ())
}
