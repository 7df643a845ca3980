//! Scattering at a point of the skin or of an object.

use glam::{Vec3, Vec3A};
use pelage_fur::material::Material;
use std::f32::consts::{PI, TAU};

/// Shading data of a surface where it is met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceShading {
    /// How it scatters.
    pub scattering: Scattering,
    /// Smoothed normal, unit; of an object, on the side of the ray.
    pub normal: Vec3,
    /// Normal of the triangle, unit, on the same side.
    pub geometric_normal: Vec3,
    /// Where rays leave, cm: just off the triangle.
    pub position: Vec3A,
}

/// How a surface scatters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scattering {
    /// Skin: Lambertian with this reflectance, linear RGB in 0..1.
    Skin(Vec3),
    /// An object.
    Object(Material),
    /// A black surface on which only shadows are seen.
    ShadowCatcher,
}

impl SurfaceShading {
    /// Whether it is an object's.
    pub fn is_object(&self) -> bool {
        !matches!(self.scattering, Scattering::Skin(_))
    }

    /// Colour, linear RGB in 0..1.
    pub fn albedo(&self) -> Vec3 {
        match self.scattering {
            Scattering::Skin(reflectance) => reflectance,
            Scattering::Object(material) => material.color,
            Scattering::ShadowCatcher => Vec3::ZERO,
        }
    }

    /// Scattering from `direction` to `view` (unit vectors away from the surface), times the cosine
    /// of incidence, 1/sr. `spread` as from
    /// [`pelage_fur::material::spreads`].
    pub fn scatter(&self, view: Vec3, direction: Vec3, spread: f32) -> Vec3 {
        match self.scattering {
            Scattering::Skin(reflectance) => {
                if self.geometric_normal.dot(direction) <= 0.0 {
                    return Vec3::ZERO;
                }
                reflectance * (self.normal.dot(direction).max(0.0) / PI)
            }
            Scattering::Object(material) => {
                let cosine = self.normal.dot(direction).max(0.0);
                material.evaluate(self.normal, view, direction, spread) * cosine
            }
            Scattering::ShadowCatcher => Vec3::ZERO,
        }
    }

    /// Probability density with which [`SurfaceShading::sample`] draws a direction, 1/sr.
    pub fn pdf(&self, view: Vec3, direction: Vec3) -> f32 {
        match self.scattering {
            Scattering::Object(material) => material.pdf(self.normal, view, direction),
            Scattering::Skin(_) | Scattering::ShadowCatcher => self.normal.dot(direction).max(0.0) / PI,
        }
    }

    /// Samples a direction towards the light: the direction, its density (1/sr), and the weight of
    /// radiance from there.
    pub fn sample(&self, view: Vec3, u: [f32; 4]) -> Option<(Vec3, f32, Vec3)> {
        match self.scattering {
            Scattering::Object(material) => material.sample(self.normal, view, [u[0], u[1], u[2]]),
            Scattering::Skin(reflectance) => {
                let (side, other) = self.normal.any_orthonormal_pair();
                let (sin, cos) = (TAU * u[1]).sin_cos();
                let r = u[0].sqrt();
                let height = (1.0 - u[0]).max(0.0).sqrt();
                let direction = (r * cos * side + r * sin * other + height * self.normal).normalize();
                let leaves = self.geometric_normal.dot(direction) > 0.0;
                leaves.then_some((direction, height / PI, reflectance))
            }
            Scattering::ShadowCatcher => None,
        }
    }
}
