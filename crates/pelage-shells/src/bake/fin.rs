//! The texture of the fin: a slab of hair seen from the side, composited from back to front.
// [Lengyel2001] sec. 2.2

use super::Texture;
use super::stamp::{Stamp, roomy_sigma};
use super::strand::{Hair, HairSource};
use super::voxels::Block;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Hairs drawn in parallel before they are composited.
const BATCH: usize = 256;

/// The texels of a hair in the fin.
struct Drawn {
    root: f32,
    origin: [i32; 2],
    columns: usize,
    depth: Vec<f32>,
    color: Vec<[f32; 3]>,
    guard: bool,
}

/// Draws the hairs with roots in the first `slab` of the torus along v (as a fraction of its edge),
/// seen along v with u to the right. With `split` the second texture is the guard hairs'
/// contribution; otherwise it is empty.
pub fn fin(
    fur: &impl HairSource,
    block: &Block,
    resolution: [u32; 2],
    slab: f32,
    split: bool,
) -> (Texture, Texture) {
    let [width, height] = resolution;
    // From back to front; hairs at the same depth by index.
    let mut order: Vec<(f32, u32)> = (0..fur.count())
        .into_par_iter()
        .filter_map(|i| {
            let v = fur.root(i)[1];
            let v = v - v.floor();
            (v < slab).then_some((v, i))
        })
        .collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let new = || vec![[0.0f32; 4]; width as usize * height as usize];
    let (mut all, mut guard) = (new(), if split { new() } else { Vec::new() });
    for batch in order.chunks(BATCH) {
        let drawn: Vec<Option<Drawn>> = batch
            .par_iter()
            .map_init(Stamp::default, |stamp, (_, i)| draw(&fur.hair(*i), block, resolution, stamp))
            .collect();
        for hair in drawn.into_iter().flatten() {
            over(&hair, resolution, &mut all, &mut guard);
        }
    }
    let texture = |texels: Vec<[f32; 4]>| match texels.is_empty() {
        true => Texture::default(),
        false => Texture { width, height, texels },
    };
    (texture(all), texture(guard))
}

fn draw(hair: &Hair, block: &Block, [width, height]: [u32; 2], stamp: &mut Stamp) -> Option<Drawn> {
    let texel = Vec2::new(block.patch[0] / width as f32, block.height / height as f32);
    let root = hair.root[0] * width as f32;
    let (mut length, mut shown) = (0.0, 0.0);
    // Colour of each row, from the steps in it.
    let mut rows = vec![[0.0f32; 4]; height as usize];
    stamp.clear();
    let cell = Vec3::new((0.7 * texel.x).max(0.125 * hair.thickest()), f32::INFINITY, 0.35 * texel.y);
    hair.steps(cell, f32::NEG_INFINITY, block.height, |step| {
        let area = step.area / (texel.x * texel.y);
        if area > 0.0 {
            let at = Vec2::new(root - root.floor() + step.at.x / texel.x, step.at.z.max(0.0) / texel.y);
            stamp.push(at, area);
            let row = (at.y as usize).min(rows.len() - 1);
            let add = (step.color * area).extend(area).to_array();
            (0..4).for_each(|k| rows[row][k] += add[k]);
            length += step.length;
            shown += step.area;
        }
    });
    let area = stamp.area();
    if area <= 0.0 {
        return None;
    }
    let sigma = roomy_sigma(Vec2::splat(shown / length.max(1e-20)) / texel, stamp.extent(), area);
    stamp.spread(Vec2::new(sigma.x, sigma.y.min(0.75)), Some(height));
    stamp.cover();
    // Rows reached only by the filter take the colour of the nearest row with steps.
    let known: Vec<usize> = (0..rows.len()).filter(|r| rows[*r][3] > 0.0).collect();
    let nearest = |r: i32| {
        let at = known.partition_point(|k| (*k as i32) < r).min(known.len() - 1);
        let [x, y, z, w] = rows[known[at]];
        [x / w, y / w, z / w]
    };
    let color = (0..stamp.size[1]).map(|j| nearest(stamp.origin[1] + j as i32)).collect();
    let depth = std::mem::take(&mut stamp.depth);
    Some(Drawn {
        root: root.floor(),
        origin: stamp.origin,
        columns: stamp.size[0],
        depth,
        color,
        guard: hair.guard,
    })
}

/// Composites a hair over the textures.
// [PorterDuff1984]
fn over(hair: &Drawn, [width, height]: [u32; 2], all: &mut [[f32; 4]], guard: &mut [[f32; 4]]) {
    let first = (hair.root as i64 + i64::from(hair.origin[0])).rem_euclid(i64::from(width)) as usize;
    for (j, line) in hair.depth.chunks_exact(hair.columns).enumerate() {
        let row = hair.origin[1] + j as i32;
        if row < 0 || row >= height as i32 {
            continue;
        }
        let [r, g, b] = hair.color[j];
        let mut column = first;
        for depth in line {
            let alpha = -(-depth).exp_m1();
            let at = row as usize * width as usize + column;
            let add = [r * alpha, g * alpha, b * alpha, alpha];
            (0..4).for_each(|k| all[at][k] = add[k] + (1.0 - alpha) * all[at][k]);
            if let Some(texel) = guard.get_mut(at) {
                let own = if hair.guard { 1.0 } else { 0.0 };
                (0..4).for_each(|k| texel[k] = own * add[k] + (1.0 - alpha) * texel[k]);
            }
            column = if column + 1 == width as usize { 0 } else { column + 1 };
        }
    }
}
