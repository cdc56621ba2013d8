//! Output files: replaced as a whole or not at all.
//!
//! In: paths and bytes. Out: the files. It must not know what they hold.

use super::Error;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A file to write.
pub struct Output {
    /// Where.
    pub path: PathBuf,
    /// What.
    pub bytes: Vec<u8>,
}

/// Where the bytes really go: behind links, and straight into what is no regular file, such as a pipe or /dev/null.
enum Target {
    Replace(PathBuf),
    Into(PathBuf),
}

fn target(path: &Path) -> io::Result<Target> {
    match fs::canonicalize(path) {
        Ok(real) if real.is_dir() => Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder")),
        Ok(real) if real.is_file() => Ok(Target::Replace(real)),
        Ok(real) => Ok(Target::Into(real)),
        // Nothing there yet. What is wrong with the folder shows when the file is created.
        Err(_) => Ok(Target::Replace(path.to_owned())),
    }
}

/// A name beside `path` that nobody else uses.
fn temporary(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.tmp", std::process::id()))
}

/// Writes files that belong together. All are written under other names first and then renamed, so that a failure to write
/// one leaves every old file as it was.
pub fn replace(outputs: &[Output]) -> Result<(), Error> {
    let mut written: Vec<(PathBuf, PathBuf)> = Vec::new();
    let result = replace_all(outputs, &mut written);
    if result.is_err() {
        for (temp, _) in &written {
            // It may have been renamed already, or never made.
            let _ = fs::remove_file(temp);
        }
    }
    result
}

fn replace_all(outputs: &[Output], written: &mut Vec<(PathBuf, PathBuf)>) -> Result<(), Error> {
    let mut direct = Vec::new();
    for output in outputs {
        let fail = |cause| Error::Write { path: output.path.clone(), cause };
        match target(&output.path).map_err(fail)? {
            Target::Replace(path) => {
                let temp = temporary(&path);
                written.push((temp.clone(), path));
                fs::write(&temp, &output.bytes).map_err(fail)?;
            }
            Target::Into(path) => direct.push((path, output)),
        }
    }
    for (path, output) in direct {
        fs::write(&path, &output.bytes).map_err(|cause| Error::Write { path: output.path.clone(), cause })?;
    }
    for (temp, path) in written.iter() {
        fs::rename(temp, path).map_err(|cause| Error::Write { path: path.clone(), cause })?;
    }
    Ok(())
}
