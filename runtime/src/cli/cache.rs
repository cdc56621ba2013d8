//! `oslcl cache`: looks after the built programs on disk; and what other commands need of them.

use super::args::{CacheArgs, CacheCommand, CacheDirArgs};
use super::{Error, terminal};
use oslcl_runtime::cache::{Cache, default_root};
use oslcl_runtime::device::Device;
use std::fmt::Write;
use std::io;
use std::sync::Arc;
use std::time::SystemTime;

/// Carries out what is asked for.
pub fn run(command: &CacheCommand) -> Result<(), Error> {
    match command {
        CacheCommand::Stats(args) => stats(&open(args)),
        CacheCommand::Clear(args) => {
            let cache = open(args);
            let was = cache.clear().map_err(|e| failed(&cache, e))?;
            terminal::print(&format!("{} programs removed, {}\n", was.entries, mebibytes(was.bytes)))
        }
        CacheCommand::Verify(args) => verify(&open(args)),
    }
}

/// Where a command keeps programs, if it does.
pub fn of(args: &CacheArgs) -> Option<Arc<Cache>> {
    (!args.no_cache).then(|| Arc::new(open(&args.place)))
}

/// Says what went wrong with a device's cache.
pub fn complain(device: &Device) {
    for text in device.cache().map(Cache::complaints).unwrap_or_default() {
        terminal::say(&format!("warning: {text}\n"));
    }
}

fn open(args: &CacheDirArgs) -> Cache {
    let folder = args.cache_dir.clone().filter(|f| !f.as_os_str().is_empty());
    Cache::new(folder.unwrap_or_else(|| default_root().join("programs")), args.cache_size)
}

fn failed(cache: &Cache, cause: io::Error) -> Error {
    Error::Cache { folder: cache.folder().to_owned(), cause }
}

fn stats(cache: &Cache) -> Result<(), Error> {
    let stats = cache.stats().map_err(|e| failed(cache, e))?;
    let mut out = format!("folder     {}\n", cache.folder().display());
    let _ = writeln!(out, "programs   {}", stats.entries);
    let _ = writeln!(out, "size       {} of at most {}", mebibytes(stats.bytes), mebibytes(cache.limit()));
    if let Some(age) = stats.oldest.and_then(|t| SystemTime::now().duration_since(t).ok()) {
        let _ = writeln!(out, "oldest     last used {:.1} days ago", age.as_secs_f64() / 86_400.0);
    }
    terminal::print(&out)
}

fn verify(cache: &Cache) -> Result<(), Error> {
    let found = cache.verify().map_err(|e| failed(cache, e))?;
    for (path, damage) in &found.damaged {
        terminal::say(&format!("{}: {damage}; removed\n", path.display()));
    }
    terminal::print(&format!("{} programs are whole, {} were damaged\n", found.whole, found.damaged.len()))?;
    if found.damaged.is_empty() { Ok(()) } else { Err(Error::Reported) }
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}
