//! The choices between accuracy and time: one table, with names, values, defaults and profiles.
//!
//! In: names and values as users write them. Out: [`Choices`], macros and build options of kernels. docs/accuracy.md shows the
//! table; a test holds them together. It must not know devices.

use crate::plan::{Effect, Overrides};
use crate::precision::Precision;
use crate::scene::Integrator;
use std::fmt::Write;

/// Where elementary functions come from (kernels/maths.h).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Maths {
    /// Our polynomials, to a few units in the last place.
    #[default]
    Polynomials,
    /// The driver's functions.
    Driver,
    /// The driver's native functions: whatever the hardware has, without a bound on the error.
    Native,
}

/// Where random numbers come from (kernels/random.h).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sampler {
    /// Independent numbers.
    #[default]
    Independent,
    /// Owen-scrambled Sobol points, four dimensions at a time: even over the samples of a pixel.
    Sobol,
}

/// How one of several emissive triangles is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LightChoice {
    /// In proportion to its power.
    #[default]
    Power,
    /// All alike.
    Uniform,
}

/// How much work goes into the trees over triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TreeQuality {
    /// `Slow` up to two million triangles, then `Medium`.
    #[default]
    Auto,
    /// Quick to build.
    Fast,
    /// In between.
    Medium,
    /// Quick to trace.
    Slow,
}

/// What accuracy is bought with time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Choices {
    /// Arithmetic.
    pub precision: Precision,
    /// Elementary functions.
    pub maths: Maths,
    /// Random numbers.
    pub sampler: Sampler,
    /// Choice among lights.
    pub lights: LightChoice,
    /// Columns of the map by which the environment is sampled; half as many rows.
    pub environment_map: u32,
    /// Trees over triangles.
    pub tree: TreeQuality,
    /// Longest path in edges; `None`: the scene's.
    pub depth: Option<u32>,
    /// Bounce from which Russian roulette may end paths, `u32::MAX`: never; `None`: the scene's.
    pub roulette: Option<u32>,
    /// Effects that are on or off whatever the scene calls for. No setting of the table.
    pub overrides: Overrides,
}

impl Default for Choices {
    fn default() -> Choices {
        Choices {
            precision: Precision::default(),
            maths: Maths::default(),
            sampler: Sampler::default(),
            lights: LightChoice::default(),
            environment_map: 512,
            tree: TreeQuality::default(),
            depth: None,
            roulette: None,
            overrides: Overrides::default(),
        }
    }
}

impl From<Precision> for Choices {
    fn from(precision: Precision) -> Choices {
        Choices { precision, ..Choices::default() }
    }
}

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
        name: "sampler",
        values: &["independent", "sobol"],
        text: "Random numbers: independent; Owen-scrambled Sobol points, which take longer to compute and cover a pixel's samples \
               evenly.",
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
        name: "tree",
        values: &["auto", "fast", "medium", "slow"],
        text: "Trees over triangles: quick to build or quick to trace. Never changes a picture but by rounding.",
    },
    Row {
        name: "depth",
        values: &["the scene's", "1 to 4096"],
        text: "Edges of the longest path. What longer paths would bring is missing: a bias.",
    },
    Row {
        name: "roulette",
        values: &["the scene's", "a bounce", "off"],
        text: "The bounce from which Russian roulette may end weak paths: no bias, more noise, less time.",
    },
];

/// The profiles and what they set.
pub const PROFILES: &[(&str, &[(&str, &str)])] = &[
    (
        "draft",
        &[
            ("precision", "fast"),
            ("sampler", "sobol"),
            ("environment_map", "128"),
            ("tree", "fast"),
            ("depth", "5"),
            ("roulette", "2"),
        ],
    ),
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

/// Why a setting is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// There is none of this name.
    #[error("there is no setting `{name}`{}; there are {}", near(suggestion), names())]
    Unknown {
        /// As given.
        name: String,
        /// The nearest known one.
        suggestion: Option<String>,
    },
    /// It can't be this.
    #[error("setting `{name}` cannot be `{value}`: it is {}", values(name))]
    Value {
        /// The setting.
        name: String,
        /// As given.
        value: String,
    },
    /// There is no profile of this name.
    #[error("there is no profile `{0}`; there are draft, standard, reference")]
    Profile(String),
}

fn near(suggestion: &Option<String>) -> String {
    suggestion.as_ref().map_or_else(String::new, |s| format!(", did you mean `{s}`?"))
}

fn names() -> String {
    TABLE.iter().map(|row| row.name).collect::<Vec<_>>().join(", ")
}

fn values(name: &str) -> String {
    let row = TABLE.iter().find(|row| row.name == name);
    row.map_or_else(String::new, |row| row.values.join(", "))
}

impl Choices {
    /// The choices of a profile.
    pub fn profile(name: &str) -> Result<Choices, Error> {
        let (_, settings) = PROFILES.iter().find(|(n, _)| *n == name).ok_or_else(|| Error::Profile(name.to_owned()))?;
        let mut out = Choices::default();
        settings.iter().try_for_each(|(name, value)| out.set(name, value))?;
        Ok(out)
    }

    /// Sets one by name, as in `--set sampler=sobol`.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), Error> {
        let refuse = || Error::Value { name: name.to_owned(), value: value.to_owned() };
        let number = |low: u32, high: u32| {
            let n = value.parse::<u32>().ok().filter(|n| (low..=high).contains(n));
            n.ok_or_else(refuse)
        };
        match (name, value) {
            ("precision", "standard") => self.precision = Precision::Standard,
            ("precision", "fast") => self.precision = Precision::Fast,
            ("precision", "reference") => self.precision = Precision::Reference,
            ("maths", "polynomials") => self.maths = Maths::Polynomials,
            ("maths", "driver") => self.maths = Maths::Driver,
            ("maths", "native") => self.maths = Maths::Native,
            ("sampler", "independent") => self.sampler = Sampler::Independent,
            ("sampler", "sobol") => self.sampler = Sampler::Sobol,
            ("lights", "power") => self.lights = LightChoice::Power,
            ("lights", "uniform") => self.lights = LightChoice::Uniform,
            ("environment_map", _) => {
                let columns = number(16, 8192)?;
                if !columns.is_power_of_two() {
                    return Err(refuse());
                }
                self.environment_map = columns;
            }
            ("tree", "auto") => self.tree = TreeQuality::Auto,
            ("tree", "fast") => self.tree = TreeQuality::Fast,
            ("tree", "medium") => self.tree = TreeQuality::Medium,
            ("tree", "slow") => self.tree = TreeQuality::Slow,
            ("depth", _) => self.depth = Some(number(1, 4096)?),
            ("roulette", "off") => self.roulette = Some(u32::MAX),
            ("roulette", _) => self.roulette = Some(number(1, 4096)?),
            _ if TABLE.iter().any(|row| row.name == name) => return Err(refuse()),
            _ => {
                let suggestion = oslcl_compiler::suggest::closest(name, TABLE.iter().map(|row| row.name));
                return Err(Error::Unknown { name: name.to_owned(), suggestion: suggestion.map(str::to_owned) });
            }
        }
        Ok(())
    }

    /// Lets the choices of depth and roulette stand for the scene's.
    pub fn apply(&self, integrator: &mut Integrator) {
        integrator.max_depth = self.depth.unwrap_or(integrator.max_depth);
        match self.roulette {
            None => {}
            Some(u32::MAX) => integrator.roulette_from = None,
            from => integrator.roulette_from = from,
        }
    }

    /// With the precision that the overrides of effects ask for.
    pub fn settled(&self) -> Choices {
        let precision = match self.precision {
            _ if self.overrides.forces(Effect::DoublePrecision) => Precision::Reference,
            Precision::Reference if self.overrides.removes(Effect::DoublePrecision) => Precision::Standard,
            precision => precision,
        };
        Choices { precision, ..*self }
    }

    /// The macros that every program has for these choices.
    pub fn macros(&self) -> Vec<String> {
        let maths = match self.maths {
            Maths::Polynomials => None,
            Maths::Driver => Some("OSLCL_DRIVER_MATH"),
            Maths::Native => Some("OSLCL_NATIVE_MATH"),
        };
        let sampler = (self.sampler == Sampler::Sobol).then_some("SAMPLER_SOBOL");
        maths.into_iter().chain(sampler).map(str::to_owned).collect()
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_of_the_table_can_be_set() {
        for row in TABLE {
            for value in row.values.iter().filter(|v| !v.contains(' ')) {
                let mut choices = Choices::default();
                assert_eq!(choices.set(row.name, value), Ok(()), "{} {value}", row.name);
            }
            let refused = Choices::default().set(row.name, "nonsense").expect_err("refused").to_string();
            assert!(refused.contains(row.values[0]), "{refused}");
        }
        for (name, _) in PROFILES {
            assert!(Choices::profile(name).is_ok(), "{name}");
        }
        assert_eq!(Choices::profile("standard"), Ok(Choices::default()));
        assert_eq!(Choices::profile("best"), Err(Error::Profile("best".to_owned())));
    }

    #[test]
    fn the_first_value_is_the_default() {
        for row in TABLE.iter().filter(|row| !row.values[0].contains(' ')) {
            let mut choices = Choices::default();
            assert_eq!(choices.set(row.name, row.values[0]), Ok(()));
            assert_eq!(choices, Choices::default(), "{}", row.name);
        }
    }

    #[test]
    fn the_page_has_the_table() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/accuracy.md");
        let page = std::fs::read_to_string(path).expect("docs/accuracy.md");
        let table = markdown();
        assert!(page.contains(&table), "docs/accuracy.md lacks this table:\n{table}");
    }

    #[test]
    fn what_is_misspelt_is_suggested() {
        let said = Choices::default().set("samplr", "sobol").expect_err("refused").to_string();
        assert!(said.contains("did you mean `sampler`?"), "{said}");
        for value in ["15", "100", "16384", "x"] {
            assert!(Choices::default().set("environment_map", value).is_err(), "{value}");
        }
    }
}
