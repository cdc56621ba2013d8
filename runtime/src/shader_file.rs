//! Where the file of a shader lies: `.osl` (source) and `.oso` (compiled) stand for the same shader.
//!
//! In: a name, folders. Out: a path. It must not know what is in the file.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The ending of packages of compiled shaders.
pub const PACKAGE: &str = "oslpak";

/// The file of a shader in the first folder that has it. A name that ends in `.osl` or `.oso` is that file alone. Of both
/// files, the newer is taken: a compiled shader that is older than its source does not say what the source says.
pub fn find(name: &str, folders: &[PathBuf]) -> Option<PathBuf> {
    let ended = is_shader(Path::new(name));
    folders.iter().find_map(|folder| {
        if ended {
            return Some(folder.join(name)).filter(|p| p.is_file());
        }
        let [compiled, source] = ["oso", "osl"].map(|e| folder.join(format!("{name}.{e}")));
        match (changed(&compiled), changed(&source)) {
            (Some(c), Some(s)) if s > c => Some(source),
            (Some(_), _) => Some(compiled),
            (None, Some(_)) => Some(source),
            (None, None) => None,
        }
    })
}

/// Whether a path ends as shaders do.
pub fn is_shader(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "osl" || e == "oso")
}

/// The package that a name speaks of, and which shader of it: `materials.oslpak:plastic`, or `plastic.oslpak` of a package with
/// one shader.
pub fn in_package(name: &str) -> Option<(&str, Option<&str>)> {
    let is_package = |file: &str| Path::new(file).extension().is_some_and(|e| e == PACKAGE);
    match name.rsplit_once(':') {
        Some((file, shader)) if is_package(file) => Some((file, Some(shader))),
        _ if is_package(name) => Some((name, None)),
        _ => None,
    }
}

/// When a file was last written; `None` when there is no such file.
fn changed(path: &Path) -> Option<SystemTime> {
    let data = std::fs::metadata(path).ok().filter(|m| m.is_file())?;
    Some(data.modified().unwrap_or(SystemTime::UNIX_EPOCH))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};
    use std::time::Duration;

    #[test]
    fn shaders_of_packages_have_names() {
        assert_eq!(in_package("a/b.oslpak:plastic"), Some(("a/b.oslpak", Some("plastic"))));
        assert_eq!(in_package("b.oslpak"), Some(("b.oslpak", None)));
        assert_eq!(in_package("c:\\b.oslpak"), Some(("c:\\b.oslpak", None)));
        assert_eq!(in_package("b.osl"), None);
        assert_eq!(in_package("b.osl:x"), None);
    }

    #[test]
    fn the_newer_of_both_is_found() {
        let folder = std::env::temp_dir().join(format!("oslcl-shader-file-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let at = |name: &str, seconds: u64| {
            let path = folder.join(name);
            let file = File::create(&path).expect("a file");
            file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds)).expect("its time");
            path
        };
        let folders = [folder.join("none"), folder.clone()];
        assert_eq!(find("a", &folders), None);
        let source = at("a.osl", 10);
        assert_eq!(find("a", &folders), Some(source.clone()));
        let compiled = at("a.oso", 10);
        assert_eq!(find("a", &folders), Some(compiled.clone()));
        at("a.osl", 11);
        assert_eq!(find("a", &folders), Some(source.clone()));
        assert_eq!(find("a.oso", &folders), Some(compiled));
        assert_eq!(find("a.osl", &folders), Some(source));
        assert_eq!(find("b.osl", &folders), None);
        fs::remove_dir_all(&folder).expect("the folder goes");
    }
}
