//! A texture as PNG: 8 bits, sRGB, straight alpha.

use super::{Texture, mips};
use pelage_core::files::Failure;
use pelage_core::film::tonemap::srgb_encode;

/// Encodes the file. Texels without coverage take the mean colour around them, so that clients that
/// filter straight colours get no dark fringes.
pub(super) fn encode(texture: &Texture) -> Result<Vec<u8>, Failure> {
    let straight = straight(texture);
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
    let texel = |([r, g, b], t): (&[f32; 3], &[f32; 4])| {
        [byte(srgb_encode(*r)), byte(srgb_encode(*g)), byte(srgb_encode(*b)), byte(t[3])]
    };
    let bytes: Vec<u8> = straight.iter().zip(&texture.texels).flat_map(texel).collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, texture.width, texture.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.add_itxt_chunk("Software".into(), concat!("pelage ", env!("CARGO_PKG_VERSION")).into())?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(file)
}

/// Straight colours. A texel without coverage takes its colour from the finest mip level that has
/// coverage there; black if none has.
fn straight(texture: &Texture) -> Vec<[f32; 3]> {
    let mut colors: Vec<[f32; 3]> = Vec::new();
    let mut coarser: Option<[u32; 2]> = None;
    for level in mips::chain(texture, mips::Keep::Mean).iter().rev() {
        let inherited = |i: usize| {
            let [w, h] = coarser?;
            let (x, y) = (i as u32 % level.width, i as u32 / level.width);
            let (x, y) = ((x * w / level.width).min(w - 1), (y * h / level.height).min(h - 1));
            colors.get((y * w + x) as usize).copied()
        };
        let color = |(i, t): (usize, &[f32; 4])| {
            if t[3] > 0.0 { [t[0], t[1], t[2]].map(|c| c / t[3]) } else { inherited(i).unwrap_or_default() }
        };
        colors = level.texels.iter().enumerate().map(color).collect();
        coarser = Some([level.width, level.height]);
    }
    colors
}
