//! Samples hairs into layers: at each texel a tall Gaussian meets the hairs.
// [Lengyel2001] sec. 2.2

use super::Texture;
use super::stamp::{Stamp, roomy_sigma, sigma_of};
use super::strand::{Hair, HairSource};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// A stack of layers over a torus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Edges of the torus along u and v, cm.
    pub patch: [f32; 2],
    /// Height, cm.
    pub height: f32,
    /// Number of layers.
    pub layers: u32,
    /// Texels of a layer along u and v.
    pub resolution: [u32; 2],
}

/// Quantity that is preserved when a hair is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// Optical depth: the sum of the depths of a hair's texels, times their area, is its length x
    /// diameter.
    Depth,
    /// Coverage: the sum of the coverages of a hair's texels, as if it were alone, times their
    /// area, is its length x diameter. The transmittance of many hairs then follows the
    /// Beer–Lambert law, whatever the size of the texels.
    Coverage,
}

/// The layers and their optical depths.
#[derive(Debug, Clone, PartialEq)]
pub struct Voxels {
    /// All hairs: premultiplied colour and coverage.
    pub layers: Vec<Texture>,
    /// Contribution of the guard hairs; empty if they are not separate.
    pub guard: Vec<Texture>,
    /// Length x diameter of the hairs in each layer, over the area of the torus.
    pub optical_depth: Vec<f64>,
    /// Length x diameter of hair above the block, which is in no layer, over the area of the torus.
    pub above: f64,
}

/// Hairs grown in parallel before they are sampled.
const BATCH: u32 = 4096;

/// Half-width of the vertical Gaussian, spacings; its standard deviation is half a spacing.
const REACH: f32 = 1.5;

/// Weight of layer `l` of `n` at height `x` in spacings. The weights of all layers sum to 1.
fn share(x: f32, l: u32, n: u32) -> f32 {
    let weight = |j: i32| {
        let d = x - j as f32 - 0.5;
        if d.abs() < REACH { (-2.0 * d * d).exp() } else { 0.0 }
    };
    let near = x.floor() as i32;
    let sum: f32 = (near - 2..=near + 2).filter(|j| *j >= 0 && *j < n as i32).map(weight).sum();
    if sum > 0.0 { weight(l as i32) / sum } else { 0.0 }
}

/// A layer during accumulation: colour times depth, and depth.
struct Layer {
    all: Vec<[f32; 4]>,
    guard: Vec<[f32; 4]>,
    area: f64,
    stamp: Stamp,
}

/// Samples hairs into layers; `split` keeps the guard hairs' contribution. The result does not
/// depend on the number of threads. If all roots are moved by whole texels, it moves with them, bit
/// by bit.
pub fn voxelise(fur: &impl HairSource, block: &Block, keep: Keep, split: bool) -> Voxels {
    let [width, height] = block.resolution;
    let texels = width as usize * height as usize;
    let new = |_| Layer {
        all: vec![[0.0; 4]; texels],
        guard: vec![[0.0; 4]; if split { texels } else { 0 }],
        area: 0.0,
        stamp: Stamp::default(),
    };
    let mut layers: Vec<Layer> = (0..block.layers).map(new).collect();
    let mut above = 0.0;
    for start in (0..fur.count()).step_by(BATCH as usize) {
        let end = start.saturating_add(BATCH).min(fur.count());
        let hairs: Vec<Hair> = (start..end).into_par_iter().map(|i| fur.hair(i)).collect();
        above += hairs.iter().map(|h| h.area() - h.area_below(block.height)).sum::<f64>();
        // Each layer adds the hairs in order, whatever the number of threads.
        layers.par_iter_mut().enumerate().for_each(|(l, layer)| {
            hairs.iter().for_each(|hair| layer.add(hair, l as u32, block, keep));
        });
    }
    let torus = f64::from(block.patch[0]) * f64::from(block.patch[1]);
    let optical_depth = layers.iter().map(|l| l.area / torus).collect();
    let finished: Vec<(Texture, Texture)> = layers.into_par_iter().map(|l| l.finish(width, height)).collect();
    let (layers, guard): (Vec<_>, Vec<_>) = finished.into_iter().unzip();
    Voxels { layers, guard: if split { guard } else { Vec::new() }, optical_depth, above: above / torus }
}

impl Layer {
    fn add(&mut self, hair: &Hair, l: u32, block: &Block, keep: Keep) {
        let [width, height] = block.resolution;
        let texel = Vec2::from(block.patch) / Vec2::new(width as f32, height as f32);
        let spacing = block.height / block.layers as f32;
        let root = Vec2::from(hair.root) * Vec2::new(width as f32, height as f32);
        let fraction = root - root.floor();
        let (mut color, mut sum, mut length, mut shown) = (Vec3::ZERO, 0.0, 0.0, 0.0);
        let stamp = &mut self.stamp;
        stamp.clear();
        let low = if l == 0 { f32::NEG_INFINITY } else { (l as f32 + 0.5 - REACH) * spacing };
        let high = ((l as f32 + 0.5 + REACH) * spacing).min(block.height);
        // Steps of at most 0.7 texels, or half the Gaussian of a thick hair, and a quarter of a
        // spacing.
        let cell = (0.7 * texel).max(Vec2::splat(0.125 * hair.thickest()));
        hair.steps(cell.extend(0.25 * spacing), low, high, |step| {
            let part = share((step.at.z / spacing).max(0.0), l, block.layers);
            let area = step.area * part / (texel.x * texel.y);
            if area > 0.0 {
                stamp.push(fraction + step.at.truncate() / texel, area);
                color += area * step.color;
                sum += area;
                shown += step.area * part;
                length += step.length * part;
            }
        });
        if sum <= 0.0 {
            return;
        }
        color /= sum;
        self.area += f64::from(sum) * f64::from(texel.x) * f64::from(texel.y);
        let diameter = Vec2::splat(shown / length.max(1e-20)) / texel;
        match keep {
            Keep::Depth => stamp.spread(sigma_of(diameter), None),
            Keep::Coverage => {
                stamp.spread(roomy_sigma(diameter, stamp.extent(), sum), None);
                stamp.cover();
            }
        }
        let wrap =
            |i: f32, k: usize, n: u32| (i as i64 + i64::from(stamp.origin[k])).rem_euclid(i64::from(n));
        let (first, mut row) =
            (wrap(root.x.floor(), 0, width) as usize, wrap(root.y.floor(), 1, height) as usize);
        for line in stamp.depth.chunks_exact(stamp.size[0]) {
            let start = row * width as usize;
            let mut column = first;
            for depth in line {
                let texel = &mut self.all[start + column];
                let add = (color * *depth).extend(*depth).to_array();
                (0..4).for_each(|k| texel[k] += add[k]);
                if hair.guard && !self.guard.is_empty() {
                    let texel = &mut self.guard[start + column];
                    (0..4).for_each(|k| texel[k] += add[k]);
                }
                column = if column + 1 == width as usize { 0 } else { column + 1 };
            }
            row = if row + 1 == height as usize { 0 } else { row + 1 };
        }
    }

    /// Converts depths to coverage; the guard hairs keep their fraction of the depth.
    fn finish(mut self, width: u32, height: u32) -> (Texture, Texture) {
        for (i, texel) in self.all.iter_mut().enumerate() {
            let depth = texel[3];
            let factor = if depth > 1e-12 { -(-depth).exp_m1() / depth } else { 1.0 };
            texel.iter_mut().for_each(|x| *x *= factor);
            if let Some(part) = self.guard.get_mut(i) {
                part.iter_mut().for_each(|x| *x *= factor);
            }
        }
        let texture = |texels| Texture { width, height, texels };
        (texture(self.all), texture(self.guard))
    }
}
