//! `oslcl shade --compare`: how far 32-bit floats are from 64-bit ones, and what each costs.

use super::args::CompareWith;
use super::{Error, terminal};
use oslcl_compiler::Artifact;
use oslcl_runtime::accuracy::{self, Deviation};
use oslcl_runtime::device::Device;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::shade::{self, Grid, Shaded, Supplies};
use oslcl_runtime::textures::Library;
use std::fmt::Write;

/// Runs of each precision; the fastest counts. The first builds what drivers build at the first launch.
const REPEATS: u32 = 5;

/// Runs the shader in each precision and prints the comparison.
pub fn run(
    device: &Device,
    artifact: &Artifact,
    grid: Grid,
    library: &Library,
    supplies: &Supplies,
    with: CompareWith,
    host: impl FnOnce() -> Result<Shaded, Error>,
) -> Result<(), Error> {
    let timed = |precision| shade::run_timed(device, artifact, grid, precision, library, supplies, REPEATS);
    let points = f64::from(grid.width) * f64::from(grid.height);
    let (wanted, price) = match with {
        CompareWith::F64 => {
            let (shaded, seconds) = timed(Precision::Reference)?;
            (shaded, Some(seconds))
        }
        CompareWith::Host => (host()?, None),
    };
    let mut out = String::new();
    let reference = if price.is_some() { "f64 on the same device" } else { "f64 by the interpreter on the host" };
    let _ = writeln!(out, "shader     {}, on {}, against {reference}", artifact.name, device.info.name);
    let [u0, v0] = grid.offset_uv;
    let [u1, v1] = [u0 + grid.scale_uv[0], v0 + grid.scale_uv[1]];
    let _ = writeln!(out, "points     {} x {}, u from {u0} to {u1}, v from {v0} to {v1}", grid.width, grid.height);
    let exact = |n: u32| n == 1 || (n - 1).is_power_of_two();
    if !(exact(grid.width) && exact(grid.height)) {
        let _ =
            writeln!(out, "note       u and v are rounded, too: with 2^n + 1 points a side they are exact from 0 to 1");
    }
    let _ = writeln!(
        out,
        "\n{:<20}{:<11}{:>11}{:>11}{:>12}{:>12}  worst at",
        "output", "precision", "max ulp", "mean ulp", "max abs", "mean abs"
    );
    let mut prices = String::new();
    for (name, precision) in [("fast", Precision::Fast), ("standard", Precision::Standard)] {
        let (got, seconds) = timed(precision)?;
        for d in accuracy::deviations(&got.planes, &wanted.planes) {
            row(&mut out, name, &d, &grid);
        }
        let _ = writeln!(prices, "{name:<11}{:>10.2} ns per point", seconds / points * 1e9);
    }
    if let Some(seconds) = price {
        let _ = writeln!(prices, "{:<11}{:>10.2} ns per point", "reference", seconds / points * 1e9);
    }
    let _ = write!(out, "\n{prices}");
    terminal::print(&out)
}

fn row(out: &mut String, precision: &str, d: &Deviation, grid: &Grid) {
    let _ = write!(
        out,
        "{:<20}{precision:<11}{:>11.3}{:>11.3}{:>12.3e}{:>12.3e}",
        d.output, d.max_ulp, d.mean_ulp, d.max_abs, d.mean_abs
    );
    if d.max_ulp > 0.0 {
        let globals = grid.globals(d.worst.at[0], d.worst.at[1]);
        let _ = write!(out, "  u {} v {}: {} for {}", globals.u, globals.v, d.worst.got, d.worst.wanted);
    }
    if d.not_finite > 0 {
        let _ = write!(out, "  ({} not finite on one side)", d.not_finite);
    }
    out.push('\n');
}
