//! Memory of hair textures, raw, compressed and as a single layer, and fur rendered with each.

use super::super::{FigureContent, FigureContext};
use crate::report::{Table, number};
use glam::Vec4;
use pelage_core::{Error, Result};
use pelage_shells::bake::ktx2::Encoding;
use pelage_shells::bake::{self, Format, FurTextures, Texture, WriteOptions, compress, memory};
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Scene file, relative to the figure's folder.
    scene: String,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let (world, assets) = context.load(&settings.scene, &[])?;
    let textures = bake::bake(&world)?;
    let mut content = FigureContent::default();
    let m = &textures.manifest;
    let rows = memory::table(m.layers, m.resolution, m.fin_resolution);
    let whole = rows.first().map_or(1, |row| row.bytes_with_mips) as f64;
    let cells = |row: &memory::MemoryRow| {
        vec![
            row.what.clone(),
            row.bytes.to_string(),
            row.bytes_with_mips.to_string(),
            format!("{:.3}", row.bytes_with_mips as f64 / whole),
            row.paper.clone().unwrap_or_else(|| "-".into()),
        ]
    };
    let caption = format!(
        "{} layers of {} x {} texels, a fin of {} x {}.",
        m.layers, m.resolution[0], m.resolution[1], m.fin_resolution[0], m.fin_resolution[1]
    );
    let head = ["textures", "bytes, finest level", "bytes with mips", "of the first", "paper"];
    content.table(&Table::new(caption, &head, rows.iter().map(cells).collect()));
    for row in &rows {
        content.value(&row.what, row.bytes_with_mips as f64, 0.0);
    }

    let mut rows = Vec::new();
    for (label, encoding) in [
        ("RGBA8", Encoding::Rgba8),
        ("BC3 (DXT5)", Encoding::Bc3),
        ("BC7", Encoding::Bc7),
        ("one layer, ramp", Encoding::Rgba8),
    ] {
        let ramp = label.starts_with("one");
        let (stored, psnr) = if ramp {
            (one_layer(&textures), None)
        } else {
            coded(&textures, encoding).map_err(Error::Unsupported)?
        };
        let mut world = world.clone();
        let folder = context.out.join(format!("textures_{}", content.images.len()));
        let options = WriteOptions { formats: vec![Format::Exr], ..WriteOptions::default() };
        bake::write(&stored, &folder, &options)?;
        world.textures = Some(folder.join(bake::MANIFEST));
        content.images.push(context.render_panel(label, &world, &assets)?);
        std::fs::remove_dir_all(&folder).map_err(|e| Error::io(&folder, e))?;
        let change = 100.0 * (coverage(&stored) / coverage(&textures) - 1.0);
        let psnr = psnr.map_or_else(
            || "-".to_owned(),
            |db| if db.is_finite() { format!("{db:.1}") } else { "lossless".into() },
        );
        rows.push(vec![label.to_owned(), psnr, format!("{change:+.2} %")]);
        content.value(&format!("{label}: mean coverage of the layers"), coverage(&stored), 1e-3);
    }
    let head = ["stored as", "PSNR, dB", "mean coverage of the layers, change"];
    let caption =
        format!("What storing does to the hair; mean coverage is {} as baked.", number(coverage(&textures)));
    content.table(&Table::new(caption, &head, rows));
    Ok(content)
}

/// Textures after encoding and decoding, and the peak signal-to-noise ratio of the layers against
/// their RGBA8 values, dB.
fn coded(
    textures: &FurTextures,
    encoding: Encoding,
) -> std::result::Result<(FurTextures, Option<f64>), String> {
    let (mut before, mut after) = (Vec::new(), Vec::new());
    let mut through = |texture: &Texture, wrap_v: bool, counts: bool| {
        let size = [texture.width, texture.height];
        let bytes = compress::rgba8(texture);
        let blocks = compress::blocks(encoding, size, &bytes, wrap_v)?;
        let decoded = compress::from_blocks(encoding, size, &blocks)?;
        let texture = compress::from_rgba8(texture.width, texture.height, &decoded);
        if counts {
            before.extend(bytes);
            after.extend(decoded);
        }
        Ok::<Texture, String>(texture)
    };
    let layers =
        textures.layers.iter().map(|t| through(t, true, true)).collect::<std::result::Result<_, _>>()?;
    let fin = through(&textures.fin, false, false)?;
    let stored = FurTextures { layers, fin, ..textures.clone() };
    Ok((stored, Some(compress::psnr(&before, &after))))
}

/// Textures whose layers are all the innermost one, in the mean colour of all, with an alpha that
/// falls linearly from the skin.
// [Lengyel2001] sec. 4: a single image with an alpha ramp
fn one_layer(textures: &FurTextures) -> FurTextures {
    let count = textures.layers.len() as f32;
    let sum =
        |layers: &[Texture]| layers.iter().flat_map(|t| &t.texels).map(|t| Vec4::from(*t)).sum::<Vec4>();
    let [all, first] = [sum(&textures.layers), sum(&textures.layers[..1])].map(|s| s / s.w.max(1e-9));
    let tone = (all / first.max(Vec4::splat(1e-9))).truncate().extend(1.0);
    let layer = |l: usize| {
        let part = 1.0 - l as f32 / count;
        let mut texture = textures.layers[0].clone();
        texture.texels.iter_mut().for_each(|t| *t = (Vec4::from(*t) * tone * part).into());
        texture
    };
    FurTextures { layers: (0..textures.layers.len()).map(layer).collect(), ..textures.clone() }
}

fn coverage(textures: &FurTextures) -> f64 {
    let texels = || textures.layers.iter().flat_map(|t| &t.texels);
    texels().map(|t| f64::from(t[3])).sum::<f64>() / texels().count().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_reduces_the_coverage_of_upright_hair() {
        let texels = vec![[0.2, 0.2, 0.2, 0.5]; 16];
        let layer = Texture { width: 4, height: 4, texels };
        let scene = pelage_core::Scene::default();
        let manifest = bake::Manifest {
            version: 1,
            generator: String::new(),
            source: scene.bake.source,
            seed: 0,
            layers: 4,
            resolution: [4; 2],
            fin_resolution: [4; 2],
            patch: [1.0; 2],
            fin_length: 1.0,
            fin_depth: 0.1,
            height: 1.0,
            spacing: 0.25,
            summary: Vec::new(),
        };
        let textures = FurTextures {
            layers: vec![layer; 4],
            guard: Vec::new(),
            fin: Texture::default(),
            fin_guard: Texture::default(),
            manifest,
        };
        // The mean of 1, 3/4, 1/2 and 1/4.
        let ramp = one_layer(&textures);
        assert!((coverage(&ramp) / coverage(&textures) - 0.625).abs() < 1e-6);
    }
}
