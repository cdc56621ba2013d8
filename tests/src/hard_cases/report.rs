//! The table of what the hard cases measured: docs/reports/stability.md, or wherever OSLCL_REPORT says.
//!
//! In: rows. Out: a Markdown file with a table per device. Rows that it has already and that are not measured anew stay, so that
//! several test programs write one report, and devices of several machines stand in one. It must not know what the cases are.

use super::Row;
use oslcl_runtime::precision::Precision;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

const HEAD: &str = "# What the hard cases measure\n\n\
    Written by `make hard-cases` (tests/tests/hard_cases_*.rs); do not edit. Each row is one measured number and the bound that the\n\
    test holds it to, in the three precisions. How each is kept: [numerics.md](../numerics.md). The same in\n\
    other renderers: [stability-peers.md](stability-peers.md).\n";

/// Of one device: by group and case, the bounds and the numbers as they stand in the table.
type Table = BTreeMap<(String, String), [String; 4]>;

/// The precisions in the order of the columns.
fn column(precision: Precision) -> usize {
    match precision {
        Precision::Standard => 1,
        Precision::Fast => 2,
        Precision::Reference => 3,
    }
}

/// A number with as many digits as say something.
pub fn number(x: f64) -> String {
    if x == x.trunc() && x.abs() < 1e6 { format!("{x}") } else { format!("{x:.2e}") }
}

/// Where the report goes; `None`: nobody asked. A relative path counts from the repository's root, whatever the test's folder is.
fn target() -> Option<PathBuf> {
    let path = std::env::var_os("OSLCL_REPORT").filter(|p| !p.is_empty())?;
    Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path))
}

fn parse(text: &str) -> BTreeMap<String, Table> {
    let mut devices: BTreeMap<String, Table> = BTreeMap::new();
    let mut device = String::new();
    for line in text.lines() {
        if let Some(name) = line.strip_prefix("## ") {
            device = name.to_owned();
        }
        let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        if let [group, case, bound, a, b, c] = cells[..]
            && group != "group"
        {
            let row = [bound, a, b, c].map(str::to_owned);
            devices.entry(device.clone()).or_default().insert((group.to_owned(), case.to_owned()), row);
        }
    }
    devices
}

fn print(devices: &BTreeMap<String, Table>) -> String {
    let mut out = HEAD.to_owned();
    for (device, table) in devices {
        let _ = write!(
            out,
            "\n## {device}\n\n| group | case | bound | standard | fast | f64 |\n|---|---|---|---|---|---|\n"
        );
        for ((group, case), row) in table {
            let _ = writeln!(out, "| {group} | {case} | {} |", row.join(" | "));
        }
    }
    out
}

/// Puts rows into the report, if one is asked for.
pub fn write(rows: &[Row]) -> std::io::Result<()> {
    // Tests of one program run at the same time.
    static WRITING: Mutex<()> = Mutex::new(());
    let Some(path) = target() else { return Ok(()) };
    let _writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut devices = parse(&std::fs::read_to_string(&path).unwrap_or_default());
    for row in rows {
        let table = devices.entry(row.device.clone()).or_default();
        let cells = table
            .entry((row.group.clone(), row.case.clone()))
            .or_insert_with(|| ["", "-", "-", "-"].map(str::to_owned));
        // Bounds may differ by precision: those of the table are in the order of the columns.
        let mut bounds: Vec<String> = cells[0].split(", ").map(str::to_owned).collect();
        bounds.resize(3, bounds.last().cloned().unwrap_or_default());
        let at = column(row.precision);
        bounds[at - 1] = row.bound.clone();
        bounds.iter_mut().filter(|b| b.is_empty()).for_each(|b| *b = row.bound.clone());
        cells[0] = if bounds.iter().all(|b| *b == bounds[0]) { bounds[0].clone() } else { bounds.join(", ") };
        cells[at] = number(row.measured);
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(path, print(&devices))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_read_back_as_it_was_written() {
        let row = ["0", "0", "3", "1.50e-7"].map(str::to_owned);
        let table = Table::from([(("geometry".to_owned(), "edges: leaks".to_owned()), row)]);
        let devices = BTreeMap::from([("a device (of 2 cores)".to_owned(), table)]);
        assert_eq!(parse(&print(&devices)), devices);
        assert_eq!((number(3.0), number(1.5e-7)), ("3".to_owned(), "1.50e-7".to_owned()));
    }
}
