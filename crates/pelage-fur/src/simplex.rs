//! Oracle of `shaders/shared/noise.wgsl`: the `noise` crate's simplex noise itself, in double precision.

use glam::{Vec2, Vec3};
use noise::{NoiseFn, Simplex};

/// Simplex noise in two and three dimensions for a seed; about -1..1.
#[derive(Debug, Clone, Copy)]
pub struct Field(Simplex);

impl Field {
    /// The noise for a seed, as [`crate::groom::noise_tables`] packs it for the GPU.
    pub fn new(seed: u32) -> Self {
        Self(Simplex::new(seed))
    }

    /// Noise in the plane.
    #[inline]
    pub fn simplex2(&self, p: Vec2) -> f32 {
        self.0.get([f64::from(p.x), f64::from(p.y)]) as f32
    }

    /// Noise in space.
    #[inline]
    pub fn simplex3(&self, p: Vec3) -> f32 {
        self.0.get([f64::from(p.x), f64::from(p.y), f64::from(p.z)]) as f32
    }
}
