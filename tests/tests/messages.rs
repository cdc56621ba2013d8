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

/// Shaders whose strings a device can tell apart say the same on the host.
#[test]
fn host_and_device_say_the_same() {
    let sources = [
        "shader s(string kind = \"b\", output int n = 0) {
            string names[3] = {\"alpha\", \"be\", \"gamma_x\"};
            for (int i = 0; i < 3; i++) {
                string s = names[i];
                printf(\"%s %d %d %s %d\\n\", s, strlen(s), startswith(s, kind), substr(s, 1, 2), hash(s));
                string parts[4]; int k = split(s, parts, \"_\");
                printf(\"%d %s|%s %d\\n\", k, parts[0], parts[1], regex_search(s, \"a$\"));
                n += stoi(concat(\"1\", s)) + getchar(s, 0) + endswith(s, \"a\");
            }
        }",
        "shader s(output float o = 0) {
            string where = u > 0.5 ? (v > 0.5 ? \"top\" : \"side\") : \"near\";
            if (where == \"top\") printf(\"%5.2f\", P);
            error(\"%s: %s\", where, concat(where, where));
            fprintf(concat(where, \".txt\"), \"%d\", strlen(where));
        }",
    ];
    for source in sources {
        let device = run(source, (3, 2), &[]);
        let master = Master::new(source, &Options::default(), &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
        let outputs = shade::default_outputs(master.info());
        let host = shade::run_on_host(&master, &Options::default(), &outputs, Grid::new(3, 2));
        let host = host.unwrap_or_else(|e| panic!("{e}"));
        assert!(!host.messages.is_empty());
        assert_eq!(device.messages, host.messages, "{source}");
        assert_eq!(device.planes, host.planes, "{source}");
    }
}

#[test]
fn strings_that_no_device_can_build_are_built_on_the_host() {
    let source = "shader s(output int n = 0) { string s = format(\"%g\", u * 100); n = strlen(s);
        printf(\"%s %d\", concat(s, \"!\"), stoi(s)); }";
    let master = Master::new(source, &Options::default(), &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
    let outputs = ["n".to_owned()];
    let refused = shade::compile(&master, &Options::default(), &outputs).expect_err("no device can");
    assert!(shade::needs_host(&refused), "{refused}");
    let host = shade::run_on_host(&master, &Options::default(), &outputs, Grid::new(2, 1));
    let host = host.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(texts(&host), ["0! 0", "100! 100"]);
    assert_eq!(host.planes[0].data, [1.0, 3.0]);
}
