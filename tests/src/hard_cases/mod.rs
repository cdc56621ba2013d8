//! What the suite of hard cases shares: on which devices and in which precisions a case runs, and the ledger of what was measured.
//!
//! In: cases that measure one number each and state its bound. Out: a failure that lists what went beyond, and with OSLCL_REPORT a
//! table of everything. What the cases are stands in tests/tests/hard_cases_*.rs; why the product holds them, in docs/numerics.md.
//!
//! `cargo test` runs a fast part on the first device; OSLCL_SLOW_TESTS=1 (`make hard-cases`) runs all on every device.

pub mod meshes;
pub mod numbers;
pub mod pictures;
pub mod rays;
pub mod report;

use oslcl_runtime::choices::{Choices, Intersection, Sampler};
use oslcl_runtime::device::{self, Device};
use oslcl_runtime::precision::Precision;

/// One device and one precision.
pub struct Run<'a> {
    /// Where.
    pub device: &'a Device,
    /// Its number, as [`Device::open`] takes it; `None`: the default.
    pub number: Option<&'a str>,
    /// In which arithmetic.
    pub precision: Precision,
    /// By which test against triangles.
    pub intersection: Intersection,
    /// Whether all is asked for, or a fast part.
    pub full: bool,
}

impl<'a> Run<'a> {
    /// The same with another test against triangles.
    pub fn with(&self, intersection: Intersection) -> Run<'a> {
        Run { intersection, ..*self }
    }

    /// What the kernels are told; the cases draw their rays one by one.
    pub fn choices(&self) -> Choices {
        let (precision, intersection, sampler) = (self.precision, self.intersection, Sampler::Independent);
        Choices { precision, intersection, sampler, ..Choices::default() }.settled()
    }

    /// The larger number when all is asked for.
    pub fn count(&self, fast: usize, full: usize) -> usize {
        if self.full { full } else { fast }
    }

    /// Rounding error of the working precision.
    pub fn epsilon(&self) -> f64 {
        if self.precision.is_double() { f64::EPSILON } else { f64::from(f32::EPSILON) }
    }
}

/// Whether the whole suite is asked for.
pub fn is_full() -> bool {
    std::env::var_os("OSLCL_SLOW_TESTS").is_some_and(|v| v != "0")
}

/// Whether a device computes in this precision; one that has no double leaves f64 out.
fn can(device: &Device, precision: Precision) -> bool {
    device.info.double || !precision.is_double()
}

/// Calls `case` for each device and precision; then fails if something went beyond its bound. `group` heads the rows.
pub fn each(group: &'static str, mut case: impl FnMut(&Run<'_>, &mut Ledger)) {
    let full = is_full();
    let count = if full { device::list().expect("an OpenCL device").len() } else { 1 };
    let mut ledger =
        Ledger { group, failures: Vec::new(), rows: Vec::new(), device: String::new(), precision: Precision::Standard };
    for index in 0..count {
        let text = index.to_string();
        let number = full.then_some(text.as_str());
        let device = Device::open(number).expect("an OpenCL device");
        for precision in [Precision::Standard, Precision::Fast, Precision::Reference] {
            if !can(&device, precision) {
                eprintln!("skipped: {} has no 64-bit floats", device.info.name);
                continue;
            }
            ledger.device = device.info.name.clone();
            ledger.precision = precision;
            let intersection = Intersection::default();
            case(&Run { device: &device, number, precision, intersection, full }, &mut ledger);
        }
    }
    report::write(&ledger.rows).expect("the report is written");
    assert!(
        ledger.failures.is_empty(),
        "{} beyond their bounds:\n{}",
        ledger.failures.len(),
        ledger.failures.join("\n")
    );
}

/// One number that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What the case is about.
    pub group: String,
    /// The case, and what is measured of it.
    pub case: String,
    /// The bound, in words.
    pub bound: String,
    /// Where.
    pub device: String,
    /// In which arithmetic.
    pub precision: Precision,
    /// The number.
    pub measured: f64,
}

/// Collects what is measured.
pub struct Ledger {
    group: &'static str,
    failures: Vec<String>,
    rows: Vec<Row>,
    device: String,
    precision: Precision,
}

impl Ledger {
    /// Holds a number to an upper bound. NaN is beyond any.
    pub fn at_most(&mut self, case: &str, measured: f64, bound: f64) {
        self.note(case, measured, &report::number(bound), measured <= bound);
    }

    fn note(&mut self, case: &str, measured: f64, bound: &str, holds: bool) {
        if !holds {
            self.failures.push(format!(
                "{}, {:?}: {}: {case}: {measured:e}, the bound is {bound}",
                self.device, self.precision, self.group
            ));
        }
        self.rows.push(Row {
            group: self.group.to_owned(),
            case: case.to_owned(),
            bound: bound.to_owned(),
            device: self.device.clone(),
            precision: self.precision,
            measured,
        });
    }
}
