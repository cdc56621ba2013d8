//! Properties over the corpus and over generated shaders: the IR's text reads back as itself, and damaged sources never
//! crash the compiler.

mod common;

use common::{corpus, lowered, name, optimised, shaders, text};
use oslcl_compiler::ir::{self, Shader};
use oslcl_compiler::{Entry, NoIncludes, Options, compile};
use proptest::prelude::*;
use proptest::sample::Index;
use std::sync::LazyLock;

/// Names and texts of the corpus.
static CORPUS: LazyLock<Vec<(String, String)>> =
    LazyLock::new(|| shaders(&corpus()).iter().map(|p| (name(p), text(p))).collect());

/// Print, read, print gives the same text, and what was read is sound.
fn reads_back(what: &str, shader: &Shader) {
    let printed = ir::print(shader);
    let read = ir::read(&printed).unwrap_or_else(|e| panic!("{what}: {e}\n{printed}"));
    if let Err(e) = ir::verify(&read) {
        panic!("{what}: {e}\n{printed}");
    }
    assert_eq!(ir::print(&read), printed, "{what}");
}

#[test]
fn the_ir_of_the_corpus_is_sound_and_reads_back() {
    for (name, text) in CORPUS.iter() {
        for (stage, shader) in [("lowered", lowered(name, text)), ("optimised", optimised(name, text))] {
            let shader = shader.unwrap_or_else(|d| panic!("{name}: {d:?}"));
            ir::verify(&shader).unwrap_or_else(|e| panic!("{name} {stage}: {e}"));
            reads_back(&format!("{name} {stage}"), &shader);
        }
    }
}

/// Cuts a text into words, numbers, blanks and single characters.
fn tokens(text: &str) -> Vec<&str> {
    let mut out = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let class = |c: char| match c {
            c if c.is_ascii_alphanumeric() || c == '_' || c == '.' => 0,
            c if c.is_whitespace() => 1,
            _ => 2,
        };
        let len = match class(first) {
            2 => first.len_utf8(),
            kind => rest.find(|c| class(c) != kind).unwrap_or(rest.len()),
        };
        let (token, tail) = rest.split_at(len);
        out.push(token);
        rest = tail;
    }
    out
}

/// A damage: where, where else, and which kind.
type Damage = (Index, Index, u8);

fn damaged(text: &str, damages: &[Damage]) -> String {
    let mut list = tokens(text);
    for (at, other, kind) in damages {
        if list.is_empty() {
            break;
        }
        let (i, j) = (at.index(list.len()), other.index(list.len()));
        match kind {
            0 => {
                list.remove(i);
            }
            1 => list.insert(i, list[j]),
            2 => list.swap(i, j),
            _ => list.truncate(i.max(j)),
        }
    }
    list.concat()
}

/// A float expression as source text.
fn expression() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("u".to_string()),
        Just("v".to_string()),
        Just("P[1]".to_string()),
        Just("k".to_string()),
        Just("a".to_string()),
        (-9i32..10).prop_map(|n| n.to_string()),
        (-4.0f64..4.0).prop_map(|x| format!("{x:.3}")),
    ];
    leaf.prop_recursive(5, 48, 4, |inner| {
        let pair = (inner.clone(), inner.clone());
        prop_oneof![
            (pair.clone(), prop::sample::select(vec!["+", "-", "*", "/"]))
                .prop_map(|((a, b), op)| format!("({a} {op} {b})")),
            (pair.clone(), prop::sample::select(vec!["<", "<=", "==", "!=", "&&", "||"]))
                .prop_map(|((a, b), op)| format!("({a} {op} {b})")),
            (inner.clone(), prop::sample::select(vec!["-", "!", "+", "(int)", "(float)"]))
                .prop_map(|(a, op)| format!("({op}({a}))")),
            (
                inner.clone(),
                prop::sample::select(vec!["sin", "sqrt", "abs", "floor", "noise", "cellnoise", "(float)hash"])
            )
                .prop_map(|(a, f)| format!("{f}((float)({a}))")),
            (pair.clone(), prop::sample::select(vec!["min", "max", "pow", "fmod", "atan2", "hypot"]))
                .prop_map(|((a, b), f)| format!("{f}((float){a}, (float){b})")),
            (inner.clone(), pair.clone()).prop_map(|(c, (a, b))| format!("(({c}) ? (float)({a}) : (float)({b}))")),
            (pair.clone(), inner.clone()).prop_map(|((a, b), c)| format!("dot(vector({a}, {b}, {c}), N)")),
            (inner.clone(), 0..3).prop_map(|(a, i)| format!("color({a}, 2, v)[{i}]")),
            inner.clone().prop_map(|a| format!("t[(int)({a})]")),
            inner.prop_map(|a| format!("(a = {a})")),
        ]
    })
}

/// A statement as source text.
fn statement() -> impl Strategy<Value = String> {
    let simple = prop_oneof![
        expression().prop_map(|e| format!("f += {e};")),
        expression().prop_map(|e| format!("a = {e};")),
        (expression(), expression()).prop_map(|(i, e)| format!("t[(int)({i})] = {e};")),
        expression().prop_map(|e| format!("Ci += ({e}) * diffuse(N);")),
        expression().prop_map(|e| format!("{{ float a = {e}; f -= a; }}")),
    ];
    simple.prop_recursive(3, 12, 3, |inner| {
        let body = prop::collection::vec(inner, 1..4).prop_map(|s| s.join(" "));
        prop_oneof![
            (expression(), body.clone(), body.clone())
                .prop_map(|(c, a, b)| format!("if ({c}) {{ {a} }} else {{ {b} }}")),
            (1..4, body.clone()).prop_map(|(n, b)| format!("for (int i = 0; i < {n}; i++) {{ {b} }}")),
            (expression(), 2..5, body.clone())
                .prop_map(|(c, n, b)| format!("for (int i = 0; i < {n}; i++) {{ if ({c}) break; f += i; }} {{ {b} }}")),
            (expression(), body).prop_map(|(c, b)| format!(
                "{{ int i = 0; do {{ i++; if ({c}) continue; f *= 0.5; }} while (i < 3); {b} }}"
            )),
        ]
    })
}

fn shader() -> impl Strategy<Value = String> {
    prop::collection::vec(statement(), 1..8).prop_map(|statements| {
        format!(
            "surface s(float k = 0.5, output float f = 0)\n{{\n    float a = u, t[3] = {{ 1, 2, v }};\n    {}\n}}\n",
            statements.join("\n    ")
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_sources_never_panic(
        which in any::<Index>(),
        damages in prop::collection::vec((any::<Index>(), any::<Index>(), 0u8..4), 1..6),
    ) {
        let (name, text) = which.get(&CORPUS);
        let source = damaged(text, &damages);
        for entry in [Entry::Material, Entry::Grid(vec!["f".into(), "Ci".into()])] {
            let options =
                Options { file_name: name.clone(), entry, line_directives: true, spirv: true, ..Options::default() };
            if let Err(failure) = compile(&source, &options, &NoIncludes) {
                prop_assert!(!failure.diagnostics.is_empty());
                prop_assert!(!failure.to_string().contains("internal error"), "{failure}\n{source}");
            }
        }
    }

    #[test]
    fn generated_shaders_compile_and_their_ir_reads_back(source in shader()) {
        let low = lowered("generated.osl", &source);
        prop_assert!(low.is_ok(), "{:?}\n{source}", low.err());
        let optimised = optimised("generated.osl", &source);
        prop_assert!(optimised.is_ok(), "{:?}\n{source}", optimised.err());
        let written = compile(&source, &Options { spirv: true, ..Options::default() }, &NoIncludes);
        prop_assert!(written.is_ok(), "{:?}\n{source}", written.err());
        for shader in low.into_iter().chain(optimised) {
            prop_assert!(ir::verify(&shader).is_ok(), "{:?}\n{source}", ir::verify(&shader));
            reads_back(&source, &shader);
        }
    }
}
