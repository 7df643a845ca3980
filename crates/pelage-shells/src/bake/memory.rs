//! Memory of baked textures, in the rows of the paper's comparison.
// [Lengyel2001] sec. 4, texture memory

use super::{ktx2::Encoding, mips};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Memory for one method of storing the textures.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct MemoryRow {
    /// What is stored, and how.
    pub what: String,
    /// Bytes of the finest mip level of each texture.
    pub bytes: u64,
    /// Bytes with all mip levels.
    pub bytes_with_mips: u64,
    /// The figure that Lengyel et al. print for this row; only for the paper's sizes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper: Option<String>,
}

/// The sizes for which the paper prints figures: layers, their texels, texels of the fin.
const PAPER: (u32, [u32; 2], [u32; 2]) = (16, [128, 128], [512, 64]);

/// The table for `layers` layers of `resolution` texels and a fin of `fin` texels.
pub fn table(layers: u32, resolution: [u32; 2], fin: [u32; 2]) -> Vec<MemoryRow> {
    use Encoding::{Bc3, Bc7, Rgba8};
    let bytes = |encoding, counts: &[(u64, [u32; 2])], mips| {
        counts.iter().map(|(n, size)| n * texture_bytes(encoding, *size, mips)).sum::<u64>()
    };
    let row = |what: &str, encoding, counts: &[(u64, [u32; 2])], paper: &str| MemoryRow {
        what: what.into(),
        bytes: bytes(encoding, counts, false),
        bytes_with_mips: bytes(encoding, counts, true),
        paper: (!paper.is_empty() && (layers, resolution, fin) == PAPER).then(|| paper.into()),
    };
    let all = [(u64::from(layers), resolution), (1, fin)];
    // Levels of detail: halved, rounded up, down to one layer.
    let coarser = std::iter::successors(Some(layers), |n| (*n > 1).then(|| n.div_ceil(2))).skip(1);
    let lods = [(coarser.map(u64::from).sum::<u64>() + u64::from(layers), resolution), (1, fin)];
    // One image for all layers of upright hair, with a ramp over height in the client, and one for
    // the skin, as in the paper.
    let single = [(2, resolution), (1, fin)];
    vec![
        row("layers and fin, RGBA8", Rgba8, &all, "1.6 MB with mips"),
        row("layers and fin, BC3 (DXT5)", Bc3, &all, "a third of it"),
        row("layers and fin, BC7", Bc7, &all, ""),
        row("one layer for upright hair with a ramp, skin and fin, RGBA8", Rgba8, &single, "200 KB"),
        row("layers with all levels of detail and fin, RGBA8", Rgba8, &lods, ""),
        row("layers with all levels of detail and fin, BC7", Bc7, &lods, ""),
    ]
}

/// Bytes of one texture.
fn texture_bytes(encoding: Encoding, size: [u32; 2], with_mips: bool) -> u64 {
    let levels = if with_mips { mips::levels(size) } else { 1 };
    (0..levels).map(|level| encoding.layer_bytes(mips::size(size, level))).sum()
}
