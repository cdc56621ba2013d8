//! LLVM's tools: OpenCL C and a SPIR-V module to one file of bitcode, for drivers that take SPIR 1.2.
//!
//! In: text and words. Out: bitcode. It must not know devices. Files live in a folder of their own that goes when it is done.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};
use std::{env, fs, io, process};

/// With which options a driver loads the bitcode.
pub const LOAD_OPTIONS: &str = "-x spir -spir-std=1.2";

/// Versions that are looked for, newest first.
const VERSIONS: std::ops::RangeInclusive<u32> = 12..=22;

/// Longest complaint of a tool that is shown, in bytes.
const MAX_TOLD: usize = 4_000;

/// Why there is no bitcode.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No version of LLVM has all three.
    #[error(
        "for {} three tools of one LLVM version are needed, and {missing}\n  help: `apt-get install clang-15 llvm-15 \
         llvm-spirv-15` (or another version){}", .purpose.name(), .purpose.way_round()
    )]
    Missing {
        /// What they are needed for.
        purpose: Purpose,
        /// What was found and what not.
        missing: String,
    },
    /// A tool refuses.
    #[error("`{tool}` fails on program `{program}`: {cause}")]
    Refused {
        /// The tool.
        tool: String,
        /// The program's label.
        program: String,
        /// What it says.
        cause: String,
    },
    /// The files between the tools.
    #[error("cannot write the files of program `{program}` to {}: {cause}", path.display())]
    Files {
        /// The program's label.
        program: String,
        /// The folder.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
}

/// What bitcode is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A device that is to take SPIR-V modules.
    Device,
    /// A file.
    File,
}

impl Purpose {
    fn name(self) -> &'static str {
        match self {
            Purpose::Device => "SPIR-V on this device",
            Purpose::File => "bitcode",
        }
    }

    /// How to do without the tools.
    fn way_round(self) -> &'static str {
        match self {
            Purpose::Device => ", or leave out `--road spirv`",
            Purpose::File => ", or leave out `--emit bitcode`",
        }
    }
}

/// The tools of one version.
#[derive(Clone, Debug)]
pub struct Tools {
    clang: PathBuf,
    link: PathBuf,
    spirv: PathBuf,
}

/// The three names, without versions.
const NAMES: [&str; 3] = ["clang", "llvm-link", "llvm-spirv"];

/// Finds the tools on the path: those of the LLVM that the driver says it is built on, else the newest.
pub fn find(driver: &str, purpose: Purpose) -> Result<&'static Tools, Error> {
    static FOUND: OnceLock<Result<Tools, String>> = OnceLock::new();
    let found = FOUND.get_or_init(|| search(driver, &env::var_os("PATH").unwrap_or_default()));
    found.as_ref().map_err(|missing| Error::Missing { purpose, missing: missing.clone() })
}

fn search(driver: &str, path: &std::ffi::OsStr) -> Result<Tools, String> {
    let folders: Vec<PathBuf> = env::split_paths(path).collect();
    let find = |name: &str| folders.iter().map(|f| f.join(name)).find(|p| p.is_file());
    let own = driver.split("LLVM ").nth(1).and_then(|v| v.split('.').next()?.parse::<u32>().ok());
    let endings = own.into_iter().chain(VERSIONS.rev()).map(|v| format!("-{v}")).chain([String::new()]);
    for ending in endings {
        let all = NAMES.map(|name| find(&format!("{name}{ending}")));
        if let [Some(clang), Some(link), Some(spirv)] = all {
            return Ok(Tools { clang, link, spirv });
        }
    }
    let mut there = String::new();
    for name in NAMES {
        let versions: Vec<String> =
            VERSIONS.map(|v| format!("{name}-{v}")).chain([name.to_owned()]).filter(|n| find(n).is_some()).collect();
        let list = if versions.is_empty() { "none".to_owned() } else { versions.join(", ") };
        let _ = write!(there, "{}{name}: {list}", if there.is_empty() { "" } else { "; " });
    }
    Err(format!("the path has not all ({there})"))
}

impl Tools {
    /// OpenCL C and modules as one file of bitcode. `options` as for a build of the text.
    pub fn link(&self, label: &str, source: &str, options: &str, modules: &[&[u32]]) -> Result<Vec<u8>, Error> {
        let folder = Folder::new().map_err(|(path, cause)| Error::Files { program: label.to_owned(), path, cause })?;
        let file = |name: &str| folder.0.join(name);
        fs::write(file("kernels.cl"), source).map_err(|cause| folder.failed(label, cause))?;
        let mut clang = Command::new(&self.clang);
        // Inlining is left to the driver, which sees the module, too.
        clang.args(["-c", "-x", "cl", "-target", "spir64-unknown-unknown", "-emit-llvm", "-O1", "-w"]);
        clang.args(["-Xclang", "-disable-llvm-passes"]).args(options.split_whitespace());
        folder.run(label, clang.args(["kernels.cl", "-o", "kernels.bc"]))?;
        let mut link = Command::new(&self.link);
        link.args(["-o", "program.bc", "kernels.bc"]);
        for (i, module) in modules.iter().enumerate() {
            let words: Vec<u8> = module.iter().flat_map(|w| w.to_ne_bytes()).collect();
            let (from, to) = (format!("module{i}.spv"), format!("module{i}.bc"));
            fs::write(file(&from), words).map_err(|cause| folder.failed(label, cause))?;
            folder.run(label, Command::new(&self.spirv).args(["-r", &from, "-o", &to]))?;
            link.arg(to);
        }
        folder.run(label, &mut link)?;
        fs::read(file("program.bc")).map_err(|cause| folder.failed(label, cause))
    }
}

/// A folder that nobody else has, removed with all in it.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Result<Folder, (PathBuf, io::Error)> {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        loop {
            let name = format!("oslcl-{}-{}", process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
            let path = env::temp_dir().join(name);
            match fs::create_dir(&path) {
                Ok(()) => return Ok(Folder(path)),
                // Left by a process that had our number and was killed.
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err((path, e)),
            }
        }
    }

    fn failed(&self, label: &str, cause: io::Error) -> Error {
        Error::Files { program: label.to_owned(), path: self.0.clone(), cause }
    }

    fn run(&self, label: &str, command: &mut Command) -> Result<(), Error> {
        let refused = |cause: String| {
            let tool = Path::new(command.get_program()).file_name().unwrap_or_default().to_string_lossy().into_owned();
            Error::Refused { tool, program: label.to_owned(), cause }
        };
        let refused = &refused;
        let output = match Command::new(command.get_program()).args(command.get_args()).current_dir(&self.0).output() {
            Ok(output) => output,
            Err(e) => return Err(refused(e.to_string())),
        };
        if output.status.success() {
            return Ok(());
        }
        let said = String::from_utf8_lossy(&output.stderr);
        let said: String = said.chars().take(MAX_TOLD).collect();
        Err(refused(format!("{}\n{}", output.status, said.trim_end())))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed stays: temporary folders are swept.
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_tools_are_named() {
        let message = search("OpenCL 3.0 PoCL", "/nowhere".as_ref()).expect_err("nothing is there");
        let told = |purpose| Error::Missing { purpose, missing: message.clone() }.to_string();
        let error = told(Purpose::File);
        assert!(error.contains("`--emit bitcode`") && !error.contains("--road"), "{error}");
        let error = told(Purpose::Device);
        assert!(error.contains("leave out `--road spirv`"), "{error}");
        for name in NAMES {
            assert!(error.contains(&format!("{name}: none")), "{error}");
        }
        assert!(error.contains("apt-get install"), "{error}");
    }
}
