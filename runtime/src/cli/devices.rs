//! `oslcl devices`: the OpenCL devices with the numbers that `--device` takes.

use super::{Error, terminal};
use oslcl_runtime::device::{self, DeviceKind};
use std::fmt::Write;

/// Prints the list.
pub fn run() -> Result<(), Error> {
    let mut text = String::new();
    for (number, device) in device::list()?.iter().enumerate() {
        let kind = match device.kind {
            DeviceKind::Cpu => "CPU",
            DeviceKind::Gpu => "GPU",
            DeviceKind::Other => "other",
        };
        let doubles = if device.double { "64-bit floats" } else { "no 64-bit floats" };
        let gib = device.memory as f64 / f64::from(1 << 30);
        let _ = writeln!(text, "{number}: {}", device.name);
        let _ = writeln!(text, "   {kind}, {} compute units, {gib:.1} GiB, {doubles}", device.units);
        let _ = writeln!(text, "   {}, {}, driver {}", device.platform, device.version, device.driver);
    }
    terminal::print(&text)
}
