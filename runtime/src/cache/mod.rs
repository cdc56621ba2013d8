//! Built programs on disk, so that the next process starts at once.
//!
//! In: a key of all that decides a program, and a driver's binary of it. Out: the binary, for the same key, in any process.
//! It must not know devices or what programs do.
//!
//! One file an entry, named by its key; drivers may crash on damaged bytes, so that an entry carries a checksum (`entry`)
//! and counts as absent when it is wrong. Files appear by renaming: a reader sees all of an entry or nothing of it, whoever
//! writes or is killed at the same time. The least recently used go first when there are too many (`sweep`). Whatever fails
//! here costs time at the next start and no more: it is told once, by [`Cache::complaints`].

mod entry;
mod key;
mod sweep;

pub use entry::Damage;
pub use key::{Key, Parts};

use crate::files;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

/// Bytes that entries take at most unless told otherwise: some thousand programs.
pub const DEFAULT_LIMIT: u64 = 1 << 30;

/// The folder for all that can be made again: `oslcl` in the user's cache.
pub fn default_root() -> PathBuf {
    let home = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let cache = home("XDG_CACHE_HOME").or_else(|| home("HOME").map(|h| h.join(".cache")));
    cache.unwrap_or_else(std::env::temp_dir).join("oslcl")
}

/// A folder of entries.
#[derive(Debug)]
pub struct Cache {
    folder: PathBuf,
    limit: u64,
    /// Bytes of all entries as far as this process knows; `UNKNOWN` before it looked.
    total: AtomicU64,
    /// What went wrong: one text for each kind.
    complaints: Mutex<BTreeMap<Kind, String>>,
}

const UNKNOWN: u64 = u64::MAX;

/// What can go wrong. Each is told once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Damaged,
    Unreadable,
    Unwritable,
}

/// What a folder holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Entries.
    pub entries: u64,
    /// Bytes of them.
    pub bytes: u64,
    /// When the entry was used that nobody has used for the longest time.
    pub oldest: Option<SystemTime>,
}

/// What [`Cache::verify`] found.
#[derive(Debug, Default)]
pub struct Verified {
    /// Entries that are whole.
    pub whole: u64,
    /// Those that are not.
    pub damaged: Vec<Broken>,
}

/// An entry that is damaged.
#[derive(Debug, PartialEq, Eq)]
pub struct Broken {
    /// Its file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub damage: Damage,
    /// Whether it is gone now. A folder in its place that holds something stays: what is in there is not the cache's.
    pub removed: bool,
}

impl Cache {
    /// The cache in a folder, which need not be there yet, with the bytes that its entries take at most.
    pub fn new(folder: PathBuf, limit: u64) -> Cache {
        Cache { folder, limit, total: AtomicU64::new(UNKNOWN), complaints: Mutex::default() }
    }

    /// Where it is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Bytes that the entries take at most.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// The binary with this key. A damaged entry is removed.
    pub fn get(&self, key: &Key) -> Option<Vec<u8>> {
        let path = self.path(key);
        let bytes = match read(&path) {
            Ok(bytes) => bytes,
            Err(e) if absent(&e) => return None,
            Err(e) if e.kind() == io::ErrorKind::IsADirectory => {
                self.complain_of_folder(&path);
                return None;
            }
            Err(e) => {
                self.complain(Kind::Unreadable, || format!("{} cannot be read: {e}", path.display()));
                return None;
            }
        };
        match entry::decode(key, &bytes) {
            Ok(binary) => Some(binary.to_vec()),
            Err(damage) => {
                self.complain(Kind::Damaged, || format!("{} is built again: {damage}", path.display()));
                // If it can't be removed it is replaced, and if not even that, read in vain again.
                let _ = fs::remove_file(&path);
                None
            }
        }
    }

    /// Whether there is an entry with this key, whole or not.
    pub fn has(&self, key: &Key) -> bool {
        self.path(key).is_file()
    }

    /// Keeps a binary. After a failure nothing more is written by this process, unless the failure is this entry's alone.
    pub fn put(&self, key: &Key, binary: &[u8]) {
        self.put_with(key, binary, &mut |file, bytes| io::Write::write_all(file, bytes));
    }

    /// As [`Cache::put`], with what writes bytes to a file.
    fn put_with(&self, key: &Key, binary: &[u8], write: &mut dyn FnMut(&mut File, &[u8]) -> io::Result<()>) {
        let bytes = entry::encode(key, binary);
        if bytes.len() as u64 > self.limit || self.complained(Kind::Unwritable) {
            return;
        }
        let path = self.path(key);
        // An empty folder in its place gives way; one that holds something costs this entry and no other.
        if path.is_dir() && fs::remove_dir(&path).is_err() {
            self.complain_of_folder(&path);
            return;
        }
        let made = fs::create_dir_all(&self.folder).map_err(|e| format!("{}: {e}", self.folder.display()));
        let done = made
            .and_then(|()| files::replace_unsynced(&path, &mut |file| write(file, &bytes)).map_err(|e| e.to_string()));
        match done {
            Ok(()) => self.bound(bytes.len() as u64),
            Err(e) => self.complain(Kind::Unwritable, || format!("programs are not kept for the next start: {e}")),
        }
    }

    /// Removes entries when there are too many, now that one more of this size is there.
    fn bound(&self, more: u64) {
        let known = self.total.load(Ordering::Relaxed);
        let total = known.saturating_add(more);
        // Other processes write too; looking now and then is enough, for the limit is about disks, not about bytes.
        if known != UNKNOWN && total <= self.limit {
            self.total.fetch_add(more, Ordering::Relaxed);
            return;
        }
        if let Ok(left) = sweep::trim(&self.folder, self.limit, SystemTime::now()) {
            self.total.store(left, Ordering::Relaxed);
        }
    }

    /// What is in the folder.
    pub fn stats(&self) -> io::Result<Stats> {
        let entries = sweep::entries(&self.folder)?;
        Ok(Stats {
            entries: entries.len() as u64,
            bytes: entries.iter().map(|e| e.bytes).sum(),
            oldest: entries.iter().map(|e| e.used).min(),
        })
    }

    /// Removes all entries, and files that writers left behind. What else lies in the folder stays.
    pub fn clear(&self) -> io::Result<Stats> {
        let before = self.stats()?;
        sweep::remove_stale(&self.folder, SystemTime::now())?;
        for entry in sweep::entries(&self.folder)? {
            sweep::remove(&entry.path)?;
        }
        Ok(before)
    }

    /// Checks all entries, and removes those that are damaged: files, and empty folders in their places.
    pub fn verify(&self) -> io::Result<Verified> {
        let mut out = Verified::default();
        for entry in sweep::entries(&self.folder)? {
            let bytes = match fs::read(&entry.path) {
                Ok(bytes) => bytes,
                // Another process made room.
                Err(e) if absent(&e) => continue,
                Err(e) => return Err(e),
            };
            match entry::decode(&entry.key, &bytes) {
                Ok(_) => out.whole += 1,
                Err(damage) => {
                    sweep::remove(&entry.path)?;
                    out.damaged.push(Broken { path: entry.path, damage, removed: true });
                }
            }
        }
        for path in sweep::folders(&self.folder)? {
            let removed = fs::remove_dir(&path).is_ok();
            out.damaged.push(Broken { path, damage: Damage::Folder, removed });
        }
        Ok(out)
    }

    /// What went wrong so far, a text for each kind of trouble. None of it keeps anybody from rendering.
    pub fn complaints(&self) -> Vec<String> {
        self.complaints.lock().unwrap_or_else(PoisonError::into_inner).values().cloned().collect()
    }

    fn complain(&self, kind: Kind, text: impl FnOnce() -> String) {
        let mut all = self.complaints.lock().unwrap_or_else(PoisonError::into_inner);
        all.entry(kind).or_insert_with(|| format!("program cache: {}", text()));
    }

    fn complain_of_folder(&self, path: &Path) {
        self.complain(Kind::Damaged, || format!("{} is built again: {}", path.display(), Damage::Folder));
    }

    fn complained(&self, kind: Kind) -> bool {
        self.complaints.lock().unwrap_or_else(PoisonError::into_inner).contains_key(&kind)
    }

    fn path(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{key}{}", sweep::ENDING))
    }
}

/// The bytes of a file, which counts as used now.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    // In a folder of somebody else's it keeps its age.
    let _ = file.set_modified(SystemTime::now());
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Whether this is how a missing file shows; something on the way to it may be a file.
fn absent(e: &io::Error) -> bool {
    matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

#[cfg(test)]
mod tests;
