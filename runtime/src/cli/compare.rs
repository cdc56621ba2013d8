//! `oslcl compare`: how far a picture is from a reference.

use super::args::CompareArgs;
use super::{Error, terminal};
use oslcl_runtime::film::compare::{mean, relative_mse, worst_tile};
use oslcl_runtime::film::{flip, raster, read_exr};
use std::fmt::Write;

/// Reads both and prints means and errors, or with limits whether they hold.
pub fn run(args: &CompareArgs) -> Result<(), Error> {
    if let Some(limits) = limits(args) {
        return within(args, &limits);
    }
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
    let seen = flip::mean(&picture, &reference).unwrap_or(f64::NAN);
    let (a, b) = (mean(&picture), mean(&reference));
    let mut out = String::new();
    let _ = writeln!(out, "mean          {:.6} {:.6} {:.6}", a[0], a[1], a[2]);
    let _ = writeln!(out, "reference     {:.6} {:.6} {:.6}", b[0], b[1], b[2]);
    let off = |i: usize| 100.0 * (a[i] - b[i]) / b[i].abs().max(1e-12);
    let _ = writeln!(out, "difference    {:+.4} % {:+.4} % {:+.4} %", off(0), off(1), off(2));
    let _ = writeln!(out, "relative MSE  {error:.6}");
    let _ = writeln!(out, "FLIP          {seen:.6}");
    let _ = writeln!(out, "worst tile    {:.3} % of 32 x 32 pixels from ({}, {})", 100.0 * tile.error, tile.x, tile.y);
    terminal::print(&out)
}

/// The limits that were asked for; what is left out of them limits nothing.
fn limits(args: &CompareArgs) -> Option<raster::Limits> {
    let CompareArgs { fail, fail_relative, fail_percent, allow_failures, hard_fail, .. } = *args;
    let any = [fail, fail_relative, fail_percent, hard_fail].iter().any(Option::is_some) || allow_failures.is_some();
    any.then(|| raster::Limits {
        fail: fail.unwrap_or(0.0),
        relative: fail_relative.unwrap_or(0.0),
        percent: fail_percent.unwrap_or(0.0),
        allowed: allow_failures.unwrap_or(0),
        hard: hard_fail.unwrap_or(f64::INFINITY),
    })
}

/// The mean of each channel over the values that are numbers.
fn means(picture: &raster::Raster) -> Vec<f64> {
    let channel = |c: usize| {
        let values = picture.data.iter().skip(c).step_by(picture.channels).map(|v| f64::from(*v));
        let (sum, count) = values.filter(|v| v.is_finite()).fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
        sum / f64::max(count, 1.0)
    };
    (0..picture.channels).map(channel).collect()
}

/// Compares value by value.
fn within(args: &CompareArgs, limits: &raster::Limits) -> Result<(), Error> {
    let (picture, reference) = (raster::read(&args.picture)?, raster::read(&args.reference)?);
    let Some(found) = raster::differences(&picture, &reference, limits) else {
        let shape = |r: &raster::Raster| format!("{} x {} pixels of {} channels", r.width, r.height, r.channels);
        return Err(Error::Compare(format!(
            "the pictures differ in shape: {} has {}, {} has {}",
            args.picture.display(),
            shape(&picture),
            args.reference.display(),
            shape(&reference)
        )));
    };
    let percent = 100.0 * found.pixels as f64 / (picture.width * picture.height).max(1) as f64;
    let (a, b) = (means(&picture), means(&reference));
    let off: Vec<String> =
        a.iter().zip(&b).map(|(a, b)| format!("{:+.3} %", 100.0 * (a - b) / b.abs().max(1e-12))).collect();
    terminal::print(&format!(
        "failing pixels      {} ({percent:.3} %)\nlargest difference  {:.6}\nmean difference     {:.6}\nof the means        {}\n",
        found.pixels,
        found.largest,
        found.mean,
        off.join(" ")
    ))?;
    if found.within { Ok(()) } else { Err(Error::Compare("the pictures differ by more than the limits".to_owned())) }
}
