//! Output to stdout, stderr and files.

use pelage::{Error, Result};
use pelage_core::files;
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// Prints to stdout. A closed pipe (`pelage schema | head`) is not an error.
pub(super) fn print(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("stdout", e)),
        _ => Ok(()),
    }
}

/// Prints the notes about meshes to stderr, unless `quiet`.
pub(super) fn print_notes<'a>(notes: impl IntoIterator<Item = &'a String>, quiet: bool) {
    if !quiet {
        notes.into_iter().for_each(|note| eprintln!("note: {note}"));
    }
}

/// A value as JSON; `name` is for the error.
pub(super) fn to_json(value: &impl Serialize, name: &str) -> Result<serde_json::Value> {
    serde_json::to_value(value)
        .map_err(|e| Error::Encoding(format!("the {name} cannot be written as JSON: {e}")))
}

/// Prints a JSON value to stdout.
pub(super) fn print_json(value: &serde_json::Value) -> Result<()> {
    print(&format!("{value:#}\n"))
}

/// Writes a JSON file, whole or not at all.
pub(super) fn write_json(path: &Path, value: &serde_json::Value) -> Result<()> {
    files::write_buffered(path, |out| Ok(writeln!(out, "{value:#}")?))
}

/// The arguments of this process.
pub(super) fn command_line() -> Vec<String> {
    std::env::args_os().map(|a| a.to_string_lossy().into_owned()).collect()
}

/// A number of bytes in the largest unit of which there is at least one.
pub(super) fn human_bytes(bytes: u64) -> String {
    let units = [("GiB", 30), ("MiB", 20), ("KiB", 10)];
    match units.iter().find(|(_, shift)| bytes >= 1 << shift) {
        Some((unit, shift)) => format!("{:.1} {unit}", bytes as f64 / (1_u64 << shift) as f64),
        None => format!("{bytes} B"),
    }
}

/// A count with thousands separators.
pub(super) fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(c);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_thousands_separators() {
        assert_eq!(count(0), "0");
        assert_eq!(count(999), "999");
        assert_eq!(count(82_432), "82,432");
        assert_eq!(count(1_234_567), "1,234,567");
    }
}
