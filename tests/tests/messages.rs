//! What shaders say to the host, from the device.

use oslcl_compiler::{Binding, Master, NoIncludes, Options};
use oslcl_runtime::device::Device;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::shade::{self, Grid, Kind, Shaded};
use std::sync::Mutex;

fn run(source: &str, grid: (u32, u32), bindings: &[(&str, Binding)]) -> Shaded {
    // PoCL finds no device while another thread asks for one.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _one = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
    let bindings = bindings.iter().map(|(n, b)| ((*n).to_owned(), b.clone())).collect();
    let options = Options { bindings, ..Options::default() };
    let master = Master::new(source, &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
    let outputs = shade::default_outputs(master.info());
    let artifact = shade::compile(&master, &options, &outputs).unwrap_or_else(|e| panic!("{e}"));
    let device = Device::open(None).expect("a device");
    let grid = Grid::new(grid.0, grid.1);
    shade::run(&device, &artifact, grid, Precision::Standard).unwrap_or_else(|e| panic!("{e}"))
}

fn texts(shaded: &Shaded) -> Vec<&str> {
    shaded.messages.iter().map(|m| m.text.as_str()).collect()
}

#[test]
fn points_come_in_order_and_so_does_each_points_program() {
    let source = "shader s(string who = \"x\", output float o = 0) {
        printf(\"%s %g\", who, u);
        for (int i = 0; i < 2; i++) if (v > 0.5) fprintf(\"log\", \"%d\", i);
        error(\"e\"); warning(\"w %s\", u > 0.5 ? \"right\" : \"left\"); o = u; }";
    let shaded = run(source, (2, 2), &[("who", Binding::Str("me".into()))]);
    assert_eq!(
        texts(&shaded),
        [
            "me 0",
            "Shader error [s]: e",
            "Shader warning [s]: w left",
            "me 1",
            "Shader error [s]: e",
            "Shader warning [s]: w right",
            "me 0",
            "0",
            "1",
            "Shader error [s]: e",
            "Shader warning [s]: w left",
            "me 1",
            "0",
            "1",
            "Shader error [s]: e",
            "Shader warning [s]: w right",
        ]
    );
    assert_eq!(shaded.messages[7].kind, Kind::File("log".into()));
    assert_eq!(shaded.messages[7].point, 2);
    assert_eq!(shaded.planes[0].point(1, 0), [1.0]);
}

#[test]
fn nothing_is_lost_when_there_is_more_than_the_first_buffer_holds() {
    let source = "shader s(output float o = 0) { for (int i = 0; i < 64; i++) printf(\"%d %g\", i, P); }";
    let shaded = run(source, (40, 30), &[]);
    assert_eq!(shaded.messages.len(), 40 * 30 * 64);
    assert!(shaded.messages.iter().enumerate().all(|(k, m)| m.point as usize == k / 64));
    let last = shaded.messages.last().expect("messages");
    assert_eq!(last.text, "63 1 1 1");
}

#[test]
fn what_is_never_reached_costs_nothing() {
    let source = "shader s(int say = 0, output float o = 0) { if (say) printf(\"%g\", u); o = u; }";
    let master = Master::new(source, &Options::default(), &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
    let artifact = shade::compile(&master, &Options::default(), &["o".into()]).unwrap_or_else(|e| panic!("{e}"));
    assert!(artifact.sites.is_empty() && !artifact.code.contains("record"), "{}", artifact.code);
}

#[test]
fn initialisers_of_parameters_speak_too() {
    let source = "float loud(float x) { printf(\"init %g\", x); return x; }
        shader s(float a = loud(2 * u), output float o = 0) { printf(\"body %g\", a); }";
    assert_eq!(texts(&run(source, (1, 1), &[])), ["init 1", "body 1"]);
}
