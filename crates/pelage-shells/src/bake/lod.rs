//! Levels of detail: each has half as many layers, composited from pairs of layers of the level
//! before.
// [Lengyel2001] sec. 2.4, level-of-detail control

use super::{FurTextures, Texture};
use rayon::prelude::*;

/// The layers of a coarser level, innermost first. The fin is the same at all levels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LodLevel {
    /// Layer j represents the layers [`slab`] of the finest level.
    pub layers: Vec<Texture>,
    /// Visible contribution of the guard hairs to each layer; empty if [`FurTextures::guard`] is.
    pub guard: Vec<Texture>,
}

/// All levels coarser than the textures themselves, down to one layer; element 0 is level 1. Empty
/// if there is only one layer.
///
/// Layer j of a level is layer 2j + 1 of the level before, composited over its layer 2j. If their
/// number is odd, the outermost is copied. So all levels look the same along the normal.
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

/// The range `from..to` of layers of the finest level that layer `layer` of `level` represents;
/// `layers` is the number of layers of the finest level.
pub fn slab(layers: u32, level: u32, layer: u32) -> [u32; 2] {
    let edge = |layer: u32| layer.checked_shl(level).unwrap_or(layers).min(layers);
    [edge(layer), edge(layer.saturating_add(1))]
}

/// Composites pairs of `parts`, where each lower part is seen through the whole layer above it.
/// `parts` are the layers themselves or a contribution to each.
// DEVIATION: the paper's coarse level keeps empty odd shells so that the texture can fade between
// levels; here they are omitted, and `slab` gives the position of a layer.
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

/// `part` of the upper layer, composited over `under` with the transmittance of the whole upper
/// `layer`.
// [PorterDuff1984] over, for a contribution to the upper layer
fn through(part: &Texture, layer: &Texture, under: &Texture) -> Texture {
    let seen = |((part, layer), under): ((&[f32; 4], &[f32; 4]), &[f32; 4])| {
        // Whatever else is in the layer occludes what lies below it, too.
        let through = 1.0 - layer[3];
        std::array::from_fn(|c| part[c] + through * under[c])
    };
    let texels = part.texels.iter().zip(&layer.texels).zip(&under.texels).map(seen).collect();
    Texture { width: part.width, height: part.height, texels }
}
