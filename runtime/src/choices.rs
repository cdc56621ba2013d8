//! The choices between accuracy and time: one table, with names, values, defaults and profiles.
//!
//! In: names and values as users write them. Out: [`Choices`], macros and build options of kernels. docs/accuracy.md shows the
//! table; a test holds them together. It must not know devices.

mod table;
mod values;

pub use table::{PROFILES, Row, TABLE, markdown};
pub use values::{
    Follow, Intersection, LightChoice, Lobes, Maths, MipBias, PathState, Sampler, TextureFilter, Threshold, TreeQuality,
};

use crate::plan::{Effect, Overrides};
use crate::precision::Precision;
use crate::scene::Integrator;

/// What accuracy is bought with time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Choices {
    /// Arithmetic.
    pub precision: Precision,
    /// Elementary functions.
    pub maths: Maths,
    /// Rays against triangles.
    pub intersection: Intersection,
    /// State of paths.
    pub path_state: PathState,
    /// Lobes of a path's first hit.
    pub lobes: Lobes,
    /// Random numbers.
    pub sampler: Sampler,
    /// Choice among lights.
    pub lights: LightChoice,
    /// Columns of the map by which the environment is sampled; half as many rows.
    pub environment_map: u32,
    /// Interpolation of textures.
    pub texture_filter: TextureFilter,
    /// Levels of detail that lookups of textures are off by.
    pub texture_mip_bias: MipBias,
    /// Trees over triangles.
    pub tree: TreeQuality,
    /// Whether materials' kernels take paths on.
    pub follow: Follow,
    /// Longest path in edges; `None`: the scene's.
    pub depth: Option<u32>,
    /// Bounce from which Russian roulette may end paths, `u32::MAX`: never; `None`: the scene's.
    pub roulette: Option<u32>,
    /// Relative error at which a tile of pixels gets no more samples; `None`: all pixels get as many.
    pub adaptive: Option<Threshold>,
    /// Effects that are on or off whatever the scene calls for. No setting of the table.
    pub overrides: Overrides,
}

impl Default for Choices {
    fn default() -> Choices {
        Choices {
            precision: Precision::default(),
            maths: Maths::default(),
            intersection: Intersection::default(),
            path_state: PathState::default(),
            lobes: Lobes::default(),
            sampler: Sampler::default(),
            lights: LightChoice::default(),
            environment_map: 512,
            texture_filter: TextureFilter::default(),
            texture_mip_bias: MipBias::default(),
            tree: TreeQuality::default(),
            follow: Follow::default(),
            depth: None,
            roulette: None,
            adaptive: None,
            overrides: Overrides::default(),
        }
    }
}

impl From<Precision> for Choices {
    fn from(precision: Precision) -> Choices {
        Choices { precision, ..Choices::default() }
    }
}

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

    /// Sets one by name, as in `--set sampler=independent`.
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
            ("intersection", "watertight") => self.intersection = Intersection::Watertight,
            ("intersection", "fast") => self.intersection = Intersection::Fast,
            ("intersection", "f64") => self.intersection = Intersection::Double,
            ("path_state", "float") => self.path_state = PathState::Float,
            ("path_state", "half") => self.path_state = PathState::Half,
            ("lobes", "one") => self.lobes = Lobes::One,
            ("lobes", "all") => self.lobes = Lobes::All,
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
            ("texture_filter", "shader") => self.texture_filter = TextureFilter::Shader,
            ("texture_filter", "closest") => self.texture_filter = TextureFilter::Closest,
            ("texture_filter", "bilinear") => self.texture_filter = TextureFilter::Bilinear,
            ("texture_filter", "bicubic") => self.texture_filter = TextureFilter::Bicubic,
            ("texture_mip_bias", _) => self.texture_mip_bias = MipBias::parse(value).ok_or_else(refuse)?,
            ("tree", "auto") => self.tree = TreeQuality::Auto,
            ("tree", "fast") => self.tree = TreeQuality::Fast,
            ("tree", "medium") => self.tree = TreeQuality::Medium,
            ("tree", "slow") => self.tree = TreeQuality::Slow,
            ("follow", "on") => self.follow = Follow::On,
            ("follow", "off") => self.follow = Follow::Off,
            ("depth", _) => self.depth = Some(number(1, 1024)?),
            ("roulette", "off") => self.roulette = Some(u32::MAX),
            ("roulette", _) => self.roulette = Some(number(1, 4096)?),
            ("adaptive", "off") => self.adaptive = None,
            ("adaptive", _) => self.adaptive = Some(Threshold::parse(value).ok_or_else(refuse)?),
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

    /// With the precision that the overrides of effects ask for; and where everything is in doubles, nothing is so especially.
    pub fn settled(&self) -> Choices {
        let precision = match self.precision {
            _ if self.overrides.forces(Effect::DoublePrecision) => Precision::Reference,
            Precision::Reference if self.overrides.removes(Effect::DoublePrecision) => Precision::Standard,
            precision => precision,
        };
        let intersection = match self.intersection {
            Intersection::Double if precision.is_double() => Intersection::Watertight,
            intersection => intersection,
        };
        Choices { precision, intersection, ..*self }
    }

    /// What of this needs a device with 64-bit floats, by name and value.
    pub fn needs_double(&self) -> Option<&'static str> {
        match self.settled() {
            c if c.precision.is_double() => Some("precision=reference"),
            c if c.intersection == Intersection::Double => Some("intersection=f64"),
            _ => None,
        }
    }

    /// The macros that every program has for these choices.
    pub fn macros(&self) -> Vec<String> {
        let maths = match self.maths {
            Maths::Polynomials => None,
            Maths::Driver => Some("OSLCL_DRIVER_MATH"),
            Maths::Native => Some("OSLCL_NATIVE_MATH"),
        };
        let intersection = match self.intersection {
            Intersection::Watertight => None,
            Intersection::Fast => Some("INTERSECTION_FAST"),
            Intersection::Double => Some("INTERSECTION_F64"),
        };
        let sampler = (self.sampler == Sampler::Sobol).then_some("SAMPLER_SOBOL");
        [maths, intersection, sampler].into_iter().flatten().map(str::to_owned).collect()
    }

    /// The macros of programs that look textures up: those of all interpolations that are compiled go with the effects.
    pub fn texture_macros(&self) -> Vec<String> {
        let filter = match self.texture_filter {
            TextureFilter::Shader => None,
            TextureFilter::Closest => Some("TEXTURE_FILTER INTERP_CLOSEST".to_owned()),
            TextureFilter::Bilinear => Some("TEXTURE_FILTER INTERP_LINEAR".to_owned()),
            TextureFilter::Bicubic => Some("TEXTURE_FILTER INTERP_CUBIC".to_owned()),
        };
        let bias = self.texture_mip_bias;
        let bias = (bias != MipBias::default()).then(|| format!("TEXTURE_MIP_SCALE {:?}", bias.levels().exp2() as f32));
        filter.into_iter().chain(bias).collect()
    }
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
