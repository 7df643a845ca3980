//! Scattering of light by one hair: the models that strands, volume and path tracer share.
//!
//! Directions are given in the fibre's frame: x along the tangent from root to tip, so that `sin θ = w.x` and
//! `φ = atan2(w.z, w.y)`; both directions leave the hair. A model is a function f with
//! `L_o = ∫ f(ω_i, ω_o) L_i cos θ_i dω_i`; it loses nothing where `∫ f cos θ_o dω_o = 1`.

use glam::Vec3;
use std::f32::consts::PI;

/// A scattering model with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub enum Fibre {
    /// The diffuse term of Kajiya and Kay 1989, lossless for a white hair.
    Diffuse,
}

/// Where and how coloured a hair is hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Colour of the hair, linear RGB, 0..1.
    pub tint: Vec3,
    /// Azimuth of the strand's glints, radians.
    pub glint_angle: f32,
    /// Offset across the fibre, -1..1: the sine of the azimuth of ω_o less that of the surface normal. Models of thick
    /// fibres scatter by it; their mean over h is the far field.
    pub h: f32,
}

/// A sampled direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Towards the light, unit, in the fibre's frame.
    pub direction: Vec3,
    /// Probability density per solid angle.
    pub pdf: f32,
    /// f cos θ_i / pdf.
    pub weight: Vec3,
}

impl Fibre {
    /// f(ω_i, ω_o), without the cosine, 1/sr.
    pub fn evaluate(&self, hit: &Hit, _wi: Vec3, _wo: Vec3) -> Vec3 {
        match self {
            Self::Diffuse => hit.tint / (PI * PI),
        }
    }

    /// Draws ω_i for ω_o with four random numbers in 0..1.
    pub fn sample(&self, hit: &Hit, _wo: Vec3, u: [f32; 4]) -> Option<Sample> {
        let sin = 2.0 * u[0] - 1.0;
        let cos = (1.0 - sin * sin).max(0.0).sqrt();
        let (y, z) = (2.0 * PI * u[1]).sin_cos();
        let pdf = 0.25 / PI;
        Some(Sample {
            direction: Vec3::new(sin, cos * z, cos * y),
            pdf,
            weight: hit.tint / (PI * PI) * cos / pdf,
        })
    }

    /// Probability density of [`Fibre::sample`], 1/sr.
    pub fn pdf(&self, _hit: &Hit, _wi: Vec3, _wo: Vec3) -> f32 {
        0.25 / PI
    }
}
