//! How fast OSL becomes OpenCL C: small shaders one after the other, a table of 64k elements, the largest shader at hand.
//!
//! Marks: 1,000 small shaders per second on one core; the table in time linear in its length; 50 ms for the largest shader that
//! MaterialX 1.39 generates from its examples. `OSLCL_BENCH_SHADER=FILE` adds a shader of yours, with its folder, and the one
//! in `OSLCL_BENCH_INCLUDE`, for its headers.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use oslcl_compiler::{Entry, Includes, Master, NoIncludes, Options, batch};
use std::fmt::Write;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// From source to OpenCL C, as `oslcl compile` does it.
fn compile(source: &str, entry: &Entry, includes: &(dyn Includes + Sync)) -> usize {
    let options = Options { entry: entry.clone(), ..Options::default() };
    let master = Master::new(source, &options, includes).unwrap_or_else(|e| panic!("{e}"));
    master.instance(&options).unwrap_or_else(|e| panic!("{e}")).artifact.code.len()
}

fn shipped() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders-osl");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the shipped materials")
        .flatten()
        .map(|e| e.path())
        .filter(|p| p.extension().is_some_and(|e| e == "osl"))
        .collect();
    paths.sort();
    paths.iter().map(|p| std::fs::read_to_string(p).expect("a material")).collect()
}

/// A shader that looks a value up in a table of `n` elements.
fn table(n: usize) -> String {
    let mut text = format!("shader s(output float f = 0) {{\n float t[{n}] = {{ 0");
    for i in 1..n {
        let _ = write!(text, ", {}.5", i % 97);
    }
    text += " };\n f = t[(int)(u * 1000)]; }\n";
    text
}

/// A shader of many functions and parameters, as programs generate them.
fn generated(n: usize) -> String {
    let mut text = String::new();
    for i in 0..n {
        let _ = writeln!(
            text,
            "void node_{i}(color a, float b, output color r)\n{{\n    color c = a * b + color({i}, 0.5, 0.25);\n    \
             float k = clamp(dot(vector(c), vector(1, 2, 3)), 0.0, 1.0);\n    r = mix(c, a, k);\n}}"
        );
    }
    text += "shader s(\n";
    for i in 0..n {
        let _ = writeln!(text, "    float p{i} = {i}.25 [[ string label = \"Parameter {i}\", float min = 0 ]],");
    }
    text += "    output color f = 0)\n{\n    color x = color(u, v, 0);\n";
    for i in 0..n {
        let _ = writeln!(text, "    node_{i}(x, p{i}, x);");
    }
    text + "    f = x;\n}\n"
}

/// Headers beside a file and in one more folder.
struct Folders(Vec<PathBuf>);

impl Includes for Folders {
    fn read(&self, path: &str, _from: Option<&str>, _system: bool) -> Option<(String, Arc<str>)> {
        self.0.iter().map(|f| f.join(path)).find_map(|p| {
            let text = std::fs::read_to_string(&p).ok()?;
            Some((p.display().to_string(), text.into()))
        })
    }
}

fn benches(c: &mut Criterion) {
    let small = shipped();
    let mut group = c.benchmark_group("front_end");
    group.sample_size(20);
    group.throughput(Throughput::Elements(small.len() as u64));
    group.bench_function("small_shaders", |b| {
        b.iter(|| small.iter().map(|s| compile(black_box(s), &Entry::Material, &NoIncludes)).sum::<usize>());
    });
    group.bench_function("small_shaders_in_a_batch", |b| {
        let all = || small.iter().map(|s| compile(black_box(s), &Entry::Material, &NoIncludes)).sum::<usize>();
        // Many at a time, so that the one thread of the batch does not count.
        b.iter_custom(|n| {
            let start = std::time::Instant::now();
            batch(|| (0..n).for_each(|_| _ = black_box(all()))).unwrap_or_else(|e| panic!("{e}"));
            start.elapsed()
        });
    });
    let grid = Entry::Grid(vec!["f".into()]);
    group.sample_size(10);
    for n in [4096, 65_536] {
        let text = table(n);
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(format!("table_{n}"), |b| b.iter(|| compile(black_box(&text), &grid, &NoIncludes)));
    }
    let text = generated(100);
    group.throughput(Throughput::Bytes(text.len() as u64));
    group.bench_function("generated_100_nodes", |b| b.iter(|| compile(black_box(&text), &grid, &NoIncludes)));
    if let Some(path) = std::env::var_os("OSLCL_BENCH_SHADER").map(PathBuf::from) {
        let text = std::fs::read_to_string(&path).expect("the shader of OSLCL_BENCH_SHADER");
        let beside = path.parent().map(Path::to_owned);
        let more = std::env::var_os("OSLCL_BENCH_INCLUDE").map(PathBuf::from);
        let folders = Folders(beside.into_iter().chain(more).collect());
        group.throughput(Throughput::Bytes(text.len() as u64));
        group.bench_function("given_shader", |b| b.iter(|| compile(black_box(&text), &Entry::Material, &folders)));
    }
    group.finish();
}

criterion_group!(front_end, benches);
criterion_main!(front_end);
