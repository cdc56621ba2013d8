//! Hostile and very large inputs: each gives a result or an error in bounded time and memory, and never a crash.
//!
//! In: sources made here. Out: pass or fail. The times that a machine may take are far above what it needs, so that a busy
//! machine passes; growth faster than the input would not.

use oslcl_compiler::{Entry, Failure, Includes, NoIncludes, Options, Output, compile};
use std::fmt::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What a large input may take: ten times what the slowest needs on an idle machine.
const PATIENCE: Duration = Duration::from_secs(60);

fn grid(source: &str) -> Result<Output, Failure> {
    let options = Options { entry: Entry::Grid(vec!["f".into()]), spirv: true, ..Options::default() };
    compile(source, &options, &NoIncludes)
}

/// Compiles in time, whatever comes out; the codes of the errors.
fn codes(source: &str) -> Vec<&'static str> {
    let start = Instant::now();
    let result = grid(source);
    let took = start.elapsed();
    println!("{} bytes: {:.2} s", source.len(), took.as_secs_f64());
    assert!(took < PATIENCE, "{} bytes took {took:?}", source.len());
    match result {
        Ok(_) => Vec::new(),
        Err(failure) => {
            assert!(!failure.diagnostics.is_empty(), "a failure without a diagnostic");
            // Rendering is part of what must not crash.
            assert!(!failure.to_string().is_empty());
            failure.diagnostics.iter().map(|d| d.code).collect()
        }
    }
}

fn in_body(statements: &str) -> String {
    format!("shader s(output float f = 0) {{ {statements} }}")
}

/// An expression between many repetitions, in a shader.
fn nested(before: &str, middle: &str, behind: &str, times: usize) -> String {
    in_body(&format!("f = {}{middle}{};", before.repeat(times), behind.repeat(times)))
}

#[test]
fn fifty_thousand_of_everything_that_nests() {
    let n = 50_000;
    let cases = [
        nested("(", "u", ")", n),
        nested("- ", "u", "", n),
        nested("!", "u", "", n),
        nested("~", "1", "", n),
        nested("(float)", "u", "", n),
        nested("u ? 1 : ", "2", "", n),
        nested("u ? ", "2", " : 1", n),
        nested("f = ", "2", "", n),
        nested("sin(", "u", ")", n),
        nested("color(", "u", ")", n),
        nested("a[", "u", "]", n),
        nested("1 + ", "u", "", n),
        nested("1 + (", "u", ")", n),
        nested("u && ", "v", "", n),
        nested("u, ", "v", "", n),
        nested("", "u", "[0]", n),
        nested("", "u", ".x", n),
        nested("", "f", "++", n),
        in_body(&format!("{} f = 1; {}", "{".repeat(n), "}".repeat(n))),
        in_body(&format!("{} f = 1;", "if (u) ".repeat(n))),
        in_body(&format!("{} f = 1; {}", "if (u) {".repeat(n), "}".repeat(n))),
        in_body(&format!("{} f = 1;", "while (u) ".repeat(n))),
        in_body(&format!("{} f = 1;", "for (;;) ".repeat(n))),
        in_body(&format!("{} f = 1; {}", "do ".repeat(n), "while (u);".repeat(n))),
        in_body(&format!("{} f = 1;", "if (u) f = 2; else ".repeat(n))),
        in_body(&format!("float a[2] = {}1{};", "{".repeat(n), "}".repeat(n))),
        in_body(&format!("{} {}", "float g() { ".repeat(n), "return 1; }".repeat(n))),
        "(".repeat(n),
        ")".repeat(n),
        "{".repeat(n),
        "[[".repeat(n),
        "#if 1\n".repeat(n),
        format!("#if {}1{}\n#endif\n", "(".repeat(n), ")".repeat(n)),
        format!("#if {}1\n#endif\n", "!".repeat(n)),
    ];
    for case in cases {
        let found = codes(&case);
        assert!(!found.contains(&"E4299"), "{}", &case[..80]);
    }
}

#[test]
fn what_is_accepted_nests_as_deep_as_it_says() {
    // Just below the limit of brackets, so that every recursive stage runs at its deepest.
    let n = 900;
    assert!(codes(&nested("(", "u", ")", n)).is_empty());
    assert!(codes(&nested("sin(", "u", ")", n)).is_empty());
    assert!(codes(&nested("1 + (", "u", ")", n)).is_empty());
    assert!(codes(&nested("1 + ", "u", "", 9_000)).is_empty());
    assert!(codes(&nested("- ", "u", "", 9_000)).is_empty());
    assert!(codes(&in_body(&format!("{} f = u; {}", "{".repeat(n), "}".repeat(n)))).is_empty());
    // OpenCL compilers take fewer levels of control flow than we do: a diagnostic, not a broken program.
    assert_eq!(codes(&in_body(&format!("{} f += u; {}", "if (u > f) {".repeat(n), "}".repeat(n)))), ["E4202"]);
}

#[test]
fn ten_megabytes_of_statements() {
    let mut text = String::new();
    let mut i = 0;
    while text.len() < 10_000_000 {
        let _ = writeln!(
            text,
            "    // Statement number {i} of a shader that somebody's program wrote.\n    f = f * 0.5 + u;"
        );
        i += 1;
    }
    assert!(codes(&in_body(&text)).is_empty());
}

#[test]
fn ten_megabytes_of_functions() {
    let mut text = String::new();
    let mut i = 0;
    while text.len() < 10_000_000 {
        let _ = writeln!(
            text,
            "float step_{i}(float x, color c)\n{{\n    color a = c * x + color(0.25, x, 1);\n    if (x > 0.5)\n        \
             return a[0] + sin(x);\n    for (int i = 0; i < 4; i++)\n        a += i * c;\n    return dot((vector)a, N);\n}}"
        );
        i += 1;
    }
    text.push_str("shader s(output float f = 0) { f = step_1(u, 1) + step_100(v, 2); }");
    assert!(codes(&text).is_empty());
}

#[test]
fn ten_thousand_functions_that_are_all_called() {
    let mut text = String::new();
    for i in 0..10_000 {
        let _ = writeln!(text, "float f{i}(float x) {{ return x * {i} + 1; }}");
    }
    text.push_str("shader s(output float f = 0) {\n");
    for i in 0..10_000 {
        let _ = writeln!(text, "f += f{i}(u);");
    }
    text.push('}');
    assert!(codes(&text).is_empty());
}

#[test]
fn a_chain_of_ten_thousand_functions() {
    let mut text = String::from("float f0(float x) { return x; }\n");
    for i in 1..10_000 {
        let _ = writeln!(text, "float f{i}(float x) {{ return f{}(x) + 1; }}", i - 1);
    }
    text.push_str("shader s(output float f = 0) { f = f9999(u); }");
    codes(&text);
}

#[test]
fn twenty_thousand_branches_and_variables() {
    let mut text = String::new();
    for i in 0..20_000 {
        let _ = writeln!(text, "float x{i} = u * {i}; if (x{i} > 0.5) f += x{i}; else f -= 1;");
    }
    assert_eq!(codes(&in_body(&text)), [""; 0]);
}

#[test]
fn a_table_of_64k_elements_in_linear_time() {
    let table = |n: usize| {
        let numbers: Vec<String> = (0..n).map(|i| format!("{}.5", i % 97)).collect();
        format!(
            "shader s(int k = 3 [[ int lockgeom = 0 ]], output float f = 0) {{ float t[{n}] = {{ {} }}; f = t[(int)(u * {n})]; }}",
            numbers.join(", ")
        )
    };
    let time = |n: usize| {
        let source = table(n);
        let start = Instant::now();
        let output = grid(&source).unwrap_or_else(|e| panic!("{e}"));
        assert!(output.artifact.code.contains("__constant real"));
        start.elapsed()
    };
    time(1 << 10);
    let (small, large) = (time(1 << 13), time(1 << 16));
    assert!(large < 40 * small + Duration::from_millis(500), "8 times the table: {small:?} became {large:?}");
    // A table that no device can hold is refused or written, but not built here.
    codes("shader s(output float f = 0) { float t[2000000000]; t[1] = u; f = t[(int)u]; }");
}

#[test]
fn many_closures() {
    assert!(codes(&format!("surface s(output float f = 0) {{ {} }}", "Ci += u * diffuse(N);".repeat(500))).is_empty());
    let far = format!("surface s(output float f = 0) {{ {} }}", "Ci += u * diffuse(N);".repeat(20_000));
    assert_eq!(codes(&far), ["E4005"]);
    let nested = "surface s(output float f = 0) { for (int i = 0; i < 200; i++) for (int j = 0; j < 200; j++) \
                  for (int k = 0; k < 200; k++) Ci += phong(N, i + j + k); }";
    let found = codes(nested);
    assert!(found.iter().all(|c| ["E4003", "E4005"].contains(c)) && !found.is_empty(), "{found:?}");
}

#[test]
fn macro_bombs() {
    let mut text = String::from("#define A0 u +\n");
    for i in 1..64 {
        let _ = writeln!(text, "#define A{i} A{} A{}", i - 1, i - 1);
    }
    let bomb = format!("{text}{}", in_body("f = A63 1;"));
    assert!(codes(&bomb).contains(&"E0007"));
    // Empty expansions, and growth through arguments.
    let mut text = String::from("#define A0\n");
    for i in 1..64 {
        let _ = writeln!(text, "#define A{i} A{} A{}", i - 1, i - 1);
    }
    assert!(codes(&format!("{text}{}", in_body("A63 f = 1;"))).contains(&"E0007"));
    let call = format!("{}u +{}", "D(".repeat(60), ")".repeat(60));
    let found = codes(&format!("#define D(x) x x\n{}", in_body(&format!("f = {call} 1;"))));
    assert!(found.contains(&"E0007"), "{found:?}");
    // In a condition.
    assert!(codes(&format!("{text}#if A63 1\n#endif\n{}", in_body("f = 1;"))).contains(&"E0007"));
    // Calls inside of calls.
    let deep = format!("f = {}u{};", "I(".repeat(50_000), ")".repeat(50_000));
    assert!(codes(&format!("#define I(x) x\n{}", in_body(&deep))).contains(&"E0007"));
    // Many lines with a large one each.
    let lines = "f = A20 1;\n".repeat(1000);
    codes(&format!("{}{}", text.replacen("#define A0\n", "#define A0 u +\n", 1), in_body(&lines)));
}

struct Endless;

impl Includes for Endless {
    fn read(&self, path: &str, _from: Option<&str>, _system: bool) -> Option<(String, Arc<str>)> {
        let n: usize = path.strip_prefix('n')?.parse().ok()?;
        let text = match n % 2 {
            0 => format!("#include \"n{}\"\n#include \"n{}\"\n", n + 1, n + 1),
            _ => format!("#include <n{}>\n", n + 1),
        };
        Some((path.to_owned(), text.into()))
    }
}

#[test]
fn includes_without_end() {
    let start = Instant::now();
    let failure = compile("#include \"n0\"\nsurface s() {}", &Options::default(), &Endless).expect_err("no end");
    assert_eq!(failure.diagnostics[0].code, "E0002", "{failure}");
    assert!(start.elapsed() < PATIENCE);
}

#[test]
fn bytes_that_are_no_shader() {
    let inputs = [
        "",
        " ",
        "\n",
        "\0",
        "\u{feff}",
        "surface s() {\0}",
        "surface s() { string a = \"\0\"; }",
        "/*",
        "//",
        "//\\",
        "\"",
        "\"\\",
        "'",
        "'a",
        "'\\''",
        "'ä'",
        "#",
        "#define",
        "#define A(",
        "#define A(x) #x\nA(",
        "#define A(x) ##x\nsurface s() { A(1); }",
        "#define A ##\nsurface s() { A; }",
        "#include",
        "#include \"",
        "#include <",
        "#if",
        "#line 4294967296 \"x\"",
        "\\",
        "surface",
        "surface s",
        "surface s(",
        "surface s()",
        "surface s() {",
        "surface s() { 0x; }",
        "surface s() { 1e; }",
        "surface s() { 1e999 + 0x1FFFFFFFF; }",
        "surface s() { \"\\400\\777\"; }",
        "surface s() { f(; }",
        "surface s() { Ci = é; }",
        "// é\nsurface s() { é }",
        "\u{1F600}",
        "surface s() { x = \"\u{1F600}\"; }\r\n",
    ];
    for input in inputs {
        codes(input);
    }
}

#[test]
fn random_bytes() {
    // A fixed linear congruential generator: the same bytes on each machine.
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize
    };
    let pieces = [
        "surface ", "s", "(", ")", "{", "}", "[", "]", "[[", "]]", ";", ",", "=", "+", "-", "*", "/", "?", ":",
        "float ", "color ", "\"", "1", "0x", ".5", "#", "\n", "define ", "A", "##", "if ", "else ", "for ", "\\", "Ci",
        "diffuse", "N", "struct ", "output ", "return ", "\u{e9}", "'", "//", "/*", "*/", "&&", "!", "~", "<<",
        "void ", "closure ", "e9",
    ];
    for round in 0..2_000 {
        let len = next() % 60;
        let text: String = if round % 2 == 0 {
            (0..len).map(|_| pieces[next() % pieces.len()]).collect()
        } else {
            let bytes: Vec<u8> = (0..len).map(|_| next() as u8).collect();
            String::from_utf8_lossy(&bytes).into_owned()
        };
        let _ = grid(&text).map_err(|e| e.to_string());
    }
    let bytes: Vec<u8> = (0..1_000_000).map(|_| next() as u8).collect();
    codes(&String::from_utf8_lossy(&bytes));
}
