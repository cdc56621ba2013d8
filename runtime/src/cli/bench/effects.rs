//! `oslcl bench effects`: what it saves to simulate only what a scene calls for. Ten scenes, each with more in it than the one
//! before, as planned and with every effect forced on.
//!
//! In: a device. Out: a page in Markdown. The scenes are in the binary: nothing else is needed to make the page again.

use super::super::args::EffectsArgs;
use super::super::{Error, render as rendering, terminal};
use super::page::Page;
use oslcl_runtime::choices::Choices;
use oslcl_runtime::device::Device;
use oslcl_runtime::measure::{Estimate, estimate};
use oslcl_runtime::plan::{Effect, Overrides};
use oslcl_runtime::render::{Options, Summary};
use oslcl_runtime::scene::{self, Film, Scene};
use oslcl_runtime::session::Session;
use std::fmt::Write;
use std::path::Path;

/// What every scene has, and what each adds: a title and text of a scene file.
const HEAD: &str = "[camera]\norigin = [0, -6, 1.5]\ntarget = [0, 0, 0.3]\nhfov = 40.0\nLENS\n[integrator]\nsamples = 16\nmax_depth = 6\nroulette = ROULETTE\n";
const STEPS: [(&str, &str); 10] = [
    (
        "one diffuse sphere",
        "[environment]\nSKY\n[materials.ball]\nosl = \"surface ball() { Ci = 0.5 * diffuse(N); }\"\n\
         [[meshes]]\nname = \"ball\"\nshape = \"sphere\"\nsize = 2\nmaterial = \"ball\"\n",
    ),
    (
        "and a lamp",
        "[materials.lamp]\nshader = \"emitter\"\nparams = { radiance = [12.0, 11.0, 9.0] }\n[[meshes]]\nname = \"lamp\"\nshape = \"quad\"\n\
         material = \"lamp\"\ntransform = { rotate = { axis = [1, 0, 0], degrees = 180 }, translate = [0, 0, 4] }\n",
    ),
    (
        "and a floor with a pattern",
        "[materials.floor]\nosl = \"surface floor() { Ci = (0.3 + 0.2 * mod(floor(8 * u) + floor(8 * v), 2)) * diffuse(N); }\"\n[[meshes]]\nname = \"floor\"\nshape = \"quad\"\nsize = [12, 12]\nmaterial = \"floor\"\n\
         transform = { translate = [0, 0, -1] }\n",
    ),
    (
        "and metal",
        "[materials.metal]\nshader = \"metal\"\n[[meshes]]\nname = \"metal\"\nshape = \"sphere\"\nmaterial = \"metal\"\ntransform = { translate = [-2, 0, -0.5] }\n",
    ),
    (
        "and glass",
        "[materials.glass]\nshader = \"glass\"\n[[meshes]]\nname = \"glass\"\nshape = \"sphere\"\nmaterial = \"glass\"\ntransform = { translate = [2, 0, -0.5] }\n",
    ),
    ("and a sky that differs by direction", ""),
    ("and depth of field, and roulette", ""),
    (
        "and a mesh placed three times",
        "[[instances]]\nmesh = \"metal\"\ntransform = { translate = [-1.5, -1.5, -0.7] }\n[[instances]]\nmesh = \"metal\"\ntransform = { translate = [1.5, -1.5, -0.7] }\n",
    ),
    (
        "and a layered material",
        "[materials.layered]\nshader = \"standard_surface\"\nparams = { base_color = [0.55, 0.04, 0.06], sheen = 0.3, film = 350.0 }\n\
         [[meshes]]\nname = \"layered\"\nshape = \"sphere\"\nmaterial = \"layered\"\ntransform = { translate = [0, -2, -0.5] }\n",
    ),
    (
        "and everything else",
        "[materials.bumps]\nosl = \"displacement bumps() { P += 0.1 * noise(\\\"perlin\\\", 4 * P) * N; }\"\n\
         [materials.all]\ndisplacement = \"bumps\"\nosl = \"\"\"surface all() {\n\
           point o = transform(\"object\", P), c = transform(\"camera\", P), n = transform(\"NDC\", P);\n\
           color tint = 0.5 + 0.1 * color(noise(o), c[2] * 0.1, n[0]);\n\
           float soft = clamp(1 - filterwidth(P)[0], 0, 1) * (raytype(\"camera\") ? 1 : 0.9);\n\
           Ci = soft * tint * (0.2 * diffuse(N) + 0.1 * oren_nayar(N, 0.4) + 0.1 * translucent(N) + 0.1 * phong(N, 20)\n\
              + 0.1 * ward(N, dPdu, 0.2, 0.1) + 0.1 * microfacet(\"ggx\", N, 0.2, 1.5, 0) + 0.05 * transparent() + 0.05 * holdout()\n\
              + 0.1 * burley_diffuse_bsdf(N, color(0.8), 0.5) + 0.1 * sheen_bsdf(N, color(1), 0.5))\n\
              + 0.01 * u * emission(); }\"\"\"\n\
         [[meshes]]\nname = \"all\"\nshape = \"sphere\"\nmaterial = \"all\"\ntransform = { translate = [0.9, -2.4, -0.5] }\n",
    ),
];

/// How many times as many runs are made where so many leave open which is faster.
const RUNS_IF_OPEN: u32 = 4;

/// The scene with the first `count` steps.
fn scene(count: usize, size: (u32, u32), spp: u32) -> Result<Scene, Error> {
    let sky = if count > 5 {
        "shader = \"sky\""
    } else {
        "osl = \"surface sky() { Ci = color(0.4, 0.5, 0.6) * background(); }\""
    };
    let (lens, roulette) = if count > 6 { ("lens_radius = 0.05", "3") } else { ("", "false") };
    let mut text = HEAD.replace("LENS", lens).replace("ROULETTE", roulette);
    // Instances stand behind meshes of the same list only: the order of tables does not count.
    for (_, step) in &STEPS[..count] {
        text.push_str(&step.replace("SKY", sky));
    }
    let mut scene = scene::parse(&text, Path::new("effects.toml"))?;
    scene.film = Film { width: size.0, height: size.1 };
    scene.integrator.samples = spp;
    Ok(scene)
}

/// One scene, both ways.
struct Row {
    title: &'static str,
    /// Seconds of each run, planned and forced.
    seconds: [Vec<f64>; 2],
    bytes: [u64; 2],
    effects: usize,
    kernels: [usize; 2],
    same: bool,
}

/// Every effect that does not change how numbers are computed, and is not only in code of materials that ask for it.
fn all_effects() -> impl Iterator<Item = Effect> {
    Effect::choosable().filter(|e| *e != Effect::DoublePrecision && !e.is_of_materials())
}

/// Renders, writes the page.
pub fn run(args: &EffectsArgs) -> Result<(), Error> {
    let device = Device::open(args.device.as_deref())?;
    let mut rows = Vec::new();
    for (index, (title, _)) in STEPS.iter().enumerate() {
        terminal::progress(&format!("{} of {}: {title}", index + 1, STEPS.len()));
        rows.push(row(title, &scene(index + 1, args.size.unwrap_or((256, 256)), args.spp)?, &device, args.runs)?);
    }
    terminal::progress("");
    let section = section(&rows, args);
    terminal::print(&section)?;
    let intro = format!(
        "Written by `oslcl bench effects`, a section for each device. Each scene has what those above it have and something more. \
         \"Forced\" is the same scene with all {} effects forced on: all but `double_precision`, what other renderers do, and what is only in \
         the code of materials that ask for it. Times are \
         medians; behind them the least and the greatest. *Times faster* is the geometric mean over the pairs of runs, with its 95 % confidence interval.",
        all_effects().count()
    );
    Page { title: "What planning saves", intro }.write(&args.output, &device.info.name, &section)
}

fn row(title: &'static str, scene: &Scene, device: &Device, runs: u32) -> Result<Row, Error> {
    let say = |e| rendering::say(Path::new(title), e);
    let plain = Options::default();
    let forced = Choices { overrides: Overrides::new(all_effects(), []), ..plain.choices };
    let forced = Options { choices: forced, ..plain };
    let mut sessions =
        [Session::new(scene, device, &plain).map_err(say)?, Session::new(scene, device, &forced).map_err(say)?];
    let mut seen: [Option<(Vec<[f32; 3]>, Summary)>; 2] = [None, None];
    let mut once = |which: usize| {
        let (picture, summary) = sessions[which].render(&mut |_| {}).map_err(say)?;
        let seconds = summary.render_time.as_secs_f64();
        seen[which] = Some((picture.pixels, summary));
        Ok::<f64, Error>(seconds)
    };
    // The first of each warms up.
    once(0)?;
    once(1)?;
    // In turn, now the one first and now the other, so that what else the machine does meets both alike.
    let mut pairs = |count: u32| {
        let mut seconds = [Vec::new(), Vec::new()];
        for pair in 0..count {
            for which in if pair.is_multiple_of(2) { [0, 1] } else { [1, 0] } {
                seconds[which].push(once(which)?);
            }
        }
        Ok::<_, Error>(seconds)
    };
    let mut seconds = pairs(runs)?;
    if is_open(gain(&seconds)) {
        // Anew: to add to them until they please would not be a fair sample.
        seconds = pairs(RUNS_IF_OPEN * runs)?;
    }
    let bytes = seen.each_ref().map(|s| s.as_ref().map_or(0, |(_, s)| s.bytes_per_path));
    let kernels =
        seen.each_ref().map(|s| s.as_ref().map_or(0, |(_, s)| s.plan.programs.iter().map(|p| p.stages.len()).sum()));
    let effects = seen[0].as_ref().map_or(0, |(_, s)| s.plan.decisions.iter().filter(|d| d.is_on()).count());
    let same = matches!(&seen, [Some((a, _)), Some((b, _))] if a == b);
    Ok(Row { title, seconds, bytes, effects, kernels, same })
}

/// Whether an interval has both slower and faster.
fn is_open([_, least, most]: [f64; 3]) -> bool {
    least < 1.0 && most >= 1.0
}

/// How many times faster the planned one is: the geometric mean over the pairs of runs, and its 95 % confidence interval.
fn gain([planned, forced]: &[Vec<f64>; 2]) -> [f64; 3] {
    let ratios: Vec<f64> = planned.iter().zip(forced).map(|(p, f)| (f / p).ln()).collect();
    let Estimate { value, within } = estimate(&ratios);
    [value, value - within, value + within].map(f64::exp)
}

fn median(sample: &[f64]) -> f64 {
    let mut sorted = sample.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n => (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0,
    }
}

fn section(rows: &[Row], args: &EffectsArgs) -> String {
    let (width, height) = args.size.unwrap_or((256, 256));
    let mut out = format!(
        "`oslcl bench effects --size {width}x{height} --spp {} --runs {}`, in turn, now the one first and now the other; where the interval has 1 in it, \
         measured anew with {RUNS_IF_OPEN} times as many runs.\n\n\
         | scene | pairs | effects on | planned, ms | forced, ms | times faster | bytes per path, planned | forced | kernels, planned | forced | same bits |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
        args.spp, args.runs,
    );
    for r in rows {
        let time = |s: &[f64]| {
            let (least, most) = s.iter().fold((f64::MAX, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
            format!("{:.1} ({:.1} to {:.1})", 1e3 * median(s), 1e3 * least, 1e3 * most)
        };
        let [gain, least, most] = gain(&r.seconds);
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {gain:.2} ({least:.2} to {most:.2}) | {} | {} | {} | {} | {} |",
            r.title,
            r.seconds[0].len(),
            r.effects,
            time(&r.seconds[0]),
            time(&r.seconds[1]),
            r.bytes[0],
            r.bytes[1],
            r.kernels[0],
            r.kernels[1],
            if r.same { "yes" } else { "no" }
        );
    }
    let simplest = rows.first().map_or(f64::NAN, |r| gain(&r.seconds)[0]);
    let titles = |which: &dyn Fn([f64; 3]) -> bool| -> Vec<&str> {
        rows.iter().filter(|r| which(gain(&r.seconds))).map(|r| r.title).collect()
    };
    let slower = titles(&|[_, _, most]| most < 1.0);
    let open = titles(&is_open);
    let never = match (slower.is_empty(), open.is_empty()) {
        (true, true) => "met".to_owned(),
        (true, false) => format!("met but for what cannot be told apart: {}", open.join("; ")),
        (false, _) => format!("missed by {}", slower.join("; ")),
    };
    let _ = writeln!(
        out,
        "\nMarks: at least 2 times faster on the simplest scene: {} ({simplest:.2}). Never slower: {never}.",
        if simplest >= 2.0 { "met" } else { "missed" }
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_scene_reads_and_calls_for_more_than_the_one_before() {
        let mut before = 0;
        for count in 1..=STEPS.len() {
            let scene = scene(count, (8, 8), 1).unwrap_or_else(|e| panic!("{count}: {e}"));
            let (plan, _) = oslcl_runtime::render::plan(&scene, &Choices::default()).unwrap_or_else(|e| panic!("{e}"));
            let on = plan.decisions.iter().filter(|d| d.is_on()).count();
            assert!(on > before, "{}: {on} after {before}", STEPS[count - 1].0);
            before = on;
        }
    }

    #[test]
    fn gains_come_with_their_spread() {
        let of = |planned: &[f64], forced: &[f64]| gain(&[planned.to_vec(), forced.to_vec()]);
        let [gain, least, most] = of(&[1.0, 1.0, 1.0], &[2.0, 2.0, 2.0]);
        assert!((gain - 2.0).abs() < 1e-12 && (most - least).abs() < 1e-12);
        // A twentieth slower in the mean, by one run out of three.
        let [gain, least, most] = of(&[1.0, 1.0, 1.16], &[1.0, 1.0, 1.0]);
        assert!(gain < 1.0 && least < 1.0 && most > 1.0);
    }

    #[test]
    fn medians() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0]), 2.5);
    }
}
