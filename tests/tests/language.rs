//! The language, feature by feature: the shaders of tests/corpus/language compute what the specification or the reference
//! implementation says, and count what comes out otherwise. They run on the device, and on the host in f64.
//!
//! docs/language.md names these files. Each prints what is wrong; `check.h` holds the macros.

use oslcl_compiler::{Includes, Master, Options};
use oslcl_runtime::device::Device;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::shade::{self, Grid, Shaded};
use oslcl_runtime::textures::Library;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/language")
}

struct Beside(PathBuf);

impl Includes for Beside {
    fn read(&self, path: &str, _from: Option<&str>, _system: bool) -> Option<(String, Arc<str>)> {
        let text = std::fs::read_to_string(self.0.join(path)).ok()?;
        Some((path.to_owned(), text.into()))
    }
}

/// What is wrong, in the shader's words; an error when it does not even count.
fn judge(shaded: &Shaded) -> Vec<String> {
    let mut wrong: Vec<String> = shaded.messages.iter().map(|m| m.text.clone()).collect();
    let [bad, checks] = &shaded.planes[..] else { return vec!["no counts".to_owned()] };
    if bad.data.iter().any(|n| *n != 0.0) && wrong.is_empty() {
        wrong.push("something is wrong that nobody speaks of".to_owned());
    }
    if checks.data.iter().any(|n| *n < 1.0) {
        wrong.push("nothing was checked".to_owned());
    }
    wrong.dedup();
    wrong
}

fn check(name: &str) {
    // PoCL finds no device while another thread asks for one.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _one = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
    let text = std::fs::read_to_string(folder().join(name)).expect("a shader");
    let textures = Some(Arc::new(Library::default()).access());
    let options = Options { file_name: name.to_owned(), textures, ..Options::default() };
    let master = Master::new(&text, &options, &Beside(folder())).unwrap_or_else(|e| panic!("{e}"));
    let grid = Grid::new(3, 2);
    let outputs = ["wrong".to_owned(), "checks".to_owned()];

    let shaded = shade::run_on_host(&master, &options, &outputs, grid).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(judge(&shaded), Vec::<String>::new(), "{name} on the host");

    let device = Device::open(None).expect("a device");
    let artifact = shade::compile(&master, &options, &outputs).unwrap_or_else(|e| panic!("{e}"));
    let shaded = shade::run(&device, &artifact, grid, Precision::Standard).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(judge(&shaded), Vec::<String>::new(), "{name} on the device");
}

macro_rules! chapters {
    ($($name:ident)*) => {
        $(
            #[test]
            fn $name() {
                check(concat!(stringify!($name), ".osl"));
            }
        )*

        #[test]
        fn no_file_is_left_out() {
            let known = [$(concat!(stringify!($name), ".osl")),*];
            for entry in std::fs::read_dir(folder()).expect("the folder").flatten() {
                let name = entry.file_name().to_string_lossy().into_owned();
                assert!(!name.ends_with(".osl") || known.contains(&name.as_str()), "no test runs {name}");
            }
        }
    };
}

chapters! { closures derivatives lexical library parameters syntax texts types }
