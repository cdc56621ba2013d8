//! Files that are replaced as a whole or not at all.
//!
//! In: bytes and a path. Out: the file, through a temporary file in its folder. It must not know pictures.

use super::Error;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Whether `replace` could work.
pub(super) fn probe(path: &Path) -> Result<(), Error> {
    let (file, temporary) = create(path)?;
    drop(file);
    fs::remove_file(&temporary).map_err(|cause| Error::Unwritable { path: path.to_path_buf(), cause })
}

/// Writes to a temporary file, waits for the disk, and renames it: readers see the old file or the new one.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let (mut file, temporary) = create(path)?;
    let written = file.write_all(bytes).and_then(|()| file.sync_all()).and_then(|()| fs::rename(&temporary, path));
    written.map_err(|cause| {
        // The first error is the one to tell; what is left is a hidden file.
        let _ = fs::remove_file(&temporary);
        Error::Unwritable { path: path.to_path_buf(), cause }
    })?;
    // Makes the rename itself last. Systems that can't sync a folder have still replaced the file.
    if let Ok(folder) = File::open(folder(path)) {
        let _ = folder.sync_all();
    }
    Ok(())
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A new file beside `path`.
fn create(path: &Path) -> Result<(File, PathBuf), Error> {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let folder = folder(path);
    if path.is_dir() {
        return Err(Error::IsFolder { path: path.to_path_buf() });
    }
    if !folder.is_dir() {
        return Err(Error::NoFolder { path: path.to_path_buf(), folder: folder.to_path_buf() });
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let number = COUNTER.fetch_add(1, Ordering::Relaxed);
    let temporary = folder.join(format!(".{name}.{}.{number}.tmp", std::process::id()));
    let opened = OpenOptions::new().write(true).create_new(true).open(&temporary);
    match opened {
        Ok(file) => Ok((file, temporary)),
        Err(cause) => Err(Error::Unwritable { path: path.to_path_buf(), cause }),
    }
}
