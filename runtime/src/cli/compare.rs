//! `oslcl compare`: how far a picture is from a reference.

use super::args::CompareArgs;
use super::{Error, terminal};
use oslcl_runtime::film::compare::{mean, relative_mse, worst_tile};
use oslcl_runtime::film::read_exr;
use std::fmt::Write;

/// Reads both and prints means and errors.
pub fn run(args: &CompareArgs) -> Result<(), Error> {
    let (picture, reference) = (read_exr(&args.picture)?, read_exr(&args.reference)?);
    let (Some(error), Some(tile)) = (relative_mse(&picture, &reference), worst_tile(&picture, &reference)) else {
        return Err(Error::Compare(format!(
            "the pictures differ in size: {} has {} x {} pixels, {} has {} x {}",
            args.picture.display(),
            picture.width,
            picture.height,
            args.reference.display(),
            reference.width,
            reference.height
        )));
    };
    let (a, b) = (mean(&picture), mean(&reference));
    let mut out = String::new();
    let _ = writeln!(out, "mean          {:.6} {:.6} {:.6}", a[0], a[1], a[2]);
    let _ = writeln!(out, "reference     {:.6} {:.6} {:.6}", b[0], b[1], b[2]);
    let off = |i: usize| 100.0 * (a[i] - b[i]) / b[i].abs().max(1e-12);
    let _ = writeln!(out, "difference    {:+.4} % {:+.4} % {:+.4} %", off(0), off(1), off(2));
    let _ = writeln!(out, "relative MSE  {error:.6}");
    let _ = writeln!(out, "worst tile    {:.3} % of 32 x 32 pixels from ({}, {})", 100.0 * tile.error, tile.x, tile.y);
    terminal::print(&out)
}
