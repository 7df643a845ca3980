//! The rows of vertices above the skin: shells by level of detail, and the rows of the fins.

use super::Means;
use pelage_core::scene::Shells;
use pelage_core::skin::NONE;
use pelage_fur::layout::ShellRow;

/// Rows of a fin, skin and tip included. Light, which falls off fast into the fur, is interpolated
/// between them.
pub const FIN_ROWS: u32 = 9;

/// Number of layers at each level of detail, finest first: each level has half as many as the one
/// before, rounded up, down to one.
pub fn levels(layers: u32) -> Vec<u32> {
    let mut all = vec![layers.max(1)];
    while let Some(last) = all.last().copied().filter(|n| *n > 1) {
        all.push(last.div_ceil(2));
    }
    all
}

/// The rows for a camera at `distance` diameters of the skin: the innermost `drawn` of `layers`
/// layers at their level of detail, then the rows of the fins. `means` holds the means of the
/// layers of all levels, one level after the other; `jitter` gives the variance per axis of the
/// hairs' direction at a row's height (0..1).
///
/// Between two levels each shell moves and changes from its fine layer to the coarse layer that
/// contains it; shells without a coarse counterpart fade out. So nothing pops at any distance.
// [Lengyel2001] sec. 2.4; DEVIATION: the coarse shell lies in the middle of its slab instead of at
// the lower of the two, so that the fur keeps its height.
pub fn rows(
    shells: &Shells,
    layers: u32,
    drawn: u32,
    distance: f32,
    means: &[Means],
    jitter: &dyn Fn(f32) -> f32,
) -> Vec<ShellRow> {
    let counts = levels(layers);
    let coarsest = counts.len() - 1;
    let detail = if shells.lod.enabled {
        ((distance / shells.lod.distance).log2() + 1.0).clamp(0.0, coarsest as f32)
    } else {
        0.0
    };
    let level = (detail.floor() as usize).min(coarsest);
    let blend = if level == coarsest { 0.0 } else { detail - level as f32 };
    let first = |level: usize| counts[..level].iter().sum::<u32>();
    let middle = |level: usize, layer: u32| {
        let [low, high] = crate::bake::lod::slab(layers, level as u32, layer);
        0.5 * (low + high) as f32 / layers as f32
    };
    let table = &shells.table;
    let shade =
        |height: f32| table.self_shadow + (1.0 - table.self_shadow) * height.powf(table.self_shadow_exponent);
    let mut all: Vec<ShellRow> = (0..counts[level])
        .filter(|layer| crate::bake::lod::slab(layers, level as u32, *layer)[0] < drawn)
        .map(|layer| {
            let fine = first(level) + layer;
            let changes = blend > 0.0;
            let stays = changes && layer % 2 == 0;
            let coarse = if stays { first(level + 1) + layer / 2 } else { NONE };
            let height = middle(level, layer);
            let height =
                if stays { height + blend * (middle(level + 1, layer / 2) - height) } else { height };
            let mean = means.get(fine as usize).copied().unwrap_or_default();
            let to = means.get(coarse as usize).map_or(0.0, |m| m.coverage);
            ShellRow {
                height,
                fine,
                coarse,
                blend: if changes { blend } else { 0.0 },
                undercoat: mean.undercoat,
                shade: shade(height),
                guard: mean.guard,
                jitter: jitter(height),
                coverage: mean.coverage + if changes { blend * (to - mean.coverage) } else { 0.0 },
                share: mean.share,
                padding: [0; 2],
            }
        })
        .collect();
    let top = drawn.clamp(1, layers) as f32 / layers as f32;
    let top = if drawn == 0 { 1.0 } else { top };
    all.extend((0..FIN_ROWS).map(|k| {
        let height = top * k as f32 / (FIN_ROWS - 1) as f32;
        let layer = ((height * layers as f32) as usize).min(layers as usize - 1);
        let mean = means.get(layer).copied().unwrap_or_default();
        ShellRow {
            height,
            fine: layer as u32,
            coarse: NONE,
            blend: 0.0,
            undercoat: mean.undercoat,
            shade: shade(height),
            guard: mean.guard,
            jitter: jitter(height),
            coverage: mean.coverage,
            share: mean.share,
            padding: [0; 2],
        }
    }));
    all
}
