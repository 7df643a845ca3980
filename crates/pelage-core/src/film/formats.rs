//! Image formats: how they are recognised, and decoders of those that are only read.

use super::{
    Film,
    limits::{Texels, check_size},
    png,
    tonemap::srgb_decode,
};
use crate::files::Failure;
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageError, ImageFormat};
use rayon::prelude::*;
use std::{
    error::Error as StdError,
    fs::File,
    io::{self, BufRead, BufReader, Cursor, Read, Seek},
    path::Path,
};

/// Image formats.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Exr,
    Png,
    Hdr,
    /// One that is only read, through the image crate.
    Other(ImageFormat),
}

/// Extensions of the formats that are read.
const READ: [(&str, Format); 12] = [
    ("exr", Format::Exr),
    ("png", Format::Png),
    ("hdr", Format::Hdr),
    ("pic", Format::Hdr),
    ("jpg", Format::Other(ImageFormat::Jpeg)),
    ("jpeg", Format::Other(ImageFormat::Jpeg)),
    ("tif", Format::Other(ImageFormat::Tiff)),
    ("tiff", Format::Other(ImageFormat::Tiff)),
    ("tga", Format::Other(ImageFormat::Tga)),
    ("bmp", Format::Other(ImageFormat::Bmp)),
    ("webp", Format::Other(ImageFormat::WebP)),
    ("tx", Format::Other(ImageFormat::Tiff)),
];

/// First bytes of the formats; Targa has none.
const MAGIC: [(&[u8], Format); 7] = [
    (b"\x76\x2f\x31\x01", Format::Exr),
    (b"\x89PNG\r\n\x1a\n", Format::Png),
    (b"#?", Format::Hdr),
    (b"\xff\xd8\xff", Format::Other(ImageFormat::Jpeg)),
    (b"II*\0", Format::Other(ImageFormat::Tiff)),
    (b"MM\0*", Format::Other(ImageFormat::Tiff)),
    (b"BM", Format::Other(ImageFormat::Bmp)),
];

impl Format {
    fn of(path: &Path, known: &[(&str, Self)], verb: &str) -> Result<Self, String> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        known.iter().find(|(name, _)| *name == extension).map(|(_, format)| *format).ok_or_else(|| {
            let names = known.iter().map(|(name, _)| format!(".{name}")).collect::<Vec<_>>().join(", ");
            format!("cannot {verb} an image with the extension \"{extension}\", expected {names}")
        })
    }

    /// By extension.
    pub(super) fn to_write(path: &Path) -> Result<Self, String> {
        Self::of(path, &[("exr", Self::Exr), ("png", Self::Png)], "write")
    }

    /// By the first bytes of the file; by extension where they are those of no format, or where the
    /// file cannot be opened.
    pub(super) fn to_read(path: &Path) -> Result<Self, String> {
        let mut first = Vec::new();
        let regular = path.metadata().is_ok_and(|meta| meta.is_file());
        if regular && let Ok(file) = File::open(path) {
            // What cannot be read here is reported by the decoder.
            let _ = file.take(12).read_to_end(&mut first);
        }
        if first.starts_with(b"RIFF") && first.ends_with(b"WEBP") {
            return Ok(Self::Other(ImageFormat::WebP));
        }
        match MAGIC.iter().find(|(magic, _)| first.starts_with(magic)) {
            Some((_, format)) => Ok(*format),
            None => Self::of(path, &READ, "read"),
        }
    }
}

/// Whether a decoder failed because it asked for bytes after the end of the file.
pub(super) fn ends_early(error: &(dyn StdError + 'static)) -> bool {
    if let Some(ImageError::IoError(e)) = error.downcast_ref() {
        return e.kind() == io::ErrorKind::UnexpectedEof;
    }
    if let Some(exr::error::Error::Io(e)) = error.downcast_ref() {
        return e.kind() == io::ErrorKind::UnexpectedEof;
    }
    if let Some(exr::error::Error::Invalid(text)) = error.downcast_ref() {
        // The crate turns this kind of error into a text.
        return text == "reference to missing bytes" || text.contains("unexpected end of file");
    }
    if let Some(e) = error.downcast_ref::<io::Error>() {
        return e.kind() == io::ErrorKind::UnexpectedEof;
    }
    error.source().is_some_and(ends_early)
}

/// Largest header of a Radiance file, bytes.
const HDR_HEADER: u64 = 1 << 16;

/// Decodes Radiance RGBE.
pub(super) fn decode_hdr(input: &mut BufReader<File>) -> Result<Film, Failure> {
    use image::codecs::hdr::HdrDecoder;
    let header = hdr_header(input)?;
    let mut decoder = HdrDecoder::new(Cursor::new(header).chain(input))?;
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

/// Reads the header of a Radiance file, with any signature (`#?RGBE` is written too) and any line
/// ends, and returns it as the decoder expects it: its size and orientation alone.
fn hdr_header(input: &mut BufReader<File>) -> Result<Vec<u8>, Failure> {
    let mut limited = (&mut *input).take(HDR_HEADER);
    let mut line = || -> Result<String, Failure> {
        let mut bytes = Vec::new();
        limited.read_until(b'\n', &mut bytes)?;
        if bytes.pop() != Some(b'\n') {
            return Err(io::Error::new(
                io::ErrorKind::UnexpectedEof,
                "found no end of the header of a Radiance image",
            )
            .into());
        }
        Ok(String::from_utf8_lossy(&bytes).trim_end_matches('\r').to_owned())
    };
    let signature = line()?;
    if !signature.starts_with("#?") {
        return Err("found no signature of a Radiance image, expected #?RADIANCE or #?RGBE".into());
    }
    loop {
        let text = line()?;
        if text.is_empty() {
            break;
        }
        if let Some(format) = text.strip_prefix("FORMAT=").filter(|f| f.trim() != "32-bit_rle_rgbe") {
            return Err(format!("found FORMAT={format}, expected 32-bit_rle_rgbe: save it as RGB").into());
        }
    }
    let size = line()?;
    Ok(format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes())
}

/// Decodes a format of the image crate to texels with straight alpha; colours, unless they are
/// floats, from sRGB.
pub(super) fn decode_other(
    input: &mut BufReader<File>,
    kind: ImageFormat,
    color: bool,
) -> Result<Texels, Failure> {
    input.rewind()?;
    let mut reader = image::ImageReader::with_format(input, kind);
    reader.limits(png::limits());
    let mut decoder = reader.into_decoder()?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into(), 4)?;
    let stored = decoder.original_color_type();
    if matches!(stored, ExtendedColorType::Cmyk8 | ExtendedColorType::Cmyk16) {
        return Err("found CMYK colours, expected RGB or grey: convert the image to RGB".into());
    }
    let orientation = decoder.orientation()?;
    let mut image = DynamicImage::from_decoder(decoder)?;
    image.apply_orientation(orientation);
    let (width, height) = (image.width(), image.height());
    let float = matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let pixels = image.into_rgba32f();
    let linear = |v: f32| if color && !float { srgb_decode(v) } else { v };
    let texels = pixels.as_raw().par_chunks(4).map(|p| [linear(p[0]), linear(p[1]), linear(p[2]), p[3]]);
    Ok((width, height, texels.collect()))
}
