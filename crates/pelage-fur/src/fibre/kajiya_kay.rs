//! Kajiya and Kay's model: a diffuse term and a highlight around the mirror cone.
// [KajiyaKay1989]

use super::{Angles, Hit};
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Weights and exponent of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KajiyaKay {
    /// Weight of the diffuse term, lossless at 1.
    pub diffuse: f32,
    /// Weight of the specular term.
    pub specular: f32,
    /// Its exponent.
    pub exponent: f32,
    /// Integral of cos^exponent over −π/2..π/2.
    area: f32,
}

impl KajiyaKay {
    /// The model with the given weights and exponent.
    pub fn new(diffuse: f32, specular: f32, exponent: f32) -> Self {
        let steps = 4000;
        let sum: f64 = (0..steps)
            .map(|i| ((f64::from(i) + 0.5) / f64::from(steps) * std::f64::consts::FRAC_PI_2).sin())
            .map(|cos| cos.powf(f64::from(exponent)))
            .sum();
        let area = (sum * std::f64::consts::PI / f64::from(steps)) as f32;
        Self { diffuse, specular, exponent, area }
    }

    /// f cos θ_i for a hair of colour 1.
    // [KajiyaKay1989]; both directions leave the hair, so the mirror cone is at θ_i = −θ_o.
    pub fn scatter(&self, a: &Angles) -> f32 {
        let mut value = self.diffuse / (PI * PI) * a.i[1];
        if self.specular > 0.0 {
            let mirror = a.i[1] * a.o[1] - a.i[0] * a.o[0];
            value += self.specular * mirror.max(0.0).powf(self.exponent) / TAU;
        }
        value
    }

    fn diffuse_share(&self) -> f32 {
        let diffuse = self.diffuse.max(1e-6);
        diffuse / (diffuse + self.specular * self.area)
    }

    /// Samples the sine of θ_i and the azimuth.
    pub(super) fn sample(&self, _hit: &Hit, o: [f32; 2], u: [f32; 4]) -> (f32, f32) {
        let phi = TAU * u[2] - PI;
        if u[3] < self.diffuse_share() {
            return (diffuse_sample([u[0], u[1]]), phi);
        }
        // A marginal of the disc with density (1 − r²)^(p/2 − 1) is proportional to a power of the
        // cosine.
        let s = (1.0 - u[0].powf(2.0 / self.exponent)).max(0.0).sqrt() * (TAU * u[1]).cos();
        // An angle beyond the pole continues on the other side.
        ((s.clamp(-1.0, 1.0).asin() - o[0].asin()).sin(), phi)
    }

    /// Density of [`KajiyaKay::sample`], 1/sr.
    pub(super) fn pdf(&self, _hit: &Hit, a: &Angles) -> f32 {
        let q = self.diffuse_share();
        let (theta_i, theta_o) = (a.i[0].asin(), a.o[0].asin());
        let lobe = |d: f32| if d.abs() < FRAC_PI_2 { d.cos().powf(self.exponent) } else { 0.0 };
        let around = lobe(theta_i + theta_o) + lobe(PI - theta_i + theta_o) + lobe(-PI - theta_i + theta_o);
        q * diffuse_pdf(a.i[1]) + (1.0 - q) * around / (self.area * TAU * a.i[1].max(1e-6))
    }

    /// The colour of the hair, unchanged.
    pub(super) fn color(&self, hit: &Hit) -> Vec3 {
        hit.tint
    }
}

/// Samples the sine of an inclination with density cos² θ: a marginal of the uniform disc.
pub(super) fn diffuse_sample(u: [f32; 2]) -> f32 {
    u[0].sqrt() * (TAU * u[1]).cos()
}

/// Density of [`diffuse_sample`] with a uniform azimuth, 1/sr.
pub(super) fn diffuse_pdf(cos: f32) -> f32 {
    cos / (PI * PI)
}
