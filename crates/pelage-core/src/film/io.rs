//! Writes films (atomically) and reads them back.

use super::formats::{Format, decode_hdr, decode_other, ends_early};
use super::limits::Texels;
pub use super::limits::{MAX_PIXELS, MAX_VALUES};
use super::{Film, Metadata, exr, png};
use crate::files::{Failure, check_target, write_atomically, write_buffered};
use crate::scene::FilmSpec;
use crate::{Error, Result};
use std::{
    fs::File,
    io::BufReader,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

fn wrong_usage(path: &Path, message: &str) -> Error {
    Error::Usage(format!("{}: {message}", path.display()))
}

/// Writes `film` to `path`: all planes, linear, in the colour space of `spec`, as EXR; or `R G B A`
/// as 8-bit sRGB PNG through exposure and tone mapping of `spec`. The file appears complete or not
/// at all; an old one stays if writing fails.
///
/// # Errors
/// [`Error::Usage`] for an unknown extension, [`Error::Unsupported`] for a film with missing
/// planes, [`Error::Io`] if the file cannot be written.
pub fn write(film: &Film, path: impl AsRef<Path>, meta: &Metadata, spec: &FilmSpec) -> Result<()> {
    let path = path.as_ref();
    let format = Format::to_write(path).map_err(|m| wrong_usage(path, &m))?;
    film.validate()?;
    match format {
        Format::Exr => write_atomically(path, |file| exr::encode(film, file, meta, spec.color_space)),
        _ => {
            let pixels = film.premultiplied()?;
            write_buffered(path, |out| png::encode(film.width, film.height, &pixels, out, meta, spec))
        }
    }
}

/// Checks before a rendering that `path` can be written after it: its extension is known, and as
/// [`crate::files::check_target`]. Leaves nothing behind.
///
/// # Errors
/// [`Error::Usage`] for an unknown extension, [`Error::Io`] for the rest.
pub fn check_writable(path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    Format::to_write(path).map_err(|m| wrong_usage(path, &m))?;
    check_target(path)
}

/// Reads an image as a film: linear, premultiplied, at least `R G B A`. The format is recognised by
/// the first bytes of the file; where they say nothing, by its extension.
///
/// * EXR: all channels of all parts; channels of a named part are called `part.channel` where there
///   are several parts. `Y` alone becomes grey. Without R, G, B and Y, the first layer with such
///   channels is taken. Half channels become planes without `full_precision`.
/// * PNG: decoded from sRGB or as its cICP, sRGB or gAMA chunk says; straight alpha becomes
///   premultiplied.
/// * HDR (Radiance): RGBE.
/// * JPEG, TIFF, TGA, BMP and WebP: decoded from sRGB; TIFF with floats is linear.
///
/// A missing alpha is 1 everywhere. Colours of an EXR file that names other primaries than those of
/// Rec. 709 are converted, with a note.
///
/// # Errors
/// [`Error::Usage`] for an unknown format; [`Error::Io`] with the file name for a missing,
/// truncated or damaged file, for one whose header claims more than [`MAX_PIXELS`] or
/// [`MAX_VALUES`], and for what is not supported: deep data, subsampled channels, a data window
/// other than the display window, HDR orientations other than -Y +X.
pub fn read(path: impl AsRef<Path>) -> Result<Film> {
    read_noting(path, &mut Vec::new())
}

/// [`read`], which adds what was changed to `notes`.
///
/// # Errors
/// As [`read`].
pub fn read_noting(path: impl AsRef<Path>, notes: &mut Vec<String>) -> Result<Film> {
    let path = path.as_ref();
    let format = Format::to_read(path).map_err(|m| wrong_usage(path, &m))?;
    read_format(path, format, "", true, notes)
}

fn read_format(
    path: &Path,
    format: Format,
    layer: &str,
    color: bool,
    notes: &mut Vec<String>,
) -> Result<Film> {
    if format != Format::Exr && !layer.is_empty() {
        let found = format!("found layer = \"{layer}\", but only OpenEXR images have layers: leave it out");
        return Err(Error::io(path, found));
    }
    let mut found = Vec::new();
    let film = decode(path, |input, bytes| match format {
        Format::Exr => exr::decode(input, bytes, layer, color, &mut found),
        Format::Png => png::decode(input),
        Format::Hdr => decode_hdr(input),
        Format::Other(kind) => Ok(png::premultiplied(decode_other(input, kind, true)?)),
    })?;
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    notes.extend(found.into_iter().map(|note| match note.strip_prefix("warning: ") {
        Some(rest) => format!("warning: {name}: {rest}"),
        None => format!("{name}: {note}"),
    }));
    Ok(film)
}

/// [`read`] for an image that a scene names. `R G B A` are those of `layer`; where it is empty, of
/// the first layer that has them. Adds what was changed to `notes`.
///
/// # Errors
/// [`Error::Scene`] where [`read`] fails, and for a layer that the image does not have.
pub(crate) fn read_asset(path: &Path, layer: &str, notes: &mut Vec<String>) -> Result<Film> {
    asset(path, layer, true, notes)
}

fn asset(path: &Path, layer: &str, color: bool, notes: &mut Vec<String>) -> Result<Film> {
    let format = Format::to_read(path).map_err(|m| Error::fault(path, m))?;
    read_format(path, format, layer, color, notes).map_err(as_scene_fault)
}

fn as_scene_fault(error: Error) -> Error {
    match error {
        Error::Io { path, reason } => Error::fault(path, reason),
        other => other,
    }
}

/// Reads an image that a scene names, with straight alpha. As a `color`, formats of integers are
/// decoded to linear, other primaries are converted and premultiplied formats are divided by alpha;
/// otherwise the values are as the file has them, integers scaled to 0..1.
///
/// # Errors
/// As [`read_asset`].
pub(crate) fn read_texels(path: &Path, layer: &str, color: bool, notes: &mut Vec<String>) -> Result<Texels> {
    let format = Format::to_read(path);
    match format {
        Ok(Format::Png) if layer.is_empty() => {
            return decode(path, |input, _| png::decode_texels(input, color)).map_err(as_scene_fault);
        }
        Ok(Format::Other(kind)) if layer.is_empty() => {
            return decode(path, |input, _| decode_other(input, kind, color)).map_err(as_scene_fault);
        }
        _ => {}
    }
    let film = asset(path, layer, color, notes)?;
    let mut texels = film.premultiplied()?;
    if color {
        for [rgb @ .., alpha] in texels.iter_mut().filter(|t| t[3] > 0.0) {
            rgb.iter_mut().for_each(|v| *v /= *alpha);
        }
    }
    Ok((film.width, film.height, texels))
}

/// Reads the `pelage.*` entries of a PNG or EXR file, and an EXR file's attributes of Cryptomatte.
///
/// # Errors
/// As [`read`].
pub fn read_metadata(path: impl AsRef<Path>) -> Result<Metadata> {
    let path = path.as_ref();
    let format = Format::to_read(path).map_err(|m| wrong_usage(path, &m))?;
    decode(path, |input, _| match format {
        Format::Exr => exr::decode_metadata(input),
        Format::Png => png::decode_metadata(input),
        _ => Ok(Metadata::default()),
    })
}

/// Opens `path` and runs a decoder on it. Decoders read untrusted bytes: a panic inside one becomes
/// an error.
fn decode<T>(
    path: &Path,
    decoder: impl FnOnce(&mut BufReader<File>, u64) -> Result<T, Failure>,
) -> Result<T> {
    let file = File::open(path).map_err(|e| Error::io(path, format!("cannot be opened: {e}")))?;
    let meta = file.metadata().map_err(|e| Error::io(path, e))?;
    if !meta.is_file() {
        return Err(Error::io(path, "is not a regular file, expected an image"));
    }
    let mut input = BufReader::new(file);
    match catch_unwind(AssertUnwindSafe(|| decoder(&mut input, meta.len()))) {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(e)) => {
            let hint = if ends_early(&*e) { " (the file ends early: is it complete?)" } else { "" };
            Err(Error::io(path, format!("cannot be read as an image: {e}{hint}")))
        }
        Err(_) => Err(Error::io(path, "cannot be read as an image: the decoder failed on damaged data")),
    }
}
