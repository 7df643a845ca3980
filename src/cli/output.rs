//! Output to stdout, stderr and files.

use pelage::film::Film;
use pelage::render::Stats;
use pelage::{Error, Result, World};
use pelage_core::files;
use pelage_fur::extent::{self, Extent};
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

/// Warns on stderr of what is missing in a picture because the adapter ended loops early.
pub(super) fn warn_of_cuts(stats: &Stats) {
    if stats.fragments_unread > 0 || stats.rays_cut > 0 {
        eprintln!(
            "warning: {} of {} fragments were not read, and {} rays not finished: the adapter {} ends loops \
             of too many rounds. Parts of the fur are missing; use more samples per pixel (--spp), which \
             makes the lists shorter, or fewer virtual fragments",
            stats.fragments_unread, stats.fragments, stats.rays_cut, stats.adapter
        );
    }
}

/// Prints notes to stderr, unless `quiet`.
pub(super) fn print_notes(notes: &[String], quiet: bool) {
    if !quiet {
        let word = |note: &str| if note.starts_with("warning: ") { "" } else { "note: " };
        notes.iter().for_each(|note| eprintln!("{}{note}", word(note)));
    }
}

/// Checks that a world's fur is not absurdly large, and adds what looks like a mistake in its units
/// or its view to its notes, which are printed unless `quiet`. `strands`: the guard hairs
/// will grow one by one.
///
/// # Errors
/// [`Error::Scene`] if there would be too many hairs.
pub(super) fn admit(world: &mut World, strands: bool, quiet: bool) -> Result<()> {
    let mut notes = Extent::of(world).check(strands)?;
    notes.extend(extent::notes_of_view(world));
    world.notes.append(&mut notes);
    print_notes(&world.notes, quiet);
    Ok(())
}

/// Prints why a finished picture, before its background, is empty or black, unless `quiet`.
///
/// # Errors
/// [`Error::Unsupported`] if the film lacks a plane.
pub(super) fn print_notes_of_film(film: &Film, world: &World, quiet: bool) -> Result<()> {
    let pixels = film.premultiplied()?;
    if quiet {
        return Ok(());
    }
    if pixels.iter().all(|[.., a]| *a == 0.0) {
        eprintln!(
            "note: the picture is empty: no part of the skin or the fur is in it; see camera.eye, camera.target and \
             --cropwindow"
        );
    } else if pixels.iter().all(|[r, g, b, _]| *r == 0.0 && *g == 0.0 && *b == 0.0) {
        let light: f32 = world.lights.iter().map(|l| l.irradiance.element_sum()).sum();
        let why = if light > 0.0 {
            "no light reaches what is seen; see the directions of [[lights]], and base.color"
        } else {
            "there is no light; add [[lights]] or an [environment]"
        };
        eprintln!("note: the picture is black: {why}");
    }
    Ok(())
}

/// Warns on stderr of pixels that are brighter than half floats can be.
pub(super) fn warn_of_cut_pixels(film: &Film) {
    let n = film.cut_pixels();
    if n > 0 {
        eprintln!(
            "warning: {} of {} pixels are cut at 65504, the largest half float: divide all lights by the same factor \
             and raise film.exposure by its stops",
            count(n as u64),
            count(film.pixels() as u64)
        );
    }
}

/// An exposure as text: `+1.25 stops`.
pub(super) fn stops(exposure: f32) -> String {
    format!("{exposure:+.2} stops")
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
