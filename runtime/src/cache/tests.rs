//! Entries on disk: damaged, crowded out, written by several at once.

use super::*;
use std::time::Duration;

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("oslcl-cache-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        Folder(path)
    }

    fn cache(&self) -> Cache {
        Cache::new(self.0.clone(), DEFAULT_LIMIT)
    }

    fn names(&self) -> Vec<String> {
        let list = fs::read_dir(&self.0).into_iter().flatten().flatten();
        list.map(|e| e.file_name().to_string_lossy().into_owned()).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn key(source: &str) -> Key {
    Key::new(&Parts { source, ..Parts::default() })
}

#[test]
fn what_is_put_comes_back_in_another_process() {
    let folder = Folder::new("round");
    assert_eq!(folder.cache().get(&key("a")), None);
    folder.cache().put(&key("a"), b"binary");
    let other = folder.cache();
    assert_eq!(other.get(&key("a")).as_deref(), Some(&b"binary"[..]));
    assert_eq!(other.get(&key("b")), None);
    let stats = other.stats().expect("a folder");
    assert_eq!((stats.entries, stats.bytes), (1, 52 + 6));
    assert!(other.complaints().is_empty());
    other.clear().expect("it is ours");
    assert_eq!(other.get(&key("a")), None);
    assert!(folder.names().is_empty());
}

#[test]
fn any_flipped_bit_and_any_truncation_is_found_before_a_driver_sees_it() {
    let folder = Folder::new("damage");
    folder.cache().put(&key("a"), b"some binary");
    let path = folder.cache().path(&key("a"));
    let whole = fs::read(&path).expect("an entry");
    let refused = |bytes: &[u8]| {
        fs::write(&path, bytes).expect("it can be written");
        let cache = folder.cache();
        assert_eq!(cache.get(&key("a")), None, "{bytes:?}");
        assert_eq!(cache.complaints().len(), 1);
        assert!(!path.exists(), "a damaged entry goes");
        // Built again, told once.
        cache.put(&key("a"), b"some binary");
        assert!(cache.get(&key("a")).is_some());
    };
    for bit in 0..8 * whole.len() {
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        refused(&bytes);
    }
    for length in 0..whole.len() {
        refused(&whole[..length]);
    }
    refused(&[whole.as_slice(), b"x"].concat());
}

#[test]
fn an_entry_under_the_name_of_another_is_damage() {
    let folder = Folder::new("renamed");
    let cache = folder.cache();
    cache.put(&key("a"), b"binary");
    fs::rename(cache.path(&key("a")), cache.path(&key("b"))).expect("it can be renamed");
    assert_eq!(cache.get(&key("b")), None);
}

#[test]
fn verify_removes_what_is_damaged_and_leaves_what_is_foreign() {
    let folder = Folder::new("verify");
    let cache = folder.cache();
    cache.put(&key("a"), b"one");
    cache.put(&key("b"), b"two");
    fs::write(cache.path(&key("b")), b"oslclbin").expect("it can be written");
    fs::write(folder.0.join("notes.txt"), b"mine").expect("it can be written");
    let found = cache.verify().expect("a folder");
    assert_eq!((found.whole, found.damaged.len()), (1, 1));
    assert_eq!((found.damaged[0].damage, found.damaged[0].removed), (Damage::Foreign, true));
    assert_eq!(cache.verify().expect("a folder").damaged.len(), 0);
    cache.clear().expect("it is ours");
    assert_eq!(folder.names(), ["notes.txt"]);
}

#[test]
fn a_folder_in_the_place_of_an_entry_costs_that_entry_alone() {
    let folder = Folder::new("folder-entry");
    let cache = folder.cache();
    let (full, empty) = (cache.path(&key("full")), cache.path(&key("empty")));
    fs::create_dir_all(full.join("mine")).expect("a folder");
    fs::create_dir_all(&empty).expect("a folder");
    for name in ["full", "empty", "other"] {
        assert!(!cache.has(&key(name)));
        assert_eq!(cache.get(&key(name)), None);
        cache.put(&key(name), b"binary");
    }
    let kept = ["full", "empty", "other"].map(|name| folder.cache().get(&key(name)).is_some());
    assert_eq!(kept, [false, true, true]);
    assert_eq!(cache.complaints().len(), 1, "{:?}", cache.complaints());
    assert!(cache.complaints()[0].ends_with("a folder stands in its place"), "{:?}", cache.complaints());
    // What is in a folder is not ours.
    fs::create_dir(cache.path(&key("late"))).expect("a folder");
    let mut found = cache.verify().expect("a folder");
    found.damaged.sort_by_key(|b| b.removed);
    let broken = |path: PathBuf, removed| Broken { path, damage: Damage::Folder, removed };
    assert_eq!(
        (found.whole, found.damaged),
        (2, vec![broken(full.clone(), false), broken(cache.path(&key("late")), true)])
    );
    assert!(full.join("mine").exists());
}

#[test]
fn the_least_recently_used_goes_first() {
    let folder = Folder::new("evict");
    let cache = Cache::new(folder.0.clone(), 3 * (52 + 100));
    let old = |name: &str, seconds: u64| {
        let file = File::options().write(true).open(cache.path(&key(name))).expect("an entry");
        file.set_modified(SystemTime::now() - Duration::from_secs(seconds)).expect("it has a time");
    };
    for (name, age) in [("a", 300), ("b", 200), ("c", 100)] {
        cache.put(&key(name), &[0; 100]);
        old(name, age);
    }
    // Used again, so `b` is the oldest now.
    assert!(cache.get(&key("a")).is_some());
    cache.put(&key("d"), &[0; 100]);
    let there = |name: &str| cache.path(&key(name)).exists();
    assert_eq!(["a", "b", "c", "d"].map(there), [true, false, true, true]);
    // One that is larger than all may be is not kept, and drives nobody out.
    cache.put(&key("e"), &[0; 1000]);
    assert_eq!(cache.stats().expect("a folder").entries, 3);
    assert!(cache.complaints().is_empty());
}

#[test]
fn what_killed_writers_leave_is_cleaned_up_when_it_is_old() {
    let folder = Folder::new("stale");
    fs::create_dir_all(&folder.0).expect("a folder");
    for (name, age) in [(".oslcl.1.0.tmp", 3600), (".oslcl.2.0.tmp", 1), ("other.tmp", 3600)] {
        let file = File::create(folder.0.join(name)).expect("a file");
        file.set_modified(SystemTime::now() - Duration::from_secs(age)).expect("it has a time");
    }
    let cache = folder.cache();
    cache.put(&key("a"), b"binary");
    let mut names = folder.names();
    names.retain(|n| n.ends_with(".tmp"));
    names.sort();
    assert_eq!(names, [".oslcl.2.0.tmp", "other.tmp"]);
}

#[test]
fn a_full_disk_is_told_once_and_leaves_nothing_behind() {
    let folder = Folder::new("full");
    let cache = folder.cache();
    let mut tries = 0;
    let mut full = |file: &mut File, bytes: &[u8]| {
        tries += 1;
        io::Write::write_all(file, &bytes[..10])?;
        Err(io::Error::from(io::ErrorKind::StorageFull))
    };
    cache.put_with(&key("a"), b"binary", &mut full);
    cache.put_with(&key("b"), b"binary", &mut full);
    assert_eq!(tries, 1, "after a failure nothing more is tried");
    assert_eq!(cache.complaints().len(), 1);
    assert!(cache.complaints()[0].contains("not kept for the next start"), "{:?}", cache.complaints());
    assert!(folder.names().is_empty(), "{:?}", folder.names());
    assert_eq!(cache.get(&key("a")), None);
}

#[test]
fn a_folder_that_cannot_be_is_told_once() {
    let folder = Folder::new("no-folder");
    fs::create_dir_all(&folder.0).expect("a folder");
    let file = folder.0.join("file");
    fs::write(&file, b"").expect("a file");
    let cache = Cache::new(file.join("programs"), DEFAULT_LIMIT);
    assert_eq!(cache.get(&key("a")), None);
    cache.put(&key("a"), b"binary");
    cache.put(&key("b"), b"binary");
    assert_eq!(cache.complaints().len(), 1, "{:?}", cache.complaints());
    assert_eq!(cache.stats().expect("nothing is there").entries, 0);
    assert!(cache.verify().is_ok() && cache.clear().is_ok());
}
