//! Writes films (atomically) and reads them back.

pub use super::limits::{MAX_PIXELS, MAX_VALUES};
use super::limits::{Texels, check_size};
use super::{Film, Metadata, exr, png};
use crate::files::{Failure, check_target, write_atomically, write_buffered};
use crate::scene::FilmSpec;
use crate::{Error, Result};
use std::{
    fs::File,
    io::{BufReader, Seek},
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

/// Image formats by file name extension.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Exr,
    Png,
    Hdr,
}

impl Format {
    fn of(path: &Path, known: &[(&str, Self)], verb: &str) -> Result<Self, String> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        known.iter().find(|(name, _)| *name == extension).map(|(_, format)| *format).ok_or_else(|| {
            let names = known.iter().map(|(name, _)| format!(".{name}")).collect::<Vec<_>>().join(", ");
            format!("cannot {verb} an image with the extension \"{extension}\", expected {names}")
        })
    }

    fn to_write(path: &Path) -> Result<Self> {
        Self::of(path, &[("exr", Self::Exr), ("png", Self::Png)], "write").map_err(|m| wrong_usage(path, &m))
    }

    fn to_read(path: &Path) -> Result<Self, String> {
        Self::of(path, &[("exr", Self::Exr), ("png", Self::Png), ("hdr", Self::Hdr)], "read")
    }
}

fn wrong_usage(path: &Path, message: &str) -> Error {
    Error::Usage(format!("{}: {message}", path.display()))
}

/// Writes `film` to `path`: all planes, linear, as EXR; or `R G B A` as 8-bit sRGB PNG through
/// exposure and tone mapping of `spec`. The file appears complete or not at all; an old one stays
/// if writing fails.
///
/// # Errors
/// [`Error::Usage`] for an unknown extension, [`Error::Unsupported`] for a film with missing
/// planes, [`Error::Io`] if the file cannot be written.
pub fn write(film: &Film, path: impl AsRef<Path>, meta: &Metadata, spec: &FilmSpec) -> Result<()> {
    let path = path.as_ref();
    let format = Format::to_write(path)?;
    film.validate()?;
    match format {
        Format::Exr => write_atomically(path, |file| exr::encode(film, file, meta)),
        Format::Png | Format::Hdr => {
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
    Format::to_write(path)?;
    check_target(path)
}

/// Reads an image as a film: linear, premultiplied, at least `R G B A`.
///
/// * EXR: all channels of all parts; channels of a named part are called `part.channel` where there
///   are several parts. `Y` alone becomes grey. Half channels become planes without
///   `full_precision`.
/// * PNG: sRGB is decoded, straight alpha becomes premultiplied.
/// * HDR (Radiance): RGBE.
///
/// A missing alpha is 1 everywhere.
///
/// # Errors
/// [`Error::Usage`] for an unknown extension; [`Error::Io`] with the file name for a missing,
/// truncated or damaged file, for one whose header claims more than [`MAX_PIXELS`] or
/// [`MAX_VALUES`], and for what is not supported: deep data, subsampled channels, a data window
/// other than the display window, HDR orientations other than -Y +X.
pub fn read(path: impl AsRef<Path>) -> Result<Film> {
    let path = path.as_ref();
    let format = Format::to_read(path).map_err(|m| wrong_usage(path, &m))?;
    read_format(path, format)
}

fn read_format(path: &Path, format: Format) -> Result<Film> {
    decode(path, |input, bytes| match format {
        Format::Exr => exr::decode(input, bytes),
        Format::Png => png::decode(input),
        Format::Hdr => decode_hdr(input),
    })
}

/// [`read`] for an image that a scene names.
///
/// # Errors
/// [`Error::Scene`] where [`read`] fails.
pub(crate) fn read_asset(path: &Path) -> Result<Film> {
    let format = Format::to_read(path).map_err(|m| Error::fault(path, m))?;
    read_format(path, format).map_err(as_scene_fault)
}

fn as_scene_fault(error: Error) -> Error {
    match error {
        Error::Io { path, reason } => Error::fault(path, reason),
        other => other,
    }
}

/// Reads an image that a scene names, with straight alpha. As a `color`, a PNG is decoded from sRGB
/// and premultiplied formats are divided by alpha; otherwise the values are as the file has them,
/// those of a PNG scaled to 0..1.
///
/// # Errors
/// As [`read_asset`].
pub(crate) fn read_texels(path: &Path, color: bool) -> Result<Texels> {
    if Format::to_read(path) == Ok(Format::Png) {
        return decode(path, |input, _| png::decode_texels(input, color)).map_err(as_scene_fault);
    }
    let film = read_asset(path)?;
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
        Format::Hdr => Ok(Metadata::default()),
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
            let at_end = input.stream_position().is_ok_and(|position| position >= meta.len());
            let hint = if at_end { " (the file ends early: is it complete?)" } else { "" };
            Err(Error::io(path, format!("cannot be read as an image: {e}{hint}")))
        }
        Err(_) => Err(Error::io(path, "cannot be read as an image: the decoder failed on damaged data")),
    }
}

/// Decodes Radiance RGBE.
fn decode_hdr(input: &mut BufReader<File>) -> Result<Film, Failure> {
    use image::{ImageDecoder, codecs::hdr::HdrDecoder};
    let mut decoder = HdrDecoder::new(input)?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into(), 4)?;
    decoder.set_limits(png::limits())?;
    let mut bytes = vec![0; usize::try_from(decoder.total_bytes())?];
    decoder.read_image(&mut bytes)?;
    let mut film = Film::new(width, height);
    for (c, plane) in film.planes.iter_mut().enumerate() {
        // Radiance values may lie outside the range of half.
        plane.full_precision = true;
        match c {
            3 => plane.data.fill(1.0),
            _ => plane.data.iter_mut().zip(bytes.chunks_exact(12)).for_each(|(to, rgb)| {
                *to = f32::from_ne_bytes([rgb[4 * c], rgb[4 * c + 1], rgb[4 * c + 2], rgb[4 * c + 3]]);
            }),
        }
    }
    Ok(film)
}
