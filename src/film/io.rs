//! Writing a film (atomically) and reading one back.

use super::{Film, Metadata, exr, png};
use crate::{Error, Result, scene::FilmSpec};
use std::{
    error::Error as StdError,
    fs::File,
    io::{BufReader, Seek, Write},
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
};

/// Largest number of pixels of an image that is read: 16,384 x 16,384. Checked against the header before anything
/// is allocated.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Largest number of values (pixels times channels) of an image that is read: 4 GiB as 32-bit floats.
pub const MAX_VALUES: u64 = 1 << 30;

/// What a decoder or encoder reports; the caller adds the file.
pub(super) type Failure = Box<dyn StdError + Send + Sync>;

/// Image formats by file name extension.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Exr,
    Png,
    Hdr,
}

impl Format {
    fn of(path: &Path, known: &[(&str, Self)], verb: &str) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        known.iter().find(|(name, _)| *name == extension).map(|(_, format)| *format).ok_or_else(|| {
            let names = known.iter().map(|(name, _)| format!(".{name}")).collect::<Vec<_>>().join(", ");
            Error::Usage(format!(
                "{}: cannot {verb} an image with the extension \"{extension}\"; known: {names}",
                path.display()
            ))
        })
    }

    fn to_write(path: &Path) -> Result<Self> {
        Self::of(path, &[("exr", Self::Exr), ("png", Self::Png)], "write")
    }

    fn to_read(path: &Path) -> Result<Self> {
        Self::of(path, &[("exr", Self::Exr), ("png", Self::Png), ("hdr", Self::Hdr)], "read")
    }
}

/// Writes `film` to `path`: all planes, linear, as EXR; or `R G B A` as 8-bit sRGB PNG through exposure and tone
/// mapping of `spec`. The file appears complete or not at all; an old one stays where writing fails.
///
/// # Errors
/// [`Error::Usage`] for an unknown extension, [`Error::Check`] for a film with missing planes, [`Error::Io`] if the
/// file cannot be written.
pub fn write(film: &Film, path: impl AsRef<Path>, meta: &Metadata, spec: &FilmSpec) -> Result<()> {
    let path = path.as_ref();
    let format = Format::to_write(path)?;
    film.validate()?;
    match format {
        Format::Exr => write_atomically(path, |file| exr::encode(film, file, meta)),
        Format::Png | Format::Hdr => {
            let pixels = film.premultiplied()?;
            write_atomically(path, |file| png::encode(film.width, film.height, &pixels, file, meta, spec))
        }
    }
}

/// Checks before a rendering that `path` can be written after it: known extension, existing folder, no folder or
/// device or write-protected file of that name, room on the disk for a few blocks. Leaves nothing behind.
///
/// # Errors
/// [`Error::Usage`] for an unknown extension, [`Error::Io`] for the rest.
pub fn check_writable(path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    Format::to_write(path)?;
    check_target(path)
}

/// [`check_writable`] for any file, not only images.
///
/// # Errors
/// [`Error::Io`].
pub fn check_target(path: &Path) -> Result<()> {
    let target = resolved(path)?;
    let mut file = temporary(&target).map_err(|e| Error::io(path, e))?;
    // 64 KiB find a full disk that would still take an empty file.
    file.write_all(&[0; 1 << 16])
        .and_then(|()| file.as_file().sync_all())
        .map_err(|e| Error::io(path, format!("cannot be written: {e}")))
}

/// Writes a file through a temporary one in the same folder: `write`, fsync, rename. The old file stays until the
/// new one is complete, and stays for good where anything fails. Works for any kind of file.
///
/// # Errors
/// [`Error::Io`] with the file and what failed.
pub fn write_atomically<F>(path: &Path, write: F) -> Result<()>
where
    F: FnOnce(&mut File) -> Result<(), Box<dyn StdError + Send + Sync>>,
{
    let target = resolved(path)?;
    let fail = |e: &dyn std::fmt::Display| Error::io(path, format!("cannot be written: {e}"));
    let mut file = temporary(&target).map_err(|e| fail(&e))?;
    write(file.as_file_mut()).map_err(|e| fail(&e))?;
    file.as_file().sync_all().map_err(|e| fail(&e))?;
    file.persist(&target).map_err(|e| fail(&e.error))?;
    // The rename itself is safe on disk once the folder is.
    #[cfg(unix)]
    if let Ok(folder) = File::open(folder_of(&target)) {
        folder.sync_all().ok();
    }
    Ok(())
}

/// The file to replace: links are followed, so that they stay links.
fn resolved(path: &Path) -> Result<PathBuf> {
    let fail = |reason: String| Err(Error::io(path, reason));
    if path.file_name().is_none() {
        return fail("is not a file name".into());
    }
    let Ok(meta) = std::fs::metadata(path) else {
        let folder = folder_of(path);
        if !folder.is_dir() {
            return fail(format!("the folder {} does not exist: create it first", folder.display()));
        }
        return Ok(path.to_owned());
    };
    if meta.is_dir() {
        return fail("is a folder, expected a file name".into());
    }
    if !meta.is_file() {
        return fail("is not a regular file: images are written to a temporary file and renamed".into());
    }
    if meta.permissions().readonly() {
        return fail("is write-protected: remove it, change its permissions or choose another name".into());
    }
    path.canonicalize().map_err(|e| Error::io(path, e))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// A unique temporary beside `target`, removed when dropped.
fn temporary(target: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pelage-").suffix(".part");
    // tempfile's own default is private to the user; the umask decides here as for any other output.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder_of(target))
}

/// Reads an image as a film: linear, premultiplied, at least `R G B A`.
///
/// * EXR: all channels of all parts; channels of a named part are called `part.channel` where there are several
///   parts. `Y` alone becomes grey. Half channels become planes without `full_precision`.
/// * PNG: sRGB is decoded, straight alpha becomes premultiplied.
/// * HDR (Radiance): RGBE.
///
/// A missing alpha is 1 everywhere.
///
/// # Errors
/// [`Error::Usage`] for an unknown extension; [`Error::Io`] with the file name for a missing, truncated or damaged
/// file, for one whose header claims more than [`MAX_PIXELS`] or [`MAX_VALUES`], and for what is not supported:
/// deep data, subsampled channels, a data window other than the display window, HDR orientations other than -Y +X.
pub fn read(path: impl AsRef<Path>) -> Result<Film> {
    let path = path.as_ref();
    let format = Format::to_read(path)?;
    decode(path, |input, bytes| match format {
        Format::Exr => exr::decode(input, bytes),
        Format::Png => png::decode(input),
        Format::Hdr => decode_hdr(input),
    })
}

/// Reads the `pelage.*` entries of a PNG or EXR file.
///
/// # Errors
/// As [`read`].
pub fn read_metadata(path: impl AsRef<Path>) -> Result<Metadata> {
    let path = path.as_ref();
    let format = Format::to_read(path)?;
    decode(path, |input, _| match format {
        Format::Exr => exr::decode_metadata(input),
        Format::Png => png::decode_metadata(input),
        Format::Hdr => Ok(Metadata::default()),
    })
}

/// Opens `path` and runs a decoder on it. A panic inside a decoder (they read untrusted bytes) becomes an error.
fn decode<T>(
    path: &Path,
    decoder: impl FnOnce(&mut BufReader<File>, u64) -> Result<T, Failure>,
) -> Result<T> {
    let file = File::open(path).map_err(|e| Error::io(path, format!("cannot be opened: {e}")))?;
    let meta = file.metadata().map_err(|e| Error::io(path, e))?;
    if !meta.is_file() {
        return Err(Error::io(path, "is not a regular file"));
    }
    let mut input = BufReader::new(file);
    match catch_unwind(AssertUnwindSafe(|| decoder(&mut input, meta.len()))) {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(e)) => {
            let at_end = input.stream_position().is_ok_and(|position| position >= meta.len());
            let hint = if at_end { " (the file ends early: is it complete?)" } else { "" };
            Err(Error::io(path, format!("cannot be read as an image: {e}{hint}")))
        }
        Err(_) => Err(Error::io(path, "cannot be read as an image: the decoder gave up on damaged data")),
    }
}

/// Refuses a header's size before anything of that size is allocated.
pub(super) fn check_size(width: u64, height: u64, channels: u64) -> Result<(), Failure> {
    if width == 0 || height == 0 {
        return Err(format!("the header says {width} x {height} pixels").into());
    }
    let pixels = width.saturating_mul(height);
    if width > u64::from(u32::MAX) || height > u64::from(u32::MAX) || pixels > MAX_PIXELS {
        return Err(format!(
            "the header says {width} x {height} pixels, more than the limit of {MAX_PIXELS} (16384 x 16384)"
        )
        .into());
    }
    if pixels.saturating_mul(channels) > MAX_VALUES {
        return Err(format!(
            "the header says {width} x {height} pixels of {channels} channels, more than the limit of {MAX_VALUES} values"
        )
        .into());
    }
    Ok(())
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
