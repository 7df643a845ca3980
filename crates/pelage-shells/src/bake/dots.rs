//! Layers of random dots: the same dots in every layer, but fewer in higher layers.
// [Xbdev]

use super::Texture;
use super::voxels::{Block, Voxels};
use pelage_core::scene::{DotProfile, Dots};
use pelage_fur::random::{hash2, random};
use rayon::prelude::*;

/// A hair, seen as a dot in each layer.
struct Dot {
    /// Lowest `[column, row]` of its square.
    at: [u32; 2],
    /// Linear RGB at the tip of the fur.
    color: [f32; 3],
}

/// The dots of a block.
pub(super) struct DotFur<'a> {
    dots: &'a Dots,
    block: Block,
    hairs: Vec<Dot>,
}

/// Fraction, at height `l` in 0..1, of the dots by which the base exceeds the tip.
fn profile(profile: DotProfile, l: f32) -> f32 {
    let r = 1.0 - l;
    match profile {
        DotProfile::Linear => r,
        DotProfile::Power2 => r * r,
        DotProfile::Power3 => r * r * r,
        DotProfile::Mixed => 0.5 * (r + r.powi(5)),
    }
}

impl<'a> DotFur<'a> {
    /// The dots that `dots` describes, on the texels of `block`.
    pub fn new(dots: &'a Dots, block: Block, seed: u32) -> Self {
        // The tutorial reseeds its generator for each layer to the same effect: hair i is the same
        // in all layers.
        let hairs = (0..dots.base.max(dots.tip))
            .map(|i| {
                let h = hash2(hash2(seed, 0x646f_7473), i);
                let cell = |k: u32| {
                    let n = block.resolution[k as usize];
                    ((random(h, k) * n as f32) as u32).min(n - 1)
                };
                let pick = |k: usize| {
                    let [low, high] = dots.color[k];
                    low + (high - low) * random(h, 2 + k as u32)
                };
                Dot { at: [cell(0), cell(1)], color: [pick(0), pick(1), pick(2)] }
            })
            .collect();
        Self { dots, block, hairs }
    }

    /// Height of a layer: 0 innermost, 1 outermost.
    fn level(&self, layer: u32) -> f32 {
        if self.block.layers > 1 { layer as f32 / (self.block.layers - 1) as f32 } else { 0.0 }
    }

    /// Number of dots in a layer.
    fn count(&self, layer: u32) -> usize {
        let (base, tip) = (self.dots.base as f32, self.dots.tip as f32);
        (tip + (base - tip) * profile(self.dots.profile, self.level(layer))).round() as usize
    }

    /// Brightness of a layer; the base is darker than the tip.
    fn brightness(&self, layer: u32) -> f32 {
        let dark = self.dots.root_brightness;
        dark + (1.0 - dark) * self.level(layer)
    }

    /// Draws the layers.
    pub fn layers(&self) -> Voxels {
        let [width, height] = self.block.resolution;
        let layer = |l: u32| {
            let mut texels = vec![[0.0; 4]; width as usize * height as usize];
            let light = self.brightness(l);
            // The hairs that reach highest are drawn last, so that no hair changes its colour from
            // layer to layer.
            for dot in self.hairs.iter().take(self.count(l)).rev() {
                let [r, g, b] = dot.color.map(|c| c * light);
                for (j, i) in (0..self.dots.size).flat_map(|j| (0..self.dots.size).map(move |i| (j, i))) {
                    let (x, y) = ((dot.at[0] + i) % width, (dot.at[1] + j) % height);
                    texels[(y * width + x) as usize] = [r, g, b, 1.0];
                }
            }
            Texture { width, height, texels }
        };
        let layers = (0..self.block.layers).into_par_iter().map(layer).collect();
        // A dot is a piece of hair as thick as the dot's edge and as long as the spacing of layers.
        let edge = f64::from(self.block.patch[0]) / f64::from(width) * f64::from(self.dots.size);
        let spacing = f64::from(self.block.height) / f64::from(self.block.layers);
        let torus = f64::from(self.block.patch[0]) * f64::from(self.block.patch[1]);
        let optical_depth =
            (0..self.block.layers).map(|l| self.count(l) as f64 * edge * spacing / torus).collect();
        Voxels { layers, guard: Vec::new(), optical_depth, above: 0.0 }
    }

    /// Draws the columns of dots in the first `slab` of the torus along v (as a fraction of its
    /// edge), seen along v; columns in front cover those behind.
    pub fn fin(&self, [width, height]: [u32; 2], slab: f32) -> Texture {
        let [columns, rows] = self.block.resolution;
        let deep = (slab * rows as f32).ceil() as u32;
        let mut order: Vec<usize> = (0..self.hairs.len()).filter(|i| self.hairs[*i].at[1] < deep).collect();
        order.sort_by_key(|i| std::cmp::Reverse((self.hairs[*i].at[1], *i)));
        let mut texels = vec![[0.0f32; 4]; width as usize * height as usize];
        let scale = width as f32 / columns as f32;
        texels.par_chunks_mut(width as usize).enumerate().for_each(|(row, line)| {
            let t = (row as f32 + 0.5) / height as f32;
            let l = ((t * self.block.layers as f32) as u32).min(self.block.layers - 1);
            let (count, light) = (self.count(l), self.brightness(l));
            for i in order.iter().filter(|i| **i < count) {
                let dot = &self.hairs[*i];
                let left = dot.at[0] as f32 * scale;
                let right = left + self.dots.size as f32 * scale;
                for x in left.floor() as i64..right.ceil() as i64 {
                    // Fraction of the texel that the column covers.
                    let alpha = (right.min((x + 1) as f32) - left.max(x as f32)).clamp(0.0, 1.0);
                    let texel = &mut line[x.rem_euclid(i64::from(width)) as usize];
                    let [r, g, b] = dot.color.map(|c| c * light);
                    let add = [r, g, b, 1.0];
                    (0..4).for_each(|k| texel[k] = alpha * add[k] + (1.0 - alpha) * texel[k]);
                }
            }
        });
        Texture { width, height, texels }
    }
}
