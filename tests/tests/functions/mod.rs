//! Writes a shader per row of the table of built-ins: an output for each overload, arguments from the shader globals.
//!
//! In: the table. Out: label and OSL source. Rows that lowering rewrites get their arguments' names and arrays here.

use oslcl_compiler::builtins::{Lowering, TABLE, sig};
use oslcl_compiler::types::{Base, Extent, Type};

/// Globals to take floats from, and triples. A call with more arguments starts again.
const FLOATS: [&str; 4] = ["u", "v", "time", "dtime"];
const TRIPLES: [&str; 5] = ["P", "I", "N", "Ng", "dPdu"];

/// Writes arguments; each takes the next globals.
#[derive(Default)]
struct Writer {
    floats: usize,
    triples: usize,
}

impl Writer {
    fn float(&mut self) -> &'static str {
        self.floats += 1;
        FLOATS[(self.floats - 1) % FLOATS.len()]
    }

    fn triple(&mut self) -> &'static str {
        self.triples += 1;
        TRIPLES[(self.triples - 1) % TRIPLES.len()]
    }

    /// An expression of this type.
    fn value(&mut self, ty: Type) -> String {
        match ty.base {
            Base::Int => format!("(int)(3 * {})", self.float()),
            Base::Float => self.float().to_owned(),
            Base::Matrix => "matrix(P[0], P[1], P[2], u, I[0], I[1], I[2], v, N[0], N[1], N[2], time, Ng[0], Ng[1], \
                             Ng[2], 1)"
                .to_owned(),
            base => {
                let t = self.triple();
                format!("{}({t}[0], {t}[1], {t}[2])", base.keyword())
            }
        }
    }
}

/// A shader in the making: output parameters and statements.
struct Shader {
    name: String,
    params: Vec<String>,
    body: String,
}

impl Shader {
    fn new(name: &str) -> Shader {
        Shader { name: format!("f_{name}"), params: Vec::new(), body: String::new() }
    }

    fn output(&mut self, ty: &str) -> String {
        let name = format!("o{}", self.params.len());
        self.params.push(format!("output {ty} {name} = 0"));
        name
    }

    fn line(&mut self, ty: &str, expression: &str) {
        let name = self.output(ty);
        self.body.push_str(&format!("    {name} = {expression};\n"));
    }

    fn finish(self) -> (String, String) {
        let source = format!("shader {}({})\n{{\n{}}}\n", self.name, self.params.join(",\n    "), self.body);
        (self.name, source)
    }
}

/// Rows whose vectors have unit length by contract.
const UNIT: [&str; 3] = ["reflect", "refract", "fresnel"];

/// A row that is one call.
fn plain(name: &str, overloads: &[sig::Overload]) -> (String, String) {
    let mut shader = Shader::new(name);
    for overload in overloads {
        let mut w = Writer::default();
        let mut args = Vec::new();
        for formal in &overload.formals {
            let ty = formal.ty.unwrap_or(Type::scalar(Base::Float));
            let unit = ty.base.is_triple() && UNIT.contains(&name);
            args.push(match (formal.output, unit) {
                (true, _) => shader.output(ty.base.keyword()),
                (false, true) => format!("normalize({})", w.value(ty)),
                (false, false) => w.value(ty),
            });
        }
        let call = format!("{name}({})", args.join(", "));
        if overload.ret.base == Base::Void {
            shader.body.push_str(&format!("    {call};\n"));
        } else {
            shader.line(overload.ret.base.keyword(), &call);
        }
    }
    shader.finish()
}

/// A noise row: without a kind, and with each.
fn noise(name: &str, overloads: &[sig::Overload]) -> Vec<(String, String)> {
    let kinds: &[&str] = match name {
        "noise" => &["", "perlin", "uperlin", "cell", "hash", "simplex", "usimplex", "gabor", "null", "unull"],
        "pnoise" => &["", "perlin", "uperlin", "cell", "hash", "gabor"],
        _ => &[""],
    };
    let mut shaders = Vec::new();
    for kind in kinds {
        let mut shader = Shader::new(&format!("{name}_{kind}"));
        for overload in overloads {
            let named = overload.formals[0].ty == Some(Type::scalar(Base::String));
            // Points, vectors and normals are alike after lowering.
            if named == kind.is_empty() || matches!(overload.ret.base, Base::Vector | Base::Normal | Base::Point) {
                continue;
            }
            let mut w = Writer::default();
            let mut args = if named { vec![format!("\"{kind}\"")] } else { Vec::new() };
            args.extend(overload.formals.iter().skip(usize::from(named)).filter_map(|f| f.ty).map(|t| w.value(t)));
            if *kind == "gabor" {
                // The filter amplifies the rounding of the differences by as much as they are apart in size;
                // run/derivatives.osl holds it for differences that belong together.
                args.extend(["\"do_filter\"".to_owned(), "0".to_owned()]);
            }
            shader.line(
                overload.ret.base.keyword(),
                &format!("({}){name}({})", overload.ret.base.keyword(), args.join(", ")),
            );
        }
        shaders.push(shader.finish());
    }
    shaders
}

const BASES: [&str; 6] = ["catmull-rom", "bezier", "bspline", "hermite", "linear", "constant"];

fn splines() -> Vec<(String, String)> {
    let mut curve = Shader::new("spline");
    curve.body.push_str("    float k[8] = {P[0], P[1], P[2], I[0], I[1], I[2], N[0], N[1]};\n");
    curve.body.push_str("    color c[5] = {color(P[0], P[1], P[2]), color(I[0], I[1], I[2]), color(N[0], N[1], N[2]), color(u), color(v)};\n");
    for basis in BASES {
        curve.line("float", &format!("spline(\"{basis}\", u, k)"));
        curve.line("float", &format!("spline(\"{basis}\", u, 4, k)"));
        curve.line("color", &format!("spline(\"{basis}\", v, c)"));
        curve.line("float", &format!("spline(\"{basis}\", u, P[0], P[1], P[2], v)"));
    }
    let mut inverse = Shader::new("splineinverse");
    // Monotonic knots: elsewhere there are several answers.
    inverse.body.push_str("    float k[7] = {0, 0, 0.25, 0.5, 1.5, 2, 2};\n    float m[4] = {3, 2, 1, 0};\n");
    for basis in ["catmull-rom", "bezier", "bspline", "linear"] {
        inverse.line("float", &format!("floor(500 * splineinverse(\"{basis}\", v, k) + 0.5) / 500"));
        inverse.line("float", &format!("floor(500 * splineinverse(\"{basis}\", v, m) + 0.5) / 500"));
    }
    vec![curve.finish(), inverse.finish()]
}

/// What lowering rewrites.
fn rewritten() -> Vec<(String, String)> {
    let mut colour = Shader::new("transformc");
    for space in ["rgb", "hsv", "hsl", "YIQ", "XYZ", "xyY", "sRGB"] {
        colour.line("color", &format!("transformc(\"rgb\", \"{space}\", color(P[0], P[1], P[2]))"));
        colour.line("color", &format!("transformc(\"{space}\", \"rgb\", color(I[0], I[1], I[2]))"));
        colour.line("color", &format!("color(\"{space}\", u, v, time)"));
    }
    let mut matrix = Shader::new("transform");
    let m = Writer::default().value(Type::scalar(Base::Matrix));
    for (ty, argument) in [("point", "dPdu"), ("vector", "vector(dPdu)"), ("normal", "normal(dPdu)")] {
        let argument = if ty == "point" { "point(dPdu)" } else { argument };
        matrix.line(ty, &format!("transform({m}, {argument})"));
    }
    matrix.line("matrix", &format!("1 / {m}"));
    matrix.line("matrix", &format!("{m} * transpose({m})"));
    vec![colour.finish(), matrix.finish()]
}

/// The sources of the functions that work component by component, or of all others.
pub fn sources(componentwise: bool) -> Vec<(String, String)> {
    let mut out = Vec::new();
    for row in TABLE {
        let Some(id) = oslcl_compiler::builtins::find(row.name) else { continue };
        let numbers = |o: &&sig::Overload| {
            let usable = |t: Type| !matches!(t.base, Base::String | Base::Closure) && t.extent == Extent::Scalar;
            usable(o.ret) && o.formals.iter().all(|f| f.ty.is_some_and(usable))
        };
        let overloads: Vec<sig::Overload> = sig::overloads(id).iter().filter(numbers).cloned().collect();
        if componentwise != (row.lowering == Lowering::Componentwise) {
            continue;
        }
        match row.lowering {
            Lowering::Componentwise | Lowering::Direct | Lowering::State => out.push(plain(row.name, &overloads)),
            Lowering::Special => match row.name {
                "mix" | "select" | "faceforward" | "hash" => out.push(plain(row.name, &overloads)),
                name if name.ends_with("noise") => out.extend(noise(name, sig::overloads(id))),
                // Spelt out below; the others (rays, array lengths) are in the corpus.
                _ => {}
            },
            Lowering::Internal | Lowering::InternalState | Lowering::InternalEffect | Lowering::NotYet => {}
            // These never reach a device.
            Lowering::Host | Lowering::InternalHost => {}
        }
    }
    if !componentwise {
        out.extend(splines());
        out.extend(rewritten());
    }
    out
}
