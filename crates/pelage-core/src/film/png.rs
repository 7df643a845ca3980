//! PNG: 8-bit sRGB with text chunks.

use super::{
    Film, Metadata,
    limits::{MAX_PIXELS, Texels, check_size},
    tonemap::{clamped, display_rgb8, srgb_decode},
};
use crate::files::Failure;
use crate::scene::FilmSpec;
use ::png::text_metadata::ITXtChunk;
use glam::Vec3;
use rayon::prelude::*;
use std::{
    fs::File,
    io::{BufReader, Seek, Write},
};

/// Prefix of the metadata's keys in a file.
const PREFIX: &str = "pelage.";

/// Encodes premultiplied linear pixels: straight colour through exposure, tone mapping and sRGB,
/// with straight alpha, which is left out if it is 1 everywhere.
pub(super) fn encode(
    width: u32,
    height: u32,
    premultiplied: &[[f32; 4]],
    out: &mut impl Write,
    meta: &Metadata,
    spec: &FilmSpec,
) -> Result<(), Failure> {
    let opaque = premultiplied.iter().all(|p| p[3] >= 1.0);
    let channels = if opaque { 3 } else { 4 };
    let mut bytes = vec![0u8; premultiplied.len() * channels];
    bytes.par_chunks_mut(channels).zip(premultiplied).for_each(|(to, &[r, g, b, a])| {
        let alpha = clamped(a, 1.0);
        // Colour without coverage (a glow) has no straight form: it is dropped.
        let straight = if alpha > 0.0 { Vec3::new(r, g, b) / alpha } else { Vec3::ZERO };
        to[..3].copy_from_slice(&display_rgb8(straight, spec));
        if let Some(to) = to.get_mut(3) {
            *to = (alpha * 255.0).round() as u8;
        }
    });

    let mut encoder = ::png::Encoder::new(out, width, height);
    encoder.set_color(if opaque { ::png::ColorType::Rgb } else { ::png::ColorType::Rgba });
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_source_srgb(::png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    let tone = format!("{:?} exposure {}", spec.tonemap, spec.exposure).to_lowercase();
    let software = concat!("pelage ", env!("CARGO_PKG_VERSION")).to_owned();
    let own = [("Software".to_owned(), software), (format!("{PREFIX}tonemap"), tone)];
    let given = meta.entries.iter().map(|(key, value)| (format!("{PREFIX}{key}"), value.clone()));
    for (key, value) in own.into_iter().chain(given) {
        let mut chunk = ITXtChunk::new(key, value.replace('\0', " "));
        chunk.compressed = value.len() > 1024;
        writer.write_text_chunk(&chunk)?;
    }
    writer.write_image_data(&bytes)?;
    Ok(writer.finish()?)
}

/// Limit of the memory that `image` may allocate, bytes: that of the largest image that is read,
/// with 16 bits per channel.
pub(super) fn limits() -> image::Limits {
    let mut limits = image::Limits::no_limits();
    limits.max_alloc = Some(MAX_PIXELS * 16 + (64 << 20));
    limits
}

/// How the samples of a PNG become linear.
#[derive(Clone, Copy)]
enum Transfer {
    Srgb,
    Power(f32),
    /// Of ITU-R BT.709: the inverse of its opto-electronic transfer function.
    Rec709,
}

impl Transfer {
    /// By precedence: cICP, sRGB, gAMA; without any, sRGB.
    fn of(input: &mut BufReader<File>) -> Result<Self, Failure> {
        let mut decoder = ::png::Decoder::new(&mut *input);
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        let reader = decoder.read_info()?;
        let info = reader.info();
        let found = match (info.coding_independent_code_points, info.srgb, info.gama_chunk) {
            (Some(code), ..) => match code.transfer_function {
                1 | 6 | 14 | 15 => Self::Rec709,
                4 => Self::Power(2.2),
                5 => Self::Power(2.8),
                8 => Self::Power(1.0),
                13 => Self::Srgb,
                other => {
                    return Err(format!(
                        "found the transfer function {other} in its cICP chunk, which is not supported: \
                         save it as sRGB or linear"
                    )
                    .into());
                }
            },
            (None, Some(_), _) | (None, None, None) => Self::Srgb,
            (None, None, Some(gamma)) => match gamma.into_scaled() {
                // What programs write that mean sRGB.
                45454..=45456 => Self::Srgb,
                0 => return Err("found a gAMA chunk of 0, expected a positive number".into()),
                scaled => Self::Power((100_000.0 / f64::from(scaled)) as f32),
            },
        };
        input.rewind()?;
        Ok(found)
    }

    fn linear(self, v: f32) -> f32 {
        match self {
            Self::Srgb => srgb_decode(v),
            Self::Power(1.0) => v,
            Self::Power(exponent) => v.powf(exponent),
            Self::Rec709 if v < 0.081 => v / 4.5,
            Self::Rec709 => ((v + 0.099) / 1.099).powf(1.0 / 0.45),
        }
    }
}

/// Decodes a PNG of any colour type to texels with straight alpha; colours, if it holds any, to
/// linear.
pub(super) fn decode_texels(input: &mut BufReader<File>, color: bool) -> Result<Texels, Failure> {
    use image::{DynamicImage, ImageDecoder, codecs::png::PngDecoder};
    let transfer = if color { Transfer::of(input)? } else { Transfer::Power(1.0) };
    let decoder = PngDecoder::with_limits(input, limits())?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into(), 4)?;
    let pixels = DynamicImage::from_decoder(decoder)?.into_rgba32f();
    let linear = |v: f32| transfer.linear(v);
    let texels = pixels.as_raw().par_chunks(4).map(|p| [linear(p[0]), linear(p[1]), linear(p[2]), p[3]]);
    Ok((width, height, texels.collect()))
}

/// Decodes a PNG to premultiplied linear planes.
pub(super) fn decode(input: &mut BufReader<File>) -> Result<Film, Failure> {
    Ok(premultiplied(decode_texels(input, true)?))
}

/// Texels with straight alpha as a film.
pub(super) fn premultiplied((width, height, mut texels): Texels) -> Film {
    texels.par_iter_mut().for_each(|[rgb @ .., alpha]| rgb.iter_mut().for_each(|v| *v *= *alpha));
    Film::from_premultiplied(width, height, &texels)
}

/// The `pelage.*` text chunks in front of the image data.
pub(super) fn decode_metadata(input: &mut BufReader<File>) -> Result<Metadata, Failure> {
    let reader = ::png::Decoder::new(input).read_info()?;
    let mut meta = Metadata::default();
    for chunk in &reader.info().utf8_text {
        if let Some(key) = chunk.keyword.strip_prefix(PREFIX) {
            let mut chunk = chunk.clone();
            chunk.decompress_text_with_limit(64 << 20)?;
            meta = meta.with(key, chunk.get_text()?);
        }
    }
    Ok(meta)
}
