//! Files that are replaced as a whole or not at all.
//!
//! In: paths and bytes. Out: the files, through temporary ones in their folders. It must not know what they hold.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// A file to write.
#[derive(Clone, Debug)]
pub struct Output {
    /// Where.
    pub path: PathBuf,
    /// What.
    pub bytes: Vec<u8>,
}

/// A file that can't be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write `{}`: {cause}", path.display())]
pub struct Error {
    /// The file, as given.
    pub path: PathBuf,
    /// Why.
    pub cause: Cause,
}

/// Why a file can't be written.
#[derive(Debug, thiserror::Error)]
pub enum Cause {
    /// Its name is that of a folder.
    #[error("it is a folder")]
    IsFolder,
    /// Its folder is not there.
    #[error("there is no folder {}", .0.display())]
    NoFolder(PathBuf),
    /// The system refused.
    #[error(transparent)]
    System(#[from] io::Error),
}

/// Whether [`replace`] could write this file now. Leaves nothing behind.
pub fn probe(path: &Path) -> Result<(), Error> {
    let try_it = || match target(path)? {
        Target::Replace(real) => {
            let (file, temporary) = create(&real)?;
            drop(file);
            Ok(fs::remove_file(&temporary)?)
        }
        // Opening a pipe would wait for its reader.
        Target::Into(_) => Ok(()),
    };
    try_it().map_err(|cause| Error { path: path.to_owned(), cause })
}

/// Writes files that belong together. All are written under other names and wait for the disk before the first is renamed:
/// a failure to write one leaves every old file as it was, and readers see the old file or the new one.
pub fn replace(outputs: &[Output]) -> Result<(), Error> {
    let mut temporaries = Vec::new();
    let result = replace_all(outputs, &mut temporaries);
    if result.is_err() {
        for temporary in &temporaries {
            // The first error is the one to tell; this file may have been renamed already.
            let _ = fs::remove_file(temporary);
        }
    }
    result
}

/// Writes one file that can be made again at any time, as [`replace`] does, but without waiting for the disk: after a power cut
/// it may be damaged.
pub fn replace_unsynced(path: &Path, write: &mut dyn FnMut(&mut File) -> io::Result<()>) -> Result<(), Error> {
    let fail = |cause| Error { path: path.to_owned(), cause };
    let (mut file, temporary) = create(path).map_err(fail)?;
    let done = write(&mut file).and_then(|()| fs::rename(&temporary, path));
    if done.is_err() {
        // The first error is the one to tell.
        let _ = fs::remove_file(&temporary);
    }
    done.map_err(|e| fail(e.into()))
}

/// Whether a file of this name is one that was to be renamed, of this or another process.
pub fn is_temporary(name: &str) -> bool {
    name.starts_with(".oslcl.") && name.ends_with(".tmp")
}

fn replace_all(outputs: &[Output], temporaries: &mut Vec<PathBuf>) -> Result<(), Error> {
    let mut renames = Vec::new();
    let mut direct = Vec::new();
    for output in outputs {
        let fail = |cause| Error { path: output.path.clone(), cause };
        match target(&output.path).map_err(fail)? {
            Target::Replace(real) => {
                let (mut file, temporary) = create(&real).map_err(fail)?;
                temporaries.push(temporary.clone());
                file.write_all(&output.bytes).and_then(|()| file.sync_all()).map_err(|e| fail(e.into()))?;
                renames.push((temporary, real, output));
            }
            Target::Into(real) => direct.push((real, output)),
        }
    }
    for (real, output) in direct {
        fs::write(&real, &output.bytes).map_err(|e| Error { path: output.path.clone(), cause: e.into() })?;
    }
    for (temporary, real, output) in renames {
        fs::rename(&temporary, &real).map_err(|e| Error { path: output.path.clone(), cause: e.into() })?;
        // Makes the rename itself last. Systems that can't sync a folder have still replaced the file.
        if let Ok(folder) = File::open(folder(&real)) {
            let _ = folder.sync_all();
        }
    }
    Ok(())
}

/// Where the bytes really go: behind links, and straight into what is no regular file, such as a pipe or /dev/null.
enum Target {
    Replace(PathBuf),
    Into(PathBuf),
}

fn target(path: &Path) -> Result<Target, Cause> {
    match fs::canonicalize(path) {
        Ok(real) if real.is_dir() => Err(Cause::IsFolder),
        Ok(real) if real.is_file() => Ok(Target::Replace(real)),
        Ok(real) => Ok(Target::Into(real)),
        // Nothing there yet. What is wrong with the folder shows when the file is created.
        Err(_) => Ok(Target::Replace(path.to_owned())),
    }
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A new file beside `path`, under a name that nobody else uses and that is short whatever the file's is; see [`is_temporary`].
fn create(path: &Path) -> Result<(File, PathBuf), Cause> {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let folder = folder(path);
    if !folder.is_dir() {
        return Err(Cause::NoFolder(folder.to_owned()));
    }
    loop {
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        let temporary = folder.join(format!(".oslcl.{}.{number}.tmp", std::process::id()));
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Ok(file) => return Ok((file, temporary)),
            // Of a process that had our number: killed, or in another container with the same folder.
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test_folder(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("oslcl-files-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).expect("a temporary folder");
        path
    }

    fn names(at: &Path) -> Vec<String> {
        let entries = fs::read_dir(at).expect("a folder").flatten();
        let mut names: Vec<String> = entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn one_that_fails_leaves_the_others_as_they_were() {
        let at = test_folder("group");
        fs::write(at.join("a"), "old").expect("a file");
        fs::create_dir_all(at.join("b")).expect("a folder in the way");
        let output = |name: &str| Output { path: at.join(name), bytes: b"new".to_vec() };
        let error = replace(&[output("a"), output("b")]).expect_err("b is a folder");
        assert!(error.to_string().ends_with("b`: it is a folder"), "{error}");
        let error = replace(&[output("a"), output("none/c")]).expect_err("there is no folder");
        assert!(matches!(error.cause, Cause::NoFolder(_)), "{error}");
        assert_eq!(fs::read(at.join("a")).expect("the file"), b"old");
        replace(&[output("a"), output("c")]).expect("both can be written");
        assert_eq!(fs::read(at.join("a")).expect("the file"), b"new");
        assert_eq!(names(&at), ["a", "b", "c"]);
        fs::remove_dir_all(&at).expect("it is ours");
    }

    #[test]
    fn a_probe_changes_nothing() {
        let at = test_folder("probe");
        fs::write(at.join("a"), "old").expect("a file");
        probe(&at.join("a")).expect("it can be written");
        probe(&at.join("b")).expect("it can be written");
        // A name as long as file systems allow.
        probe(&at.join("x".repeat(255))).expect("it can be written");
        assert!(probe(&at.join("a/b")).is_err() && probe(&at).is_err());
        assert_eq!(names(&at), ["a"]);
        fs::remove_dir_all(&at).expect("it is ours");
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links() {
        let at = test_folder("links");
        fs::write(at.join("real"), "old").expect("a file");
        std::os::unix::fs::symlink("real", at.join("link")).expect("a link");
        replace(&[Output { path: at.join("link"), bytes: b"new".to_vec() }]).expect("it can be written");
        assert_eq!(fs::read(at.join("real")).expect("the file"), b"new");
        assert!(fs::symlink_metadata(at.join("link")).expect("it is there").is_symlink());
        fs::remove_dir_all(&at).expect("it is ours");
    }
}
