//! Decoding PNG, Radiance HDR and OpenEXR, with every size checked before it is believed.

use crate::{Error, Result};
use exr::prelude::{FlatSamples, MetaData, ReadChannels, ReadLayers, read as exr_read};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Width, height and RGBA texels from the top.
type Texels = (u32, u32, Vec<[f32; 4]>);

/// Texels a side that a header may claim.
const MAX_FILE_SIDE: u32 = 32768;
/// Texels in all that a header may claim.
const MAX_TEXELS: u64 = 1 << 27;
/// Bytes that a decoder may allocate.
const MAX_ALLOCATION: u64 = 4 << 30;

/// Reads an image file; the format is told by its content. 8 and 16 bit values become 0..1; where `color` is set, they
/// are decoded from sRGB, and the colours of EXR files, which are premultiplied, are divided by alpha.
///
/// Errors: [`Error::Io`] where the file cannot be read; [`Error::Scene`] with its name where it is no image, truncated,
/// or claims a size past the limits above.
pub(super) fn read(path: &Path, color: bool) -> Result<Texels> {
    let bytes = std::fs::read(path).map_err(|e| Error::io(path, e))?;
    let decoded = if bytes.starts_with(b"\x89PNG") {
        png_or_hdr(&bytes, ImageFormat::Png, color)
    } else if bytes.starts_with(b"#?") {
        png_or_hdr(&bytes, ImageFormat::Hdr, color)
    } else if bytes.starts_with(&[0x76, 0x2F, 0x31, 0x01]) {
        exr(&bytes, color)
    } else {
        let start: Vec<u8> = bytes.iter().copied().take(4).collect();
        Err(format!(
            "found a file that begins with {start:02x?}, expected a PNG, Radiance HDR or OpenEXR image"
        ))
    };
    decoded.map_err(|message| Error::fault(path, message))
}

fn check_size(width: u64, height: u64) -> Result<(), String> {
    let side = u64::from(MAX_FILE_SIDE);
    if width == 0 || height == 0 || width > side || height > side || width * height > MAX_TEXELS {
        return Err(format!(
            "the header claims {width}x{height} texels, expected 1 to {side} a side and at most {MAX_TEXELS} in all"
        ));
    }
    Ok(())
}

fn png_or_hdr(bytes: &[u8], format: ImageFormat, color: bool) -> Result<Texels, String> {
    let broken = |e: image::ImageError| format!("truncated or damaged image: {e}");
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(MAX_FILE_SIDE);
    limits.max_image_height = Some(MAX_FILE_SIDE);
    limits.max_alloc = Some(MAX_ALLOCATION);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    check_size(u64::from(width), u64::from(height))?;
    let float = matches!(decoder.color_type(), ColorType::Rgb32F | ColorType::Rgba32F);
    let image = DynamicImage::from_decoder(decoder).map_err(broken)?;
    let mut texels: Vec<[f32; 4]> = image.into_rgba32f().pixels().map(|p| p.0).collect();
    if color && !float {
        texels.iter_mut().flat_map(|t| &mut t[..3]).for_each(|v| *v = linear_from_srgb(*v));
    }
    Ok((width, height, texels))
}

/// Linear light of an sRGB value, both 0..1 (IEC 61966-2-1).
// [IEC61966-2-1]
fn linear_from_srgb(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

fn exr(bytes: &[u8], color: bool) -> Result<Texels, String> {
    let broken = |e: exr::error::Error| format!("truncated or damaged EXR image: {e}");
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    for header in &meta.headers {
        check_size(header.layer_size.x() as u64, header.layer_size.y() as u64)?;
        if header.deep {
            return Err("found a deep EXR image, expected a flat one".into());
        }
    }
    let image = exr_read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    let layer = image.layer_data;
    let (width, height) = (layer.size.x(), layer.size.y());
    let count = width * height;
    let channels = &layer.channel_data.list;
    let channel = |name: &str| -> Option<Vec<f32>> {
        let found = channels.iter().find(|c| c.name.eq(name))?;
        let values: Vec<f32> = match &found.sample_data {
            FlatSamples::F16(v) => v.iter().map(|v| v.to_f32()).collect(),
            FlatSamples::F32(v) => v.clone(),
            FlatSamples::U32(v) => v.iter().map(|v| *v as f32).collect(),
        };
        // Subsampled channels are shorter.
        (values.len() == count).then_some(values)
    };
    let (r, g, b) = match (channel("R"), channel("G"), channel("B"), channel("Y")) {
        (Some(r), Some(g), Some(b), _) => (r, g, b),
        (None, None, None, Some(y)) => (y.clone(), y.clone(), y),
        _ => {
            let names: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
            return Err(format!(
                "found the EXR channels {}, expected R G B or Y in full size",
                names.join(" ")
            ));
        }
    };
    let a = channel("A");
    let texels = (0..count)
        .map(|i| {
            let alpha = a.as_ref().map_or(1.0, |a| a[i]);
            let divide = if color && alpha > 0.0 { alpha } else { 1.0 };
            [r[i] / divide, g[i] / divide, b[i] / divide, alpha]
        })
        .collect();
    Ok((width as u32, height as u32, texels))
}
