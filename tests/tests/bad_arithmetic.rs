//! The table of bad arithmetic (tests/bad-arithmetic.txt): device in both precisions, and interpreter, against it.

use oslcl_compiler::Options;
use oslcl_compiler::interp::Globals;
use oslcl_runtime::device::Device;
use oslcl_tests::grid::{self, Case, Precision};

const TABLE: &str = include_str!("../bad-arithmetic.txt");

/// An expression at some points and what it gives there.
struct Row {
    expression: String,
    /// Per point, in words: one or several results.
    expected: Vec<Vec<String>>,
}

/// Expressions over the same points.
struct Section {
    title: String,
    points: Vec<Globals>,
    rows: Vec<Row>,
}

fn number(word: &str) -> f64 {
    match word {
        "nan" => f64::NAN,
        "inf" => f64::INFINITY,
        "-inf" => f64::NEG_INFINITY,
        // All arguments are 32-bit floats.
        other => other.parse().unwrap_or_else(|_| panic!("`{other}` is a number")),
    }
}

fn narrow(word: &str) -> f64 {
    f64::from(number(word) as f32)
}

/// The point where the names of the lists have their values.
fn named() -> Globals {
    let wide = |x: f32| f64::from(x);
    Globals { p: [f64::INFINITY, f64::NAN, -0.0], i: [wide(1e-40), wide(f32::MAX), 0.0], ..Globals::default() }
}

const NAMES: &str = "    float INF = P[0], NAN = P[1], NZ = P[2], DEN = I[0], MAX = I[1], z = I[2];\n    int iz = (int)z;\n    \
                     int INT_MIN = -2147483647 + iz - 1;\n    vector V = vector(1.0 + z, 2.0 + z, 3.0 + z);\n    matrix M = matrix(7.0 + z);\n";

/// An expression whose numbers only the device knows.
fn opaque(expression: &str) -> String {
    let mut out = String::new();
    let mut rest = expression;
    while let Some(c) = rest.chars().next() {
        let word = |f: fn(char) -> bool| rest.find(|c| !f(c)).unwrap_or(rest.len());
        let len = if c == '"' {
            rest[1..].find('"').map_or(rest.len(), |i| i + 2)
        } else if c.is_ascii_alphabetic() {
            word(|c| c.is_ascii_alphanumeric() || c == '_')
        } else if c.is_ascii_digit() {
            let mut len = word(|c| c.is_ascii_digit() || c == '.' || c == 'e');
            if rest[..len].ends_with('e') {
                len += 1 + rest[len + 1..].find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len() - len - 1);
            }
            let literal = &rest[..len];
            let zero = if literal.contains(['.', 'e']) { "z" } else { "iz" };
            out.push_str(&format!("({literal} + {zero})"));
            rest = &rest[len..];
            continue;
        } else {
            c.len_utf8()
        };
        out.push_str(&rest[..len]);
        rest = &rest[len..];
    }
    out
}

fn cells(line: &str) -> Vec<&str> {
    line.split('|').map(str::trim).collect()
}

/// The table's sections; the file's head says how it is written.
fn sections() -> Vec<Section> {
    let mut out: Vec<Section> = Vec::new();
    let mut lines = TABLE.lines().filter(|l| !l.starts_with('#') && !l.trim().is_empty()).peekable();
    while let Some(title) = lines.next() {
        let title = title.strip_prefix("== ").unwrap_or_else(|| panic!("`{title}` opens a section")).to_owned();
        let mut section = Section { title, points: Vec::new(), rows: Vec::new() };
        let head = cells(lines.peek().copied().unwrap_or_default());
        let at = |u: f64, v: f64| Globals { u, v, ..named() };
        let mut body = || lines.next_if(|l| !l.starts_with("== "));
        if head[0] == "x" {
            body();
            section.points = head[1..].iter().map(|x| at(narrow(x), 0.0)).collect();
            while let Some(line) = body() {
                let row = cells(line);
                assert_eq!(row.len(), head.len(), "{line}");
                let expected = row[1..].iter().map(|c| vec![(*c).to_owned()]).collect();
                section.rows.push(Row { expression: row[0].to_owned(), expected });
            }
        } else if head[0] == "x \\ y" {
            body();
            let expression = section.title.split(": ").next().unwrap_or_default().to_owned();
            let mut expected = Vec::new();
            while let Some(line) = body() {
                let row = cells(line);
                assert_eq!(row.len(), head.len(), "{line}");
                for (y, cell) in head[1..].iter().zip(&row[1..]) {
                    section.points.push(at(narrow(row[0]), narrow(y)));
                    expected.push(vec![(*cell).to_owned()]);
                }
            }
            section.rows.push(Row { expression, expected });
        } else {
            section.points = vec![named()];
            while let Some(line) = body() {
                let (expression, results) = line.rsplit_once(" = ").unwrap_or_else(|| panic!("`{line}` has a result"));
                let expected = vec![results.split_whitespace().map(str::to_owned).collect()];
                section.rows.push(Row { expression: opaque(expression), expected });
            }
        }
        out.push(section);
    }
    out
}

/// The shader of a section: an output per row.
fn case(index: usize, section: &Section) -> Case {
    let (mut params, mut body) = (Vec::new(), String::new());
    for (k, row) in section.rows.iter().enumerate() {
        let ty = match row.expected[0].len() {
            1 if section.title.starts_with("int:") => "int",
            1 => "float",
            3 => "vector",
            16 => "matrix",
            n => panic!("{}: {n} results", row.expression),
        };
        let cast = if ty == "vector" { "(vector)" } else { "" };
        params.push(format!("output {ty} o{k} = 0"));
        body.push_str(&format!("    o{k} = {cast}({});\n", row.expression));
    }
    let source = format!("shader t{index}({})\n{{\n{NAMES}    float x = u, y = v;\n{body}}}\n", params.join(",\n    "));
    Case::new(&format!("t{index}"), &source, Options::default()).unwrap_or_else(|e| panic!("{e}\n{source}"))
}

/// What a cell says that we give, by precision.
fn expected(cell: &str, double: bool) -> f64 {
    let ours = cell.split('~').next().unwrap_or_default();
    let (single, wide) = ours.split_once(';').unwrap_or((ours, ours));
    number(if double { wide } else { single })
}

fn same(found: f64, wanted: f64) -> bool {
    if wanted.is_nan() {
        return found.is_nan();
    }
    found == wanted || (found - wanted).abs() <= 2e-5 * wanted.abs().min(1e300)
}

fn check(what: &str, section: &Section, double: bool, values: &[Vec<f64>], wrong: &mut Vec<String>) {
    for (p, record) in values.iter().enumerate() {
        let mut at = 0;
        for row in &section.rows {
            for cell in &row.expected[p] {
                let (found, wanted) = (record[at], expected(cell, double));
                at += 1;
                if !same(found, wanted) {
                    let g = &section.points[p];
                    let x = if section.points.len() > 1 { format!(" at x {} y {}", g.u, g.v) } else { String::new() };
                    wrong.push(format!("{}{x}: the table says {cell}, {what} {found}", row.expression));
                }
            }
        }
        assert_eq!(at, record.len());
    }
}

#[test]
fn the_table_holds() {
    let sections = sections();
    assert!(sections.len() > 20, "the table is read whole");
    let device = Device::open(None).expect("a device");
    let cases: Vec<Case> = sections.iter().enumerate().map(|(i, s)| case(i, s)).collect();
    let mut wrong = Vec::new();
    for (section, case) in sections.iter().zip(&cases) {
        let values = case.master.evaluate_all(&case.options, &case.outputs, &section.points);
        let values = values.unwrap_or_else(|e| panic!("{}: the interpreter: {e}", section.title));
        let flat: Vec<Vec<f64>> = values.iter().map(|p| p.iter().flat_map(|(_, r)| r.clone()).collect()).collect();
        check("the interpreter", section, true, &flat, &mut wrong);
    }
    let mut precisions = vec![Precision::Single];
    if device.info.double {
        precisions.push(Precision::Double);
    }
    for precision in precisions {
        // All sections at all points in one program: building costs more than running.
        let points: Vec<Globals> = sections.iter().flat_map(|s| s.points.clone()).collect();
        let values = grid::run(&device, precision, &cases, &points).unwrap_or_else(|e| panic!("{e}"));
        let (mut first, mut column) = (0, 0);
        for section in &sections {
            let width: usize = section.rows.iter().map(|r| r.expected[0].len()).sum();
            let rows = &values[first..first + section.points.len()];
            let mine: Vec<Vec<f64>> = rows.iter().map(|r| r[column..column + width].to_vec()).collect();
            let double = precision == Precision::Double;
            let what = if double { "the device in f64" } else { "the device in f32" };
            check(what, section, double, &mine, &mut wrong);
            first += section.points.len();
            column += width;
        }
    }
    assert!(wrong.is_empty(), "{} results differ:\n{}", wrong.len(), wrong.join("\n"));
}
