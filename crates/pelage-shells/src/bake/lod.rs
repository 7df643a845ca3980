//! Levels of detail: fewer layers, each composited from two of the level before.
// [Lengyel2001] sec. 3.3, level-of-detail control

use super::{FurTextures, Texture};
use rayon::prelude::*;

/// The layers of a coarser level, innermost first; the fin is the same at all levels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LodLevel {
    /// Layer j stands for the layers of [`slab`] of the finest level.
    pub layers: Vec<Texture>,
    /// The guard hairs' share of what is seen of each layer; empty where [`FurTextures::guard`] is.
    pub guard: Vec<Texture>,
}

/// All levels coarser than the textures themselves, down to one layer: element 0 is level 1. Empty for one layer.
///
/// Layer j of a level is layer 2j + 1 of the level before over its layer 2j; of an odd number of layers the outermost goes
/// on alone. So a look along the normal sees the same at every level.
pub fn coarser(textures: &FurTextures) -> Vec<LodLevel> {
    let mut levels: Vec<LodLevel> = Vec::new();
    loop {
        let (layers, guard) =
            levels.last().map_or((&textures.layers, &textures.guard), |level| (&level.layers, &level.guard));
        if layers.len() < 2 {
            return levels;
        }
        let next = LodLevel { layers: pairs(layers, layers), guard: pairs(guard, layers) };
        levels.push(next);
    }
}

/// The layers `from..to` of the finest level that layer `layer` of `level` stands for; `layers` is the finest number.
pub fn slab(layers: u32, level: u32, layer: u32) -> [u32; 2] {
    let edge = |layer: u32| layer.checked_shl(level).unwrap_or(layers).min(layers);
    [edge(layer), edge(layer.saturating_add(1))]
}

/// Composites pairs of `parts`, each seen through the whole of the layer above it: `parts` are the layers themselves or a
/// part of each.
// DEVIATION: the paper's coarse level keeps empty odd shells, so that it can fade from level to level in the texture;
// here they are left out of the files, and `slab` says where a layer stands.
fn pairs(parts: &[Texture], layers: &[Texture]) -> Vec<Texture> {
    parts
        .par_chunks(2)
        .zip(layers.par_chunks(2))
        .map(|(parts, layers)| match (parts, layers) {
            ([under, part], [_, layer]) => through(part, layer, under),
            ([alone, ..], _) => alone.clone(),
            ([], _) => Texture::default(),
        })
        .collect()
}

// [PorterDuff1984] over, for a part of the upper picture
/// `part` of the upper layer and what `layer`, the whole of it, lets through of `under`.
fn through(part: &Texture, layer: &Texture, under: &Texture) -> Texture {
    let seen = |((part, layer), under): ((&[f32; 4], &[f32; 4]), &[f32; 4])| {
        // What is not of this part hides what lies below it all the same.
        let through = 1.0 - layer[3];
        std::array::from_fn(|c| part[c] + through * under[c])
    };
    let texels = part.texels.iter().zip(&layer.texels).zip(&under.texels).map(seen).collect();
    Texture { width: part.width, height: part.height, texels }
}
