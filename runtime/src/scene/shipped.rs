//! The materials that ship, inside the library.
//!
//! In: `shaders-osl/`. Out: OSL source by name. It must not know what OSL means.

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        const SHADERS: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../shaders-osl/", $name, ".osl")))),*];
    };
}

shipped![
    "car_paint",
    "checker",
    "emitter",
    "flat_sky",
    "glass",
    "marble",
    "matte",
    "matte_noise",
    "metal",
    "plastic",
    "rough_glass",
    "sky",
    "textured",
    "velvet",
    "wood",
];

/// The OSL source of a shipped shader.
///
/// ```
/// assert!(oslcl_runtime::scene::shipped("matte").is_some());
/// assert!(oslcl_runtime::scene::shipped("no such shader").is_none());
/// ```
pub fn shipped(name: &str) -> Option<&'static str> {
    SHADERS.iter().find(|(n, _)| *n == name).map(|(_, source)| *source)
}

/// The names of the shipped shaders, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    SHADERS.iter().map(|(name, _)| *name)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    #[test]
    fn every_file_of_the_folder_is_listed() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders-osl");
        let files = std::fs::read_dir(folder).expect("the folder is part of the project");
        let names = files.map(|file| file.expect("readable").file_name().into_string().expect("ASCII names"));
        let mut found: Vec<String> = names.filter_map(|n| n.strip_suffix(".osl").map(str::to_string)).collect();
        found.sort();
        assert_eq!(found, super::names().collect::<Vec<_>>());
    }
}
