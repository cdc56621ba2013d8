//! `oslcl cache`: looks after the built programs on disk; and what other commands need of them.

use super::args::{BuildProgramsArgs, CacheArgs, CacheCommand, CacheDirArgs};
use super::{Error, terminal};
use oslcl_runtime::builders::{self, Recipe};
use oslcl_runtime::cache::{Broken, Cache, default_root};
use oslcl_runtime::device::Device;
use std::ffi::OsString;
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

/// Opens a device whose programs are kept where the arguments say, if anywhere.
pub fn device(wanted: Option<&str>, args: &CacheArgs) -> Result<Device, Error> {
    let device = Device::open(wanted)?;
    if args.no_cache {
        return Ok(device);
    }
    let cache = open(&args.place);
    let recipe = std::env::current_exe().ok().map(|program| {
        let mut args: Vec<OsString> = vec!["build-programs".into(), "--cache-dir".into(), cache.folder().into()];
        args.extend(["--cache-size".into(), cache.limit().to_string().into()]);
        args.extend(wanted.into_iter().flat_map(|name| ["--device".into(), name.into()]));
        Recipe { program, args, always: false }
    });
    Ok(device.with_cache(Some(Arc::new(cache))).with_builders(recipe))
}

/// `oslcl build-programs`: how another of our processes has programs built ([`builders`]).
pub fn build_programs(args: &BuildProgramsArgs) -> Result<(), Error> {
    let device = Device::open(args.device.as_deref())?.with_cache(Some(Arc::new(open(&args.place))));
    builders::serve(&device, io::stdin().lock(), io::stdout().lock()).map_err(Error::Print)
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
    for Broken { path, damage, removed } in &found.damaged {
        let done = if *removed { "removed" } else { "it is not empty, and stays" };
        terminal::say(&format!("{}: {damage}; {done}\n", path.display()));
    }
    terminal::print(&format!("{} programs are whole, {} were damaged\n", found.whole, found.damaged.len()))?;
    if found.damaged.is_empty() { Ok(()) } else { Err(Error::Reported) }
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}
