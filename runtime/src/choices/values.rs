//! The values that settings take.

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

/// How a ray is tested against a triangle (kernels/triangle.h).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Intersection {
    /// No ray passes between two triangles.
    #[default]
    Watertight,
    /// A few operations fewer; rays at edges may pass.
    Fast,
    /// Watertight, in 64-bit floats whatever the precision is.
    Double,
}

/// How path state is kept between stages (the fields in plan/layout.rs say which may be short).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PathState {
    /// As it is computed.
    #[default]
    Float,
    /// Throughput and parameters of lobes in 16-bit floats.
    Half,
}

/// Which lobes of a path's first hit are followed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Lobes {
    /// One, at random.
    #[default]
    One,
    /// Each, by a path of its own.
    All,
}

/// Where random numbers come from (kernels/random.h).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sampler {
    /// Owen-scrambled Sobol points, four dimensions at a time: even over the samples of a pixel.
    #[default]
    Sobol,
    /// Independent numbers.
    Independent,
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

/// Whether materials' kernels take paths on to the next surfaces (ADR 0024).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Follow {
    /// Where no light's shader has to be asked.
    #[default]
    On,
    /// Each step is a kernel of its own.
    Off,
}

/// How textures are interpolated between texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TextureFilter {
    /// As each lookup says.
    #[default]
    Shader,
    /// The closest texel.
    Closest,
    /// Linearly, of 2 x 2.
    Bilinear,
    /// By cubics, of 4 x 4.
    Bicubic,
}

/// A relative error, in millionths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Threshold(u32);

impl Threshold {
    /// Reads a number from 0.0001 to 1.
    pub fn parse(text: &str) -> Option<Threshold> {
        let error = text.parse::<f64>().ok().filter(|x| (1e-4..=1.0).contains(x))?;
        Some(Threshold((1e6 * error).round() as u32))
    }

    /// As a part of 1.
    pub fn error(self) -> f64 {
        f64::from(self.0) / 1e6
    }
}

/// A number of levels of detail, in thousandths: positive is coarser.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MipBias(i32);

impl MipBias {
    /// Most levels either way.
    const MOST: f64 = 16.0;

    /// Reads a number from -16 to 16.
    pub fn parse(text: &str) -> Option<MipBias> {
        let levels = text.parse::<f64>().ok().filter(|x| x.abs() <= MipBias::MOST)?;
        Some(MipBias((1000.0 * levels).round() as i32))
    }

    /// Levels of detail.
    pub fn levels(self) -> f64 {
        f64::from(self.0) / 1000.0
    }
}
