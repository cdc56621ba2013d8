//! What lies in a cache's folder, and what of it goes.
//!
//! In: a folder, a limit, the time. Out: a list, or fewer files. It must not know what entries hold.

use super::{Key, absent};
use crate::files;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use std::{fs, io};

/// How entries' names end.
pub(super) const ENDING: &str = ".program";

/// Age from which on the file of a writer that did not finish counts as left behind: no entry takes that long to write.
const STALE: Duration = Duration::from_secs(600);

/// A file that is named like an entry.
pub(super) struct Entry {
    pub path: PathBuf,
    pub key: Key,
    pub bytes: u64,
    /// Last use.
    pub used: SystemTime,
}

/// All entries; none where there is no folder.
pub(super) fn entries(folder: &Path) -> io::Result<Vec<Entry>> {
    let mut out = Vec::new();
    for (path, name, about) in listed(folder, fs::Metadata::is_file)? {
        let Some(key) = name.strip_suffix(ENDING).and_then(Key::parse) else { continue };
        let used = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
        out.push(Entry { path, key, bytes: about.len(), used });
    }
    Ok(out)
}

/// Folders that are named like entries, which stand in the place of these.
pub(super) fn folders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let is_entry = |name: &str| name.strip_suffix(ENDING).and_then(Key::parse).is_some();
    let all = listed(folder, fs::Metadata::is_dir)?;
    Ok(all.into_iter().filter(|(_, name, _)| is_entry(name)).map(|(path, ..)| path).collect())
}

/// Removes the entries that were not used for the longest time until the rest fits; returns the rest's bytes.
pub(super) fn trim(folder: &Path, limit: u64, now: SystemTime) -> io::Result<u64> {
    remove_stale(folder, now)?;
    let mut all = entries(folder)?;
    all.sort_by_key(|e| e.used);
    let mut total: u64 = all.iter().map(|e| e.bytes).sum();
    for entry in all {
        if total <= limit {
            break;
        }
        remove(&entry.path)?;
        total -= entry.bytes;
    }
    Ok(total)
}

/// Removes files that writers left behind, killed before they could rename them.
pub(super) fn remove_stale(folder: &Path, now: SystemTime) -> io::Result<()> {
    for (path, name, about) in listed(folder, fs::Metadata::is_file)? {
        let old = || about.modified().is_ok_and(|m| now.duration_since(m).is_ok_and(|age| age > STALE));
        if files::is_temporary(&name) && old() {
            remove(&path)?;
        }
    }
    Ok(())
}

/// Removes a file; another process may have been quicker.
pub(super) fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(e) if !absent(&e) => Err(e),
        _ => Ok(()),
    }
}

/// What is in a folder and of this kind: path, name, what the system knows.
fn listed(folder: &Path, kind: fn(&fs::Metadata) -> bool) -> io::Result<Vec<(PathBuf, String, fs::Metadata)>> {
    let list = match fs::read_dir(folder) {
        Ok(list) => list,
        Err(e) if absent(&e) => return Ok(Vec::new()),
        Err(e) => return Err(e),
    };
    let mut out = Vec::new();
    for file in list {
        let file = file?;
        // One that another process removed meanwhile is none.
        let Ok(about) = file.metadata() else { continue };
        if let (true, Ok(name)) = (kind(&about), file.file_name().into_string()) {
            out.push((file.path(), name, about));
        }
    }
    Ok(out)
}
