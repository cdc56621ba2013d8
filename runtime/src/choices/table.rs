//! The table of settings, and the profiles.
//!
//! In: nothing. Out: [`TABLE`], [`PROFILES`], both as Markdown. What the values do stands beside this file.

use std::fmt::Write;

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The setting's name.
    pub name: &'static str,
    /// Its values, the default first; for a number what it may be.
    pub values: &'static [&'static str],
    /// What it decides, and what the values trade.
    pub text: &'static str,
}

/// Every setting.
pub const TABLE: &[Row] = &[
    Row {
        name: "precision",
        values: &["standard", "fast", "reference"],
        text: "Arithmetic: 32-bit floats; 32-bit floats with relaxed rules, the quickest; 64-bit floats, what the others are \
               measured against.",
    },
    Row {
        name: "maths",
        values: &["polynomials", "driver", "native"],
        text: "Elementary functions: ours, to 3.5 units in the last place, the same on every device; the driver's; the driver's \
               native ones, whose error has no bound.",
    },
    Row {
        name: "intersection",
        values: &["watertight", "fast", "f64"],
        text: "Rays against triangles: no ray passes between two; fewer operations, and some that are aimed at an edge pass; \
               watertight in 64-bit floats, which the device must have, so that points lie closer to their surfaces.",
    },
    Row {
        name: "path_state",
        values: &["float", "half"],
        text: "What paths keep from stage to stage: as it is computed; throughput, parameters of lobes and the growth of footprints in \
               16 bits, which moves a path's weight by up to 1 part in 2,000 a bounce and saves memory traffic.",
    },
    Row {
        name: "lobes",
        values: &["one", "all"],
        text: "Where a path first meets a surface: one of the material's lobes at random; a path for each, less noise where none \
               of several dominates, and longer paths in all.",
    },
    Row {
        name: "sampler",
        values: &["sobol", "independent"],
        text: "Random numbers: Owen-scrambled Sobol points, which cover a pixel's samples evenly; independent ones, quicker to \
               compute, whose error falls as 1/sqrt(N) on every scene.",
    },
    Row {
        name: "lights",
        values: &["power", "uniform"],
        text: "Which emissive triangle a shadow ray goes to: the more powerful the likelier; all alike.",
    },
    Row {
        name: "environment_map",
        values: &["512", "16 to 8192, a power of two"],
        text: "Columns of the map by which the environment is sampled (half as many rows): small bright spots need more, and more \
               take longer to make and miss the cache.",
    },
    Row {
        name: "texture_filter",
        values: &["shader", "closest", "bilinear", "bicubic"],
        text: "Between texels: as the shader's lookup says; for all lookups the closest texel, 2 x 2, or 4 x 4.",
    },
    Row {
        name: "texture_mip_bias",
        values: &["0", "a number from -16 to 16"],
        text: "Levels of detail by which lookups are coarser (fewer texels from far apart, blurred) or finer (sharper, more noise).",
    },
    Row {
        name: "tree",
        values: &["auto", "fast", "medium", "slow"],
        text: "Trees over triangles: quick to build or quick to trace. Never changes a picture but by rounding.",
    },
    Row {
        name: "follow",
        values: &["on", "off"],
        text: "Whether a material's kernel takes its paths on to the next surface, where no light or environment shines by a shader \
               that rays to it must ask; or each step is a kernel of its own, built in less time. Changes a picture by the rounding of \
               `precision=fast`, else never.",
    },
    Row {
        name: "depth",
        values: &["the scene's", "1 to 1024"],
        text: "Edges of the longest path. What longer paths would bring is missing: a bias.",
    },
    Row {
        name: "roulette",
        values: &["the scene's", "a bounce", "off"],
        text: "The bounce from which Russian roulette may end weak paths: no bias, more noise, less time.",
    },
    Row {
        name: "adaptive",
        values: &["off", "a relative error from 0.0001 to 1"],
        text: "All pixels get as many samples; or tiles of 8 x 8 pixels get no more once their relative error seems to be below this.",
    },
];

/// The profiles and what they set.
pub const PROFILES: &[(&str, &[(&str, &str)])] = &[
    ("draft", &[("precision", "fast"), ("intersection", "fast"), ("environment_map", "128"), ("tree", "fast")]),
    ("standard", &[]),
    (
        "reference",
        &[
            ("precision", "reference"),
            ("maths", "driver"),
            ("sampler", "independent"),
            ("environment_map", "1024"),
            ("tree", "slow"),
            ("roulette", "off"),
        ],
    ),
];

/// The table and the profiles in Markdown, for docs/accuracy.md.
pub fn markdown() -> String {
    let mut out = String::from("| setting | values, the default first | what it decides |\n|---|---|---|\n");
    for row in TABLE {
        let _ = writeln!(out, "| `{}` | {} | {} |", row.name, row.values.join(", "), row.text);
    }
    out.push_str("\n| profile | sets |\n|---|---|\n");
    for (name, settings) in PROFILES {
        let list: Vec<String> = settings.iter().map(|(n, v)| format!("{n} = {v}")).collect();
        let list = if list.is_empty() { "nothing: all defaults".to_owned() } else { list.join(", ") };
        let _ = writeln!(out, "| `{name}` | {list} |");
    }
    out
}
