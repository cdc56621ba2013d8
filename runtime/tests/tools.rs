//! Runs `oslc` and `oslinfo` as scripts do: by a link's name or behind `oslcl`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What a run said.
struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

/// An empty folder of the test's own.
fn folder(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tools").join(test);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a folder for the test");
    path
}

fn run(program: &Path, at: &Path, args: &[&str]) -> Run {
    let output = Command::new(program).current_dir(at).args(args).stdin(Stdio::null()).output().expect("it starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the output is UTF-8");
    let run = Run { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) };
    assert!(!run.err.contains("panicked"), "{}", run.err);
    run
}

fn oslcl(at: &Path, args: &[&str]) -> Run {
    run(Path::new(env!("CARGO_BIN_EXE_oslcl")), at, args)
}

fn says(run: &Run, code: i32, out: &str, err: &str) {
    assert_eq!((run.code, run.out.as_str()), (Some(code), out), "err: {}", run.err);
    assert!(if err.is_empty() { run.err.is_empty() } else { run.err.contains(err) }, "err: {}", run.err);
}

const CHALK: &str = "#include \"tint.h\"\nsurface chalk [[ string help = \"white\" ]]\n\
    (float Kd = GAIN [[ float min = 0 ]], color Cs = color(0.5, 0.25, 1), output float f = u)\n{\n\
        int unused[2] = { 1, 2 };\n    f = Kd * luminance(Cs) + unused[1];\n    Ci = TINT * Cs * diffuse(N);\n}\n";

fn chalk(at: &Path) {
    fs::create_dir_all(at.join("headers")).expect("a folder");
    fs::write(at.join("headers/tint.h"), "#define TINT 0.5\n").expect("a header");
    fs::write(at.join("chalk.osl"), CHALK).expect("a shader");
}

#[test]
fn links_answer_by_their_names() {
    let at = folder("links");
    let made = oslcl(&at, &["install-tools", "bin"]);
    assert_eq!(made.code, Some(0), "{}", made.err);
    for tool in ["oslc", "oslinfo"] {
        let link = at.join("bin").join(tool);
        let help = run(&link, &at, &["--help"]);
        assert!(help.out.contains(&format!("{tool} -- ")), "{}", help.out);
        let version = run(&link, &at, &["--version"]);
        assert!(version.out.starts_with(tool), "{}", version.out);
    }
    // Again: links are replaced, but no file of the user's.
    assert_eq!(oslcl(&at, &["install-tools", "bin"]).code, Some(0));
    fs::remove_file(at.join("bin/oslc")).expect("the link goes");
    fs::write(at.join("bin/oslc"), "mine").expect("a file");
    let refused = oslcl(&at, &["install-tools", "bin"]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.err.contains("bin/oslc"), "{}", refused.err);
    assert_eq!(fs::read_to_string(at.join("bin/oslc")).expect("the file"), "mine");
}

#[test]
fn oslc_compiles_with_includes_macros_and_dependencies() {
    let at = folder("oslc");
    chalk(&at);
    let args = ["oslc", "-Iheaders", "-DGAIN=2", "-MMD", "-MF", "deps.d", "-Wall", "-O2", "chalk.osl"];
    says(&oslcl(&at, &args), 0, "Compiled chalk.osl -> chalk.oso\n", "");
    let text = fs::read_to_string(at.join("chalk.oso")).expect("the output");
    for part in [
        "OpenShadingLanguage 1.00\n",
        "surface chalk\t%meta{string,help,\"white\"}\n",
        "param\tfloat\tKd\t2\t\t%meta{float,min,0} %read{",
        "oparam\tfloat\tf\t0\t\t%read{",
        "%initexpr",
        "code f\n",
        "code ___main___\n",
        "%filename{\"chalk.osl\"} %line{",
        "\tend\n",
    ] {
        assert!(text.contains(part), "`{part}` is not in:\n{text}");
    }
    assert_eq!(fs::read_to_string(at.join("deps.d")).expect("the list"), "chalk.oso: chalk.osl \\\n  headers/tint.h\n");
    let args = ["oslc", "-q", "-I", "headers", "-D", "GAIN=1", "-o", "out.oso", "chalk.osl"];
    says(&oslcl(&at, &args), 0, "", "");
    assert!(at.join("out.oso").is_file());
    let listed = oslcl(&at, &["oslc", "-Iheaders", "-DGAIN=1", "-MM", "-MT", "all", "chalk.osl"]);
    says(&listed, 0, "all: chalk.osl \\\n  headers/tint.h\n", "");
    let only = oslcl(&at, &["oslc", "-E", "-Iheaders", "-DGAIN=7", "chalk.osl"]);
    assert!(only.out.contains("float Kd = 7") && only.out.contains("\"chalk.osl\""), "{}", only.out);
}

#[test]
fn oslc_names_files_lines_and_causes() {
    let at = folder("oslc_errors");
    fs::write(at.join("a.osl"), "shader a(output float f = 0)\n{\n    f = g + 1;\n    f = \"x\";\n}\n")
        .expect("a shader");
    let failed = oslcl(&at, &["oslc", "a.osl"]);
    says(&failed, 1, "FAILED a.osl\n", "a.osl:3: error: ");
    assert!(failed.err.contains("a.osl:4: error: "), "{}", failed.err);
    assert!(!at.join("a.oso").exists());
    let warned = "shader b(output float f = 0)\n{\n    float a[2] = { 1, 2 };\n    f = a[3];\n}\n";
    fs::write(at.join("b.osl"), warned).expect("a shader");
    // The reference says nothing of that: -v does.
    says(&oslcl(&at, &["oslc", "-Werror", "b.osl"]), 0, "Compiled b.osl -> b.oso\n", "");
    assert!(oslcl(&at, &["oslc", "-v", "b.osl"]).err.contains("b.osl:4: warning: "));
    let commas = "shader c(output color f = 0)\n{\n    f = (1, 0, 0);\n}\n";
    fs::write(at.join("c.osl"), commas).expect("a shader");
    says(&oslcl(&at, &["oslc", "c.osl"]), 0, "Compiled c.osl -> c.oso\n", "c.osl:3: warning: ");
    says(&oslcl(&at, &["oslc", "-Werror", "c.osl"]), 1, "FAILED c.osl\n", "c.osl:3: error: ");
    says(&oslcl(&at, &["oslc", "nowhere.osl"]), 1, "FAILED nowhere.osl\n", "cannot read `nowhere.osl`");
    says(&oslcl(&at, &["oslc", "-frobnicate", "a.osl"]), 2, "", "unknown option `-frobnicate`");
    let none = oslcl(&at, &["oslc", "-q"]);
    assert!(none.code == Some(1) && none.out.starts_with("ERROR: Missing shader path"), "{}", none.out);
}

#[test]
fn oslinfo_tells_of_oso_and_osl_the_same() {
    let at = folder("oslinfo");
    chalk(&at);
    fs::write(at.join("plain.osl"), CHALK.replace("#include \"tint.h\"", "#define TINT 1\n#define GAIN 2"))
        .expect("a shader");
    let short = "surface \"chalk\"\nfloat Kd  2\ncolor Cs  [ 0.5 0.25 1 ]\noutput float f nodefault\n";
    says(&oslcl(&at, &["oslinfo", "plain.osl"]), 0, short, "");
    assert_eq!(oslcl(&at, &["oslc", "-q", "-Iheaders", "-DGAIN=2", "chalk.osl"]).code, Some(0));
    says(&oslcl(&at, &["oslinfo", "chalk"]), 0, short, "");
    says(&oslcl(&at, &["oslinfo", "--param", "Kd", "chalk.oso"]), 0, "float Kd  2\n", "");
    let long = "surface \"chalk\"\n\t\tmetadata: string help = \"white\"\n    \"Kd\" \"float\"\n\t\tDefault value: 2\n\
        \t\tmetadata: float min = 0\n    \"Cs\" \"color\"\n\t\tDefault value: [ 0.5 0.25 1 ]\n    \"f\" \"output float\"\n\
        \t\tUnknown default value\n";
    let sub = folder("oslinfo_elsewhere");
    let path = format!("none:{}", at.display());
    says(&oslcl(&sub, &["oslinfo", "-v", "-p", &path, "chalk"]), 0, long, "");
    let lost = oslcl(&at, &["oslinfo", "nowhere"]);
    says(&lost, 0, "ERROR opening shader \"nowhere\" (File \"nowhere\" could not be found.)\n", "");
    let json = oslcl(&at, &["oslinfo", "--json", "chalk"]);
    assert!(json.out.contains("\"name\": \"Kd\"") && json.code == Some(0), "{}", json.out);
}

#[test]
fn the_commands_take_oso() {
    let at = folder("commands");
    chalk(&at);
    assert_eq!(oslcl(&at, &["oslc", "-q", "-Iheaders", "-DGAIN=2", "chalk.osl"]).code, Some(0));
    says(&oslcl(&at, &["check", "chalk.oso"]), 0, "chalk.oso: ok\n", "");
    let compiled = oslcl(&at, &["compile", "chalk.oso", "-o", "out", "--param", "Kd=0.5"]);
    assert_eq!(compiled.code, Some(0), "{}", compiled.err);
    assert!(at.join("out/chalk.cl").is_file() && at.join("out/chalk.json").is_file());
    let info = oslcl(&at, &["info", "chalk.oso"]);
    assert!(info.out.contains("color Cs = 0.5 0.25 1"), "{}", info.out);
    let text = fs::read_to_string(at.join("chalk.oso")).expect("the file").replace("luminance", "luminanse");
    fs::write(at.join("bad.oso"), text).expect("a file");
    let bad = oslcl(&at, &["check", "bad.oso"]);
    assert_eq!(bad.code, Some(1));
    for part in ["bad.oso:", "E5002", "`luminanse` is not known", "is `luminance` meant?; it comes from chalk.osl:6"] {
        assert!(bad.err.contains(part), "`{part}` is not in: {}", bad.err);
    }
}

/// A scene's shader may be a file beside it: by its whole name, or without an ending.
#[test]
fn scenes_take_oso() {
    let at = folder("scenes");
    chalk(&at);
    assert_eq!(oslcl(&at, &["oslc", "-q", "-Iheaders", "-DGAIN=2", "chalk.osl"]).code, Some(0));
    fs::remove_file(at.join("chalk.osl")).expect("the source goes");
    let head = "[camera]\norigin = [0, -4, 0]\ntarget = [0, 0, 0]\n\
        [[meshes]]\nname = \"ball\"\nshape = \"sphere\"\nmaterial = \"m\"\n[materials.m]\n";
    for line in ["shader = \"chalk.oso\"", "shader = \"chalk\"", "group = \"param float Kd 0.5; shader chalk layer1;\""]
    {
        fs::write(at.join("scene.toml"), format!("{head}{line}\n")).expect("a scene");
        let plan = oslcl(&at, &["plan", "scene.toml"]);
        assert_eq!(plan.code, Some(0), "{line}: {}", plan.err);
        assert!(plan.out.contains("diffuse"), "{line}: {}", plan.out);
    }
}

/// Many files at a time: what is said of each comes in the order of the files.
#[test]
fn many_files_are_compiled_in_their_order() {
    let at = folder("many");
    let names: Vec<String> = (0..24).map(|i| format!("s{i:02}.osl")).collect();
    for (i, name) in names.iter().enumerate() {
        let wrong = if i % 5 == 3 { "nothing" } else { "u" };
        fs::write(at.join(name), format!("surface s{i}() {{ Ci = {wrong} * diffuse(N); }}\n")).expect("a shader");
    }
    let mut args = vec!["compile", "-o", "out"];
    args.extend(names.iter().map(String::as_str));
    let done = oslcl(&at, &args);
    assert_eq!(done.code, Some(1));
    let order = |text: &str| -> Vec<usize> {
        let of = |line: &str| names.iter().position(|n| line.starts_with(&format!("{n}:")));
        text.lines().filter_map(of).collect()
    };
    assert_eq!(order(&done.out), (0..24).filter(|i| i % 5 != 3).collect::<Vec<_>>());
    assert_eq!(order(&done.err), [3, 8, 13, 18, 23]);
}

#[test]
fn oslc_says_all_its_warnings() {
    let at = folder("warnings");
    let twice = "void f() { }\nvoid f() { }\n";
    let text = format!("{twice}string concat(string a, string b) {{ return a; }}\n{twice}shader many() {{ f(); }}\n");
    fs::write(at.join("many.osl"), text).expect("a shader");
    let run = oslcl(&at, &["oslc", "many.osl"]);
    let lines = |n: u32| run.err.matches(&format!("many.osl:{n}: warning")).count();
    assert_eq!((1..=6).map(lines).collect::<Vec<_>>(), [0, 1, 1, 2, 3, 0], "{}", run.err);
}
