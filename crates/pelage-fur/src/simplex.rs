//! Simplex noise of the `noise` crate in double precision: the oracle for
//! `shaders/shared/noise.wgsl`.
// [Perlin2001], [Gustavson2005]

use glam::{Vec2, Vec3};
use noise::{NoiseFn, Simplex};

/// Simplex noise in two and three dimensions for one seed; values lie within about −1..1.
#[derive(Debug, Clone, Copy)]
pub struct Field(Simplex);

impl Field {
    /// The noise for `seed`; [`crate::groom::noise_tables`] packs the same for the GPU.
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
