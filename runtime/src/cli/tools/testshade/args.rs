//! The arguments of `testshade`.
//!
//! In: words of the command line, in the reference implementation's style: `-name` and `--name` are the same, values follow as
//! words of their own, modifiers as `--param:type=float:interactive=1`. Out: [`Args`]: settings, and what builds the group in the
//! order given. It must not know shaders.

use super::super::options::{self, Item, Spec, Takes, spec};
use oslcl_compiler::Binding;
use oslcl_runtime::film::raster::Depth;

/// What was asked for.
#[derive(Debug)]
pub struct Args {
    /// Shader group, in the order of the words.
    pub setup: Vec<Setup>,
    /// `-v`
    pub verbose: bool,
    /// `--oslquery`
    pub query: bool,
    /// `-g`, `--res`: points across and down.
    pub grid: [u32; 2],
    /// `-o`: variable and file; the file `null` is none.
    pub outputs: Vec<(String, String)>,
    /// `-d`, `-od`; without it each output is stored as the type that it has.
    pub depth: Option<Depth>,
    /// `--print`
    pub print: bool,
    /// `--groupname`
    pub group_name: Option<String>,
    /// `--raytype`
    pub raytype: String,
    /// `--raytype_opt`: nothing but the ray type is asked for, so that it is known before the shader is compiled.
    pub raytype_known: bool,
    /// `--iters`
    pub iterations: u32,
    /// `--entry`
    pub entries: Vec<String>,
    /// `--entryoutput`
    pub entry_outputs: Vec<String>,
    /// `--center`
    pub center: bool,
    /// `--vary_pdxdy`, `--vary_udxdy`, `--vary_vdxdy`
    pub vary: [bool; 3],
    /// `--scaleuv`
    pub scale: [f64; 2],
    /// `--offsetuv`
    pub offset: [f64; 2],
    /// `--options`, `--texoptions`: `name=value` with commas between them.
    pub options: Vec<(String, String)>,
    /// `--colorspace`
    pub colorspace: Option<String>,
    /// `--userdata`
    pub userdata: Vec<Value>,
    /// `--userdata_isconnected`
    pub userdata_isconnected: bool,
    /// `--debug`
    pub debug: bool,
    /// `--debugnan`
    pub debug_nan: bool,
    /// `--debuguninit`
    pub debug_uninit: bool,
    /// `--device`
    pub device: Option<String>,
    /// `--host`
    pub host: bool,
    /// `--help`
    pub help: bool,
    /// `--version`
    pub version: bool,
    /// `--runstats`, `--profile`
    pub statistics: bool,
    /// `--inbuffer`: shaders are named sources to compile here, never `.oso`.
    pub from_source: bool,
}

impl Args {
    /// The last value of an option inside `--options` or `--texoptions`.
    pub fn option(&self, name: &str) -> Option<&str> {
        self.options.iter().rev().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }
}

impl Default for Args {
    fn default() -> Args {
        Args {
            setup: Vec::new(),
            verbose: false,
            query: false,
            grid: [1, 1],
            outputs: Vec::new(),
            depth: None,
            print: false,
            group_name: None,
            raytype: "camera".to_owned(),
            raytype_known: false,
            iterations: 1,
            entries: Vec::new(),
            entry_outputs: Vec::new(),
            center: false,
            vary: [false; 3],
            scale: [1.0; 2],
            offset: [0.0; 2],
            options: Vec::new(),
            colorspace: None,
            userdata: Vec::new(),
            userdata_isconnected: false,
            debug: false,
            debug_nan: false,
            debug_uninit: false,
            device: None,
            host: false,
            help: false,
            version: false,
            statistics: false,
            from_source: false,
        }
    }
}

/// A step of building the group.
#[derive(Debug)]
pub enum Setup {
    /// `--layer`: names the next shader's layer.
    Layer(String),
    /// `--param`: a value of the next shader.
    Param(Value),
    /// A shader, in a layer of that name if one is given.
    Shader(String, Option<String>),
    /// `--expr`: a shader made of statements that set `result`.
    Expression(String),
    /// `--group`: a group's text, or the file that holds it.
    Group(String),
    /// `--connect`: source layer and parameter, target layer and parameter.
    Connect([String; 4]),
    /// `--reparam`: a layer's value from the second iteration on.
    Reparam(String, Value),
}

/// A named value with its hints.
#[derive(Clone, Debug)]
pub struct Value {
    /// The parameter.
    pub name: String,
    /// Its value.
    pub value: Binding,
    /// `type=`, such as `float[3]`.
    pub ty: Option<String>,
    /// `interpolated=1` or `lockgeom=0`.
    pub interpolated: bool,
    /// `interactive=1`
    pub interactive: bool,
}

const TABLE: &[Spec] = &[
    spec(&["v"], Takes::Nothing, "Print the group"),
    spec(&["res", "g"], Takes::Values(2), "XRES YRES: points of the grid"),
    spec(&["o"], Takes::Values(2), "VARIABLE FILE: write an output (file `null`: do not save)"),
    spec(&["d", "od"], Takes::Values(1), "NAME: store pictures as uint8, half or float"),
    spec(&["print"], Takes::Nothing, "Print the values of all outputs instead of saving pictures"),
    spec(&["groupname"], Takes::Values(1), "NAME: the group's name"),
    spec(&["layer"], Takes::Values(1), "NAME: the next shader's layer"),
    spec(
        &["param"],
        Takes::Values(2),
        "NAME VALUE: a parameter of the next shader (type=, interpolated=, interactive=)",
    ),
    spec(&["iparam"], Takes::Values(2), "NAME VALUE: an int parameter, as -param:type=int"),
    spec(&["shader"], Takes::Values(2), "SHADER LAYER: add a shader"),
    spec(&["connect"], Takes::Values(4), "FROM_LAYER FROM_OUTPUT TO_LAYER TO_INPUT: connect two layers"),
    spec(&["reparam"], Takes::Values(3), "LAYER NAME VALUE: change a parameter after the first iteration (type=)"),
    spec(&["group"], Takes::Values(1), "TEXT: a whole group, or the file that holds it"),
    spec(&["archivegroup"], Takes::Values(1), "FILE: not supported; an error"),
    spec(&["expr"], Takes::Values(1), "STATEMENTS: shade statements that set `result`"),
    spec(&["raytype"], Takes::Values(1), "NAME: the rays' type"),
    spec(&["raytype_opt"], Takes::Nothing, "Compile for this type of rays only"),
    spec(&["iters"], Takes::Values(1), "N: run so many times"),
    spec(&["entry"], Takes::Values(1), "LAYER: run this layer in any case"),
    spec(&["entryoutput"], Takes::Values(1), "NAME: run the layer of this output in any case"),
    spec(&["center"], Takes::Nothing, "Shade the centres of pixels, not a grid with points on the border"),
    spec(&["vary_pdxdy"], Takes::Nothing, "Let Dx(P) and Dy(P) vary"),
    spec(&["vary_udxdy"], Takes::Nothing, "Let Dx(u) and Dy(u) vary"),
    spec(&["vary_vdxdy"], Takes::Nothing, "Let Dx(v) and Dy(v) vary"),
    spec(&["scaleuv", "scalest"], Takes::Values(2), "U V: scale u and v"),
    spec(&["offsetuv", "offsetst"], Takes::Values(2), "U V: add to u and v"),
    spec(
        &["options"],
        Takes::Values(1),
        "LIST: `name=value` with commas; searchpath:shader, error_repeats, range_checking",
    ),
    spec(&["texoptions"], Takes::Values(1), "LIST: `name=value` with commas; searchpath"),
    spec(&["colorspace"], Takes::Values(1), "NAME: the working colour space"),
    spec(&["userdata"], Takes::Values(2), "NAME VALUE: data that interpolated parameters find (type=)"),
    spec(&["userdata_isconnected"], Takes::Nothing, "Let interpolated parameters count as connected"),
    spec(&["inbuffer"], Takes::Nothing, "Compile shaders from source, whether or not an .oso is there"),
    spec(&["device"], Takes::Values(1), "NAME: the OpenCL device, by number or part of its name"),
    spec(&["host"], Takes::Nothing, "Run on the host, in double precision"),
    spec(&["runstats", "stats", "profile"], Takes::Nothing, "Print what took how long"),
    spec(&["oslquery"], Takes::Nothing, "Print the group and each shader's parameters"),
    spec(&["debuguninit"], Takes::Nothing, "Report variables that are read before they have a value"),
    spec(&["debugnan"], Takes::Nothing, "Report variables that get a NaN or an infinity"),
    spec(&["debug"], Takes::Nothing, "Say which globals the compiled group reads"),
    spec(&["t"], Takes::Values(1), "N: accepted: the device runs all points at once"),
    spec(&["O0", "O1", "O2"], Takes::Nothing, "Accepted: groups are always optimised"),
    spec(&["help", "h"], Takes::Nothing, "Print this help"),
    spec(&["version"], Takes::Nothing, "Print the version"),
    // Settings of the reference implementation's own machinery: there is nothing here that they could set.
    spec(&["llvm_opt", "jbufferMB", "locale"], Takes::Values(1), ""),
    spec(
        &[
            "debug2",
            "groupoutputs",
            "warmup",
            "batched",
            "no-output-placement",
            "shadeimage",
            "noshadeimage",
            "llvm_debug",
            "use_rs_bitcode",
            "print-groupdata",
            "print-group-stats",
        ],
        Takes::Nothing,
        "",
    ),
];

/// The help text.
pub fn help() -> String {
    let head =
        "testshade -- run a shader or a shader group over a grid of points\nUsage:  testshade [options] shader...\n";
    format!("{head}{}", options::help(TABLE))
}

/// Reads the words behind the command's name; an error is a sentence for the user.
pub fn parse(words: &[String]) -> Result<Args, String> {
    let mut args = Args::default();
    for item in options::read(words, TABLE)? {
        take(&mut args, item)?;
    }
    Ok(args)
}

/// Takes one option.
fn take(args: &mut Args, mut item: Item) -> Result<(), String> {
    let first = item.value().to_owned();
    let name = item.name;
    match name {
        "" => args.setup.push(Setup::Shader(first, None)),
        "v" => args.verbose = true,
        "res" => args.grid = [count(name, &item.values[0])?, count(name, &item.values[1])?],
        "o" => args.outputs.push((first, item.values.remove(1))),
        "d" => {
            args.depth = match first.as_str() {
                "uint8" => Some(Depth::U8),
                "half" => Some(Depth::Half),
                "float" => Some(Depth::Float),
                other => return Err(format!("option `-d` takes uint8, half or float, not `{other}`")),
            }
        }
        "print" => args.print = true,
        "groupname" => args.group_name = Some(first),
        "layer" => args.setup.push(Setup::Layer(first)),
        "param" => args.setup.push(Setup::Param(value(&item.modifiers, &first, &item.values[1]))),
        "iparam" => {
            let modifiers = format!("{}:type=int", item.modifiers);
            args.setup.push(Setup::Param(value(&modifiers, &first, &item.values[1])));
        }
        "shader" => args.setup.push(Setup::Shader(first, Some(item.values.remove(1)))),
        "connect" => {
            let ends = item.values.try_into();
            args.setup.push(Setup::Connect(ends.map_err(|_| "option `-connect` needs 4 values".to_owned())?));
        }
        "reparam" => {
            let (name, text) = (&item.values[1], &item.values[2]);
            let value = value(&item.modifiers, name, text);
            if matches!(value.value, Binding::Floats(_)) && numbers(text).is_none() {
                let ty = value.ty.as_deref().unwrap_or("float");
                return Err(format!(
                    "option `-reparam` gives `{name}` of layer `{first}` a {ty}, which `{text}` is not"
                ));
            }
            args.setup.push(Setup::Reparam(first, value));
        }
        "group" => args.setup.push(Setup::Group(first)),
        "archivegroup" => return Err("archives of groups are not written; `-group` takes a group's text".to_owned()),
        "expr" => args.setup.push(Setup::Expression(first)),
        "raytype" => args.raytype = first,
        "raytype_opt" => args.raytype_known = true,
        "iters" => args.iterations = count(name, &first)?,
        "entry" => args.entries.push(first),
        "entryoutput" => args.entry_outputs.push(first),
        "center" => args.center = true,
        "vary_pdxdy" => args.vary[0] = true,
        "vary_udxdy" => args.vary[1] = true,
        "vary_vdxdy" => args.vary[2] = true,
        "scaleuv" => args.scale = [number(name, &item.values[0])?, number(name, &item.values[1])?],
        "offsetuv" => args.offset = [number(name, &item.values[0])?, number(name, &item.values[1])?],
        "options" | "texoptions" => args.options.extend(list(&first)),
        "colorspace" => args.colorspace = Some(first),
        "userdata" => args.userdata.push(value(&item.modifiers, &first, &item.values[1])),
        "userdata_isconnected" => args.userdata_isconnected = true,
        "inbuffer" => args.from_source = true,
        "debug" => args.debug = true,
        "debugnan" => args.debug_nan = true,
        "debuguninit" => args.debug_uninit = true,
        "device" => args.device = Some(first),
        "host" => args.host = true,
        "runstats" => args.statistics = true,
        "oslquery" => args.query = true,
        "help" => args.help = true,
        "version" => args.version = true,
        _ => {}
    }
    Ok(())
}

fn number(option: &str, text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| x.is_finite());
    number.ok_or_else(|| format!("option `-{option}` takes numbers, not `{text}`"))
}

fn count(option: &str, text: &str) -> Result<u32, String> {
    let count = text.parse().ok().filter(|n| (1..=65536).contains(n));
    count.ok_or_else(|| format!("option `-{option}` takes whole numbers from 1 to 65536, not `{text}`"))
}

/// `a=1,b=x` apart; a value with commas stands in quotes.
fn list(text: &str) -> Vec<(String, String)> {
    let mut out: Vec<(String, String)> = Vec::new();
    let mut quoted = false;
    let apart = text.split(|c| {
        quoted ^= c == '"';
        c == ',' && !quoted
    });
    for piece in apart.filter(|p| !p.trim().is_empty()) {
        let (name, value) = piece.split_once('=').unwrap_or((piece, "1"));
        out.push((name.trim().to_owned(), value.trim().trim_matches('"').to_owned()));
    }
    out
}

/// Numbers with commas between them, and nothing else.
fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|n| n.trim().parse().ok()).collect()
}

/// Reads a value as the reference implementation guesses its type: 16 or 3 numbers, an int, a float, else text; a type given with
/// `type=` narrows the guess.
fn value(modifiers: &str, name: &str, text: &str) -> Value {
    let mut out = Value {
        name: name.to_owned(),
        value: Binding::Str(text.to_owned()),
        ty: None,
        interpolated: false,
        interactive: false,
    };
    for modifier in modifiers.split(':') {
        match modifier.split_once('=') {
            Some(("type", ty)) => out.ty = Some(ty.to_owned()),
            Some(("lockgeom", on)) => out.interpolated = on == "0",
            Some(("interpolated", on)) => out.interpolated = on != "0",
            Some(("interactive", on)) => out.interactive = on != "0",
            _ => {}
        }
    }
    let numbers = numbers(text);
    let (base, array) = match &out.ty {
        Some(ty) => (ty.split('[').next().unwrap_or(ty), ty.contains('[')),
        None => ("", false),
    };
    out.value = match (base, numbers) {
        ("string", _) if array => Binding::Strs(text.split(',').map(str::to_owned).collect()),
        ("string", _) | ("", None) => Binding::Str(text.to_owned()),
        ("int", Some(n)) if n.len() == 1 && !array => text.trim().parse().map_or(Binding::Float(n[0]), Binding::Int),
        ("", Some(n)) if n.len() == 1 => text.trim().parse().map_or(Binding::Float(n[0]), Binding::Int),
        ("", Some(n)) if n.len() != 3 && n.len() != 16 => Binding::Str(text.to_owned()),
        ("float", Some(n)) if n.len() == 1 && !array => Binding::Float(n[0]),
        (_, Some(n)) => Binding::Floats(n),
        // As in the reference implementation, what can't be read counts as nothing.
        (_, None) => Binding::Floats(text.split(',').map(|n| n.trim().parse().unwrap_or(0.0)).collect()),
    };
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split(' ').map(str::to_owned).collect()
    }

    #[test]
    fn one_dash_or_two() {
        let args = parse(&words(
            "-g 4 2 --center -param a 1,2,3 --param:type=float:interactive=1 f 1 --iparam i 3 -layer top test",
        ));
        let args = args.expect("good words");
        assert_eq!(args.grid, [4, 2]);
        assert!(args.center);
        let [Setup::Param(a), Setup::Param(f), Setup::Param(i), Setup::Layer(layer), Setup::Shader(shader, None)] =
            &args.setup[..]
        else {
            panic!("{:?}", args.setup);
        };
        assert_eq!(a.value, Binding::Floats(vec![1.0, 2.0, 3.0]));
        assert_eq!((&f.value, f.interactive), (&Binding::Float(1.0), true));
        assert_eq!((&i.value, i.ty.as_deref()), (&Binding::Int(3), Some("int")));
        assert_eq!((layer.as_str(), shader.as_str()), ("top", "test"));
    }

    #[test]
    fn values_are_guessed() {
        let guess = |modifiers: &str, text: &str| value(modifiers, "p", text).value;
        assert_eq!(guess("", "7"), Binding::Int(7));
        assert_eq!(guess("", "7.5"), Binding::Float(7.5));
        assert_eq!(guess("", "1,2"), Binding::Str("1,2".into()));
        assert_eq!(guess("type=string", "7"), Binding::Str("7".into()));
        assert_eq!(guess("type=float[2]", "1,2"), Binding::Floats(vec![1.0, 2.0]));
        assert_eq!(guess("type=string[2]", "a,b"), Binding::Strs(vec!["a".into(), "b".into()]));
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, said) in [
            ("-g 4", "option `-g` needs 2 values"),
            ("-g 4 x", "option `-res` takes whole numbers from 1 to 65536, not `x`"),
            ("--nonsense", "unknown option `--nonsense`"),
            (
                "--reparam:type=float lay k abc",
                "option `-reparam` gives `k` of layer `lay` a float, which `abc` is not",
            ),
            ("--scaleuv nan 1", "option `-scaleuv` takes numbers, not `nan`"),
        ] {
            assert_eq!(parse(&words(text)).expect_err(text), said);
        }
        let args = parse(&words("--options a=1,searchpath:shader=\"x,y\",flag")).expect("good words");
        let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        assert_eq!(args.options, [pair("a", "1"), pair("searchpath:shader", "x,y"), pair("flag", "1")]);
    }
}
