//! Point clouds: searches and reads on the device against those on the host and against looking at every point; in renders; and
//! what is said of files that are missing.

use glam::DAffine3;
use oslcl_compiler::{Master, NoIncludes, Options};
use oslcl_runtime::device::Device;
use oslcl_runtime::points::{Data, read, write};
use oslcl_runtime::precision::Precision::{self, Fast, Reference, Standard};
use oslcl_runtime::render as renderer;
use oslcl_runtime::scene::Scene;
use oslcl_runtime::shade::{self, Grid, Shaded};
use oslcl_runtime::textures::{Library, Settings};
use oslcl_tests::scenes::{empty, material, mesh, place, render, wall};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

/// Points of the test's cloud, on z = 1 around the patch of `shade`; their coordinates are exact.
fn points() -> Vec<[f32; 3]> {
    let number = |i: u32, k: u32| ((i * 7919 + k * 104_729) % 1024) as f32 / 512.0 - 0.5;
    (0..300).map(|i| [number(i, 1), number(i, 2), 1.0]).collect()
}

/// The folder with the clouds.
fn folder() -> PathBuf {
    static WRITTEN: OnceLock<PathBuf> = OnceLock::new();
    let folder = WRITTEN.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("points");
        std::fs::create_dir_all(&folder).expect("a folder for clouds");
        let all = points();
        let mut geo = format!(
            "PGEOMETRY V5\nNPoints {} NPrims 0\nNPointGroups 0 NPrimGroups 0\nNPointAttrib 4 NVertexAttrib 0 NPrimAttrib 0 \
             NAttrib 0\nPointAttrib\nCd 3 vector 0 0 0\nid 1 int 0\npair 2 float 0 0\nkind 1 index 2 \"even one\" odd\n",
            all.len()
        );
        let mut pda = format!("ATTRIBUTES\n position mass\nTYPES\n V R\nNUMBER_OF_PARTICLES: {}\nBEGIN DATA\n", all.len());
        for (i, [x, y, z]) in all.iter().enumerate() {
            let _ = writeln!(geo, "{x} {y} {z} 1 ({x} {y} 0.5\t{}\t{x} {i} {})", 1000 + i, i % 2);
            let _ = writeln!(pda, "{x} {y} {z} {i}");
        }
        std::fs::write(folder.join("cloud.geo"), geo).expect("written");
        std::fs::write(folder.join("cloud.pda"), pda).expect("written");
        std::fs::write(folder.join("damaged.geo"), "PGEOMETRY V5\nNPoints 3 NPrims x\n").expect("written");
        folder
    });
    folder.clone()
}

struct Case {
    master: Master,
    options: Options,
    outputs: Vec<String>,
    library: Arc<Library>,
}

const SIDE: u32 = 16;

fn grid() -> Grid {
    Grid { center: true, ..Grid::new(SIDE, SIDE) }
}

impl Case {
    fn new(source: &str) -> Case {
        let library = Arc::new(Library::new(Settings { search: vec![folder()], automip: true }));
        let options = Options { textures: Some(library.access()), spirv: true, ..Options::default() };
        let master = Master::new(source, &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
        let outputs = shade::default_outputs(master.info());
        Case { master, options, outputs, library }
    }

    fn device(&self, precision: Precision) -> Shaded {
        // PoCL finds no device while another thread asks for one.
        static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
        let _one = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
        let device = Device::open(None).expect("a device");
        let artifact = shade::compile(&self.master, &self.options, &self.outputs).unwrap_or_else(|e| panic!("{e}"));
        shade::run_with(&device, &artifact, grid(), precision, &self.library).unwrap_or_else(|e| panic!("{e}"))
    }

    /// The device's outputs are the host's.
    fn compare(&self, precision: Precision) -> Shaded {
        let shaded = self.device(precision);
        let points: Vec<_> = (0..SIDE * SIDE).map(|i| grid().globals(i % SIDE, i / SIDE)).collect();
        let host = self.master.evaluate_all(&self.options, &self.outputs, &points).unwrap_or_else(|e| panic!("{e}"));
        for (k, plane) in shaded.planes.iter().enumerate() {
            let n = plane.channels as usize;
            for (i, values) in host.iter().enumerate() {
                for (device, host) in plane.data[n * i..].iter().zip(&values[k].1) {
                    let tolerance = 1e-5 * host.abs().max(1.0);
                    assert!((device - host).abs() <= tolerance, "{} of point {i}: {device}, {host}", plane.name);
                }
            }
        }
        shaded
    }
}

const SEARCH: &str = "shader s(string file = \"cloud.geo\", float radius = 0.125, int most = 6,
    output int n = 0, output int count = 0, output int index[8] = {-1, -1, -1, -1, -1, -1, -1, -1}, output float far[7] = {0, 0, 0, 0, 0, 0, 0},
    output float ids = 0, output vector sum = 0, output float odd = 0, output float pairs[8] = {-2, -2, -2, -2, -2, -2, -2, -2}, output int ok = 0)
{
    color cd[8];
    point at[10];
    int id[9];
    string kind[8];
    n = pointcloud_search(file, P, radius, most, \"index\", index, \"distance\", far, \"Cd\", cd, \"position\", at, \"id\", id);
    count = pointcloud_search(file, P, radius, 1000000);
    ok = pointcloud_get(file, index, n, \"kind\", kind) + 2 * pointcloud_get(file, index, n, \"pair\", pairs);
    for (int i = 0; i < n; i++) {
        ids += id[i];
        sum += (vector)cd[i] * (i + 1) + distance(at[i], P);
        odd += kind[i] == \"odd\";
    }
}";

#[test]
fn searches_on_the_device_are_the_hosts() {
    for precision in [Fast, Standard, Reference] {
        Case::new(SEARCH).compare(precision);
    }
}

#[test]
fn searches_find_the_nearest_of_all_points() {
    let shaded = Case::new(SEARCH).compare(Standard);
    let plane = |name: &str| shaded.planes.iter().find(|p| p.name == name).expect("an output");
    let all = points();
    let mut most = 0;
    for i in 0..(SIDE * SIDE) as usize {
        let at = grid().globals(i as u32 % SIDE, i as u32 / SIDE).p;
        let far = |p: &[f32; 3]| (0..3).map(|c| (f64::from(p[c]) - at[c]).powi(2)).sum::<f64>().sqrt();
        let mut near: Vec<(f64, usize)> = all.iter().map(far).zip(0..).filter(|(d, _)| *d <= 0.125).collect();
        near.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        assert_eq!(plane("count").data[i] as usize, near.len());
        let n = plane("n").data[i] as usize;
        assert_eq!(n, near.len().min(6));
        most = most.max(near.len());
        for (k, (d, index)) in near.iter().take(n).enumerate() {
            assert!((plane("far").data[7 * i + k] - d).abs() < 1e-6);
            assert_eq!(plane("index").data[8 * i + k] as usize, *index);
        }
        // What is not found is not written; of pairs only whole ones are.
        assert!(plane("index").data[8 * i + n..8 * (i + 1)].iter().all(|x| *x == -1.0));
        let wanted = near.iter().take(n.min(4)).map(|(_, index)| *index as f64);
        assert!(wanted.zip(0..).all(|(index, k)| plane("pairs").data[8 * i + 2 * k + 1] == index));
        assert_eq!(plane("ok").data[i], 3.0);
    }
    assert!(most > 6, "no place has more points than are asked for");
}

#[test]
fn the_other_format_and_chosen_files_work_too() {
    let source = "shader s(output float m = 0, output int ok = 0, output int one = 0) {
        string file = u > 0.5 ? \"cloud.pda\" : \"cloud.geo\";
        int i[4]; float mass[4] = {0, 0, 0, 0};
        int n = pointcloud_search(file, P, 10, 4, 1, \"index\", i);
        ok = pointcloud_get(file, i, n, \"mass\", mass);
        m = mass[0] + mass[3];
        // A variable is an array of one.
        pointcloud_search(file, P, 10, 9, \"index\", one);
    }";
    let shaded = Case::new(source).compare(Standard);
    let ok = &shaded.planes[1].data;
    assert!(ok.contains(&0.0) && ok.contains(&1.0), "only one file has the attribute");
}

#[test]
fn what_is_not_there_is_not_found() {
    let source = "shader s(output int n = 0, output int ok = 0) {
        int i[3] = {0, 300, -1}; float f[3] = {5, 5, 5}; int k[3];
        n = pointcloud_search(\"cloud.geo\", P, -1, 3, \"index\", k) + pointcloud_search(\"cloud.geo\", P, 0 / u - 1, 3)
            + pointcloud_search(\"cloud.geo\", P, 1, 0, \"index\", k) + pointcloud_search(\"cloud.geo\", P + 1e9, 1, 3)
            + pointcloud_search(\"cloud.geo\", P, 1, -7, \"index\", k) + pointcloud_search(\"\", P, 10, 3);
        ok = pointcloud_get(\"cloud.geo\", i, 1, \"Cd\", f) + pointcloud_get(\"cloud.geo\", i, 1, \"none\", f)
            + pointcloud_get(\"cloud.geo\", i, 2, \"id\", k) + 10 * pointcloud_get(\"cloud.geo\", i, 0, \"none\", f)
            + 100 * pointcloud_get(\"cloud.geo\", i, 1, \"id\", k) + 1000 * (f[0] == 5) + 10000 * (k[0] == 1000);
    }";
    let shaded = Case::new(source).compare(Standard);
    assert!(shaded.planes[0].data.iter().all(|n| *n == 0.0));
    assert!(shaded.planes[1].data.iter().all(|n| *n == 11110.0), "{:?}", shaded.planes[1].data[0]);
}

#[test]
fn missing_and_damaged_files_are_empty_and_told() {
    for (file, cause) in
        [("none.geo", "there is no such file"), ("damaged.geo", "line 2: the number of NPrims"), ("x.ptc", "")]
    {
        let source = format!("shader s(output int n = 0) {{ n = pointcloud_search(\"{file}\", P, 10, 3); }}");
        let shaded = Case::new(&source).compare(Standard);
        assert!(shaded.planes[0].data.iter().all(|n| *n == 0.0));
        let told = shaded.warnings.concat();
        assert!(told.contains(&format!("point cloud `{file}` of shader `s` counts as empty")), "{told}");
        assert!(told.contains(cause), "{told}");
    }
    let source = "shader s(output int n = 0) { int i[1] = {0}; string k[1];
        pointcloud_get(\"cloud.geo\", i, 1, \"kind\", k); n = pointcloud_search(k[0], P, 10, 3); }";
    let case = Case::new(source);
    let refused = shade::compile(&case.master, &case.options, &case.outputs).expect_err("refused").to_string();
    assert!(refused.contains("not known at compile time"), "{refused}");
}

#[test]
fn strings_of_points_can_be_printed() {
    let source = "shader s(output int n = 0) { int i[1] = {4}; string k[1];
        if (u + v < 0.1) { n = pointcloud_get(\"cloud.geo\", i, 1, \"kind\", k); printf(\"%s;\", k[0]); } }";
    let shaded = Case::new(source).device(Standard);
    let said: Vec<&str> = shaded.messages.iter().map(|m| m.text.as_str()).collect();
    assert_eq!(said, ["even one;"]);
}

fn wall_of(source: &str) -> Scene {
    let mut scene = empty();
    scene.integrator.samples = 4;
    scene.textures = vec![folder()];
    let m = material(&mut scene, source, &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    scene
}

#[test]
fn renders_and_displacements_look_into_clouds() {
    let near = "pointcloud_search(\"cloud.geo\", point(0, 0, 1), 1e30, 1, \"index\", i)";
    let source = format!(
        "surface s() {{ int i = -1; int n = {near}; int k = 0; pointcloud_search(\"cloud.geo\", P, 1e30, 999, \"id\", k);
            Ci = color(n, i >= 0, k >= 1000) * emission(); }}"
    );
    for precision in [Standard, Reference] {
        let (picture, summary) = render(&wall_of(&source), precision);
        assert!(picture.pixels.iter().all(|p| *p == [1.0; 3]), "{:?}", picture.pixels[0]);
        assert!(summary.plan.decisions.iter().any(|d| d.effect.name() == "point_clouds" && d.is_on()));
        assert!(summary.buffers.iter().any(|(name, _)| *name == "clouds"));
    }
    let mut scene = wall_of("surface s() { Ci = color(-P[1]) * emission(); }");
    let moves = format!("displacement d() {{ int i; P += {near} * vector(0, -0.5, 0); }}");
    let by = material(&mut scene, &moves, &[]);
    scene.materials[0].displacement = Some(by);
    let (picture, _) = render(&scene, Standard);
    assert!(picture.pixels.iter().all(|p| (p[0] - 0.5).abs() < 1e-5), "{:?}", picture.pixels[0]);
    let (_, compiled) = renderer::plan(
        &wall_of("surface s() { Ci = pointcloud_search(\"no.geo\", P, 1, 1) * diffuse(N); }"),
        &Standard.into(),
    )
    .unwrap_or_else(|e| panic!("{e}"));
    assert!(compiled.warnings.concat().contains("point cloud `no.geo`"), "{:?}", compiled.warnings);
}

/// Points in the order of the grid, whoever ran first; the host's are the same.
#[test]
fn what_shaders_write_is_read_back() {
    let folder = folder();
    let file = |name: &str| folder.join(name).to_string_lossy().replace('\\', "/");
    let source = format!(
        "shader s(output int ok = 0) {{
            string half = u > 0.5 ? \"{}\" : \"{}\";
            ok = pointcloud_write(half, P, \"uv\", color(u, v, 0.1), \"n\", int(16 * u), \"who\", v > 0.5 ? \"up here\" : \"down\")
                + 2 * pointcloud_write(\"\", P);
            if (v > 0.5) ok += 4 * pointcloud_write(\"{}\", P, \"u\", u, \"n\", 7);
        }}",
        file("right.geo"),
        file("left.geo"),
        file("top.pda"),
    );
    let case = Case::new(&source);
    let on_host =
        shade::run_on_host(&case.master, &case.options, &case.outputs, grid()).unwrap_or_else(|e| panic!("{e}"));
    for precision in [Standard, Reference] {
        let shaded = case.compare(precision);
        assert!(shaded.planes[0].data.iter().all(|ok| *ok == 1.0 || *ok == 5.0));
        for name in ["left.geo", "right.geo", "top.pda"] {
            let _ = std::fs::remove_file(folder.join(name));
        }
        write(&shaded.messages).unwrap_or_else(|e| panic!("{e}"));
        let clouds =
            ["left.geo", "right.geo", "top.pda"].map(|name| read(&folder.join(name)).unwrap_or_else(|e| panic!("{e}")));
        let half = (SIDE * SIDE / 2) as usize;
        assert_eq!(clouds.each_ref().map(|c| c.positions.len()), [half; 3]);
        let [left, _, top] = clouds;
        for (k, p) in left.positions.iter().enumerate() {
            let at = grid().globals(k as u32 % (SIDE / 2), k as u32 / (SIDE / 2));
            assert_eq!(p.map(f64::from), at.p, "point {k}");
        }
        let of = |name: &str| &left.attributes.iter().find(|a| a.name == name).expect("an attribute").data;
        let Data::Triples(uv) = of("uv") else { panic!("{:?}", of("uv")) };
        assert_eq!(uv[0], [left.positions[0][0], left.positions[0][1], 0.1]);
        let Data::Texts(who) = of("who") else { panic!("{:?}", of("who")) };
        assert_eq!((who[0].as_str(), who[half - 1].as_str()), ("down", "up here"));
        let Data::Ints(1, n) = of("n") else { panic!("{:?}", of("n")) };
        assert_eq!(n[..3], [0, 1, 2]);
        assert_eq!(top.attributes.iter().map(|a| a.name.as_str()).collect::<Vec<_>>(), ["u", "n"]);
    }
    write(&on_host.messages).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(read(&folder.join("right.geo")).map(|c| c.positions.len()), Ok((SIDE * SIDE / 2) as usize));
    let source = format!("shader s() {{ pointcloud_write(\"{}\", P); }}", file("x.bgeo"));
    let refused = write(&Case::new(&source).device(Standard).messages).expect_err("refused").to_string();
    assert!(refused.contains("only .geo and .pda files are written"), "{refused}");
}

#[test]
fn renders_write_no_clouds_and_say_so() {
    let file = folder().join("render.geo");
    let source = format!(
        "surface s() {{ Ci = (1 + pointcloud_write(\"{}\", P)) * emission(); }}",
        file.to_string_lossy().replace('\\', "/")
    );
    let scene = wall_of(&source);
    let (_, compiled) = renderer::plan(&scene, &Standard.into()).unwrap_or_else(|e| panic!("{e}"));
    assert!(compiled.warnings.concat().contains("W3003"), "{:?}", compiled.warnings);
    let (picture, summary) = render(&scene, Standard);
    assert!(picture.pixels.iter().all(|p| *p == [1.0; 3]));
    assert!(summary.messages.told.is_empty() && !file.exists());
}
