//! Converts linear premultiplied texels to 8-bit sRGB and to compressed blocks.

use super::{Texture, ktx2::Encoding};
use block_compression::{BC7Settings, CompressionVariant, decode, encode};
use pelage_core::film::tonemap::{srgb_decode, srgb_encode};

/// Eight bits per channel: the premultiplied colour encoded as sRGB, coverage linear. Values are
/// clamped to 0..1.
///
/// Texture units decode colours before they filter, so filtering and blending work on linear
/// premultiplied colour.
// [IEC61966]
pub fn rgba8(texture: &Texture) -> Vec<u8> {
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
    let texel = |t: &[f32; 4]| {
        [byte(srgb_encode(t[0])), byte(srgb_encode(t[1])), byte(srgb_encode(t[2])), byte(t[3])]
    };
    texture.texels.iter().flat_map(texel).collect()
}

/// Decodes the bytes of [`rgba8`]; missing texels are left out.
pub fn from_rgba8(width: u32, height: u32, bytes: &[u8]) -> Texture {
    let value = |b: u8| f32::from(b) / 255.0;
    let color: [f32; 256] = std::array::from_fn(|b| srgb_decode(value(b as u8)));
    let texel = |t: &[u8]| {
        [color[usize::from(t[0])], color[usize::from(t[1])], color[usize::from(t[2])], value(t[3])]
    };
    Texture { width, height, texels: bytes.chunks_exact(4).map(texel).collect() }
}

/// Encodes the [`rgba8`] bytes of an image of `size` texels; `Rgba8` returns them unchanged. Sizes
/// that are not multiples of 4 are padded by wrapping around along u, and along v if `wrap_v`,
/// otherwise by repeating the last row.
///
/// # Errors
/// If the number of bytes is not four per texel.
pub fn blocks(encoding: Encoding, size: [u32; 2], bytes: &[u8], wrap_v: bool) -> Result<Vec<u8>, String> {
    check("texels", bytes, u64::from(size[0]) * u64::from(size[1]) * 4)?;
    let Some(variant) = variant(encoding) else { return Ok(bytes.to_vec()) };
    let full = size.map(|n| n.next_multiple_of(4));
    let mut padded = Vec::with_capacity(full[0] as usize * full[1] as usize * 4);
    for j in 0..full[1] {
        let j = if wrap_v { j % size[1] } else { j.min(size[1] - 1) };
        for i in 0..full[0] {
            let at = 4 * (j as usize * size[0] as usize + (i % size[0]) as usize);
            padded.extend(bytes.get(at..at + 4).unwrap_or_default());
        }
    }
    let mut blocks = vec![0; variant.blocks_byte_size(full[0], full[1])];
    encode::compress_rgba8(variant, &padded, &mut blocks, full[0], full[1], 4 * full[0]);
    Ok(blocks)
}

/// Decodes the output of [`blocks`] to [`rgba8`] bytes.
///
/// # Errors
/// If the number of bytes does not match the size.
pub fn from_blocks(encoding: Encoding, size: [u32; 2], blocks: &[u8]) -> Result<Vec<u8>, String> {
    check("blocks", blocks, encoding.layer_bytes(size))?;
    let Some(variant) = variant(encoding) else { return Ok(blocks.to_vec()) };
    let full = size.map(|n| n.next_multiple_of(4));
    let mut padded = vec![0; full[0] as usize * full[1] as usize * 4];
    decode::decompress_blocks_as_rgba8(variant, full[0], full[1], blocks, &mut padded);
    let (row, full_row) = (4 * size[0] as usize, 4 * full[0] as usize);
    Ok(padded.chunks_exact(full_row).take(size[1] as usize).flat_map(|r| r[..row].to_vec()).collect())
}

fn check(what: &str, bytes: &[u8], expected: u64) -> Result<(), String> {
    if bytes.is_empty() || bytes.len() as u64 != expected {
        return Err(format!("{} bytes of {what}, expected {expected}", bytes.len()));
    }
    Ok(())
}

fn variant(encoding: Encoding) -> Option<CompressionVariant> {
    match encoding {
        Encoding::Rgba8 => None,
        Encoding::Bc3 => Some(CompressionVariant::BC3),
        // Ten times as fast as the slowest settings, and within 0.05 dB of them on textures of hair
        // dots.
        Encoding::Bc7 => Some(CompressionVariant::BC7(BC7Settings::alpha_very_fast())),
    }
}

/// Peak signal-to-noise ratio between byte sequences, dB, over colour and coverage alike: infinite
/// if they are equal, 0 if their lengths differ.
pub fn psnr(a: &[u8], b: &[u8]) -> f64 {
    if a.len() != b.len() {
        return 0.0;
    }
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    10.0 * (255.0 * 255.0 * a.len().max(1) as f64 / sum).log10()
}
