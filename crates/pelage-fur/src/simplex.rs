//! Simplex noise of the `noise` crate in double precision: the oracle for
//! `shaders/shared/noise.wgsl`.
// [Perlin2001], [Gustavson2005]

use crate::layout::Noise;
use glam::{Vec2, Vec3};
use noise::permutationtable::{NoiseHasher, PermutationTable};
use noise::{NoiseFn, Simplex};

/// Simplex noise in two and three dimensions for one seed; values lie within about −1..1.
#[derive(Debug, Clone, Copy)]
pub struct Field(Simplex);

impl Field {
    /// The noise for `seed`; [`noise_tables`] packs the same for the GPU.
    pub fn new(seed: u32) -> Self {
        Self(Simplex::new(seed))
    }

    /// Noise in two dimensions.
    #[inline]
    pub fn simplex2(&self, p: Vec2) -> f32 {
        self.0.get([f64::from(p.x), f64::from(p.y)]) as f32
    }

    /// Noise in three dimensions.
    #[inline]
    pub fn simplex3(&self, p: Vec3) -> f32 {
        self.0.get([f64::from(p.x), f64::from(p.y), f64::from(p.z)]) as f32
    }
}

/// The tables of the `noise` crate's simplex noise for a seed, as `shaders/shared/noise.wgsl` reads
/// them.
pub fn noise_tables(seed: u32) -> Noise {
    let table = PermutationTable::new(seed);
    let mut permutation = [[0u32; 4]; 16];
    for i in 0..256usize {
        permutation[i / 16][(i / 4) % 4] |= (table.hash(&[i as isize]) as u32) << (8 * (i % 4));
    }
    let d = std::f32::consts::FRAC_1_SQRT_2;
    let gradients2 = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [d, d], [-d, d], [d, -d], [-d, -d]]
        .map(|[x, y]| [x, y, 0.0, 0.0]);
    let mut gradients3 = [[0.0f32; 4]; 32];
    for (i, g) in gradients3.iter_mut().enumerate() {
        // The twelve edges of the cube, twice, then its eight corners.
        let sign = |bit: usize| if i & bit == 0 { 1.0 } else { -1.0 };
        *g = if i >= 24 {
            let c = 1.0 / 3f32.sqrt();
            [sign(1) * c, sign(2) * c, sign(4) * c, 0.0]
        } else {
            let e = i % 12;
            let (a, b) = (if e & 1 == 0 { d } else { -d }, if e & 2 == 0 { d } else { -d });
            match e / 4 {
                0 => [a, b, 0.0, 0.0],
                1 => [a, 0.0, b, 0.0],
                _ => [0.0, a, b, 0.0],
            }
        };
    }
    Noise { permutation, gradients2, gradients3 }
}

#[cfg(test)]
mod tests {
    use super::noise_tables;

    #[test]
    fn noise_gradients_are_units_and_balanced() {
        let tables = noise_tables(7);
        let mut sum = [0.0f32; 3];
        for g in tables.gradients3 {
            let norm: f32 = g.iter().map(|x| x * x).sum();
            assert!((norm - 1.0).abs() < 1e-6);
            (0..3).for_each(|k| sum[k] += g[k]);
        }
        assert!(sum.iter().all(|s| s.abs() < 1e-5), "{sum:?}");
    }
}
