//! How exact the arithmetic of kernels is.
//!
//! In: a choice. Out: build options, the size of a `real`. It must not know devices or stages; kernels/real.h is the other
//! side of it.

/// What `real` is in kernels, and by which rules it is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// 32-bit floats with relaxed rules: the driver may reorder sums and assume that there are no infinities.
    Fast,
    /// 32-bit floats.
    #[default]
    Standard,
    /// 64-bit floats, which the device must have: what the others are measured against.
    Reference,
}

impl Precision {
    /// The options of every program that works in this precision.
    pub fn build_options(self) -> &'static str {
        match self {
            Precision::Fast => "-cl-std=CL1.2 -cl-single-precision-constant -cl-fast-relaxed-math -D OSLCL_FAST",
            Precision::Standard => "-cl-std=CL1.2 -cl-single-precision-constant",
            Precision::Reference => "-cl-std=CL1.2 -D OSLCL_F64",
        }
    }

    /// Whether `real` is double.
    pub fn is_double(self) -> bool {
        self == Precision::Reference
    }

    /// Bytes of a `real`.
    pub fn real_bytes(self) -> u64 {
        if self.is_double() { 8 } else { 4 }
    }
}
