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
