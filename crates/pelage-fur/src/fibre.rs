//! Scattering of light by a single hair: the models shared by strands, volume and path tracer.
//!
//! Directions are given in the fibre's frame, x along the tangent from root to tip, so that
//! `sin θ = w.x` and `φ = atan2(w.z, w.y)`. Both directions leave the hair: ω_i towards the light,
//! ω_o towards the viewer. A model is a function f with `L_o = ∫ f(ω_i, ω_o) L_i cos θ_i dω_i`; it
//! is lossless if `∫ f cos θ_i dω_i = 1` for every ω_o.
//!
//! Chiang's model and the one of hairs with a medulla depend on the offset h across the fibre (near
//! field) and are not reciprocal: their parameters follow the inclination of ω_o. The others are
//! far-field models.

mod chiang;
mod kajiya_kay;
pub mod lobes;
pub mod medulla;
mod packed;
mod sadeghi;
pub mod table;

pub use chiang::{Absorption, Chiang, DARKEST, azimuthal_scale, longitudinal_variance};
pub use kajiya_kay::KajiyaKay;
pub use medulla::Medulla;
pub use packed::MODELS;
pub use sadeghi::Sadeghi;
pub use table::{Albedos, FarTable, Hemisphere, Hemispheres};

use crate::Layer;
use glam::Vec3;
use pelage_core::scene::{FibreModel, FibreSpec, Scene, Shading};
use std::f32::consts::{FRAC_PI_2, PI};

/// A scattering model with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub enum Fibre {
    /// A diffuse term and a specular highlight.
    KajiyaKay(KajiyaKay),
    /// Lobes set by the artist, normalised or not.
    Sadeghi(Sadeghi),
    /// A rough dielectric cylinder.
    Chiang(Chiang),
    /// A cortex around a scattering medulla.
    Medulla(Medulla),
}

/// The colour of a hair and the place where it is hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Colour of the hair, linear RGB, 0..1.
    pub tint: Vec3,
    /// Azimuth of the strand's glints relative to ω_o, radians.
    pub glint_angle: f32,
    /// Offset across the fibre, −1..1: the sine of the azimuth of ω_o minus that of the surface
    /// normal. Near-field models depend on it; their mean over h is the far field.
    pub h: f32,
}

/// A sampled direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Direction towards the light, unit, in the fibre's frame.
    pub direction: Vec3,
    /// Probability density with respect to solid angle, 1/sr.
    pub pdf: f32,
    /// f cos θ_i / pdf.
    pub weight: Vec3,
}

/// A pair of directions, as the models use them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles {
    /// Sine and cosine of the inclination θ_i of the light.
    pub i: [f32; 2],
    /// Sine and cosine of the inclination θ_o of the view direction.
    pub o: [f32; 2],
    /// Azimuth of the light minus that of the view direction, −π..π.
    pub phi: f32,
}

fn inclination(sin: f32) -> [f32; 2] {
    let sin = sin.clamp(-1.0, 1.0);
    [sin, (1.0 - sin * sin).max(0.0).sqrt()]
}

impl Angles {
    /// From directions in the fibre's frame.
    pub fn new(wi: Vec3, wo: Vec3) -> Self {
        let phi = lobes::wrap(wi.z.atan2(wi.y) - wo.z.atan2(wo.y));
        Self { i: inclination(wi.x), o: inclination(wo.x), phi }
    }

    /// From directions `l` to the light and `v` to the viewer around a hair of unit tangent
    /// `tangent`, all in one space. The azimuth has no sign, because far fields are even in it.
    pub fn around(tangent: Vec3, l: Vec3, v: Vec3) -> Self {
        let (i, o) = (inclination(tangent.dot(l)), inclination(tangent.dot(v)));
        let (lp, vp) = (l - i[0] * tangent, v - o[0] * tangent);
        let lengths = (lp.length_squared() * vp.length_squared()).max(1e-12).sqrt();
        Self { i, o, phi: (lp.dot(vp) / lengths).clamp(-1.0, 1.0).acos() }
    }

    fn mirrored(self) -> Self {
        Self { phi: -self.phi, ..self }
    }
}

/// Number of offsets over which a far field is averaged: even steps of the angle of incidence on
/// the cross section.
const FAR_STEPS: u32 = 200;

/// Offsets h in −1..1 with weights that sum to 1.
pub fn offsets(steps: u32) -> impl Iterator<Item = (f32, f32)> {
    let step = PI / steps as f32;
    let whole = 1.0 / (0.5 * step).sin() * step; // Sum of the cosines, 2 in the limit.
    (0..steps).map(move |k| {
        let gamma = (k as f32 + 0.5) * step - FRAC_PI_2;
        (gamma.sin(), gamma.cos() * step / whole)
    })
}

impl Fibre {
    /// The model that a fibre table of the scene describes, for a layer whose table may leave the
    /// model open. With `paper` the model is the default of the layer.
    pub fn new(spec: &FibreSpec, layer: Layer, paper: bool) -> Self {
        let default = match layer {
            Layer::Guard => FibreModel::Sadeghi,
            Layer::Undercoat => FibreModel::KajiyaKay,
        };
        let model = if paper { default } else { spec.model.unwrap_or(default) };
        let absorption = spec.absorption.map(Vec3::from);
        let sadeghi = || Sadeghi {
            intensity: spec.intensity,
            shift: spec.shift.map(f32::to_radians),
            width: spec.width.map(f32::to_radians),
            azimuth_tt: spec.azimuth_tt.to_radians(),
            glint: spec.glint[0],
            glint_width: spec.glint[1].to_radians(),
            diffuse: spec.diffuse.unwrap_or(0.7),
            albedo: None,
        };
        match model {
            FibreModel::KajiyaKay => Self::KajiyaKay(KajiyaKay::new(
                spec.diffuse.unwrap_or(1.0),
                spec.specular,
                spec.specular_exponent,
            )),
            FibreModel::Sadeghi => Self::Sadeghi(sadeghi()),
            FibreModel::SadeghiNormalised => Self::Sadeghi(sadeghi().normalised()),
            FibreModel::Chiang => {
                Self::Chiang(Chiang::new(spec.roughness, spec.tilt.to_radians(), spec.ior, absorption))
            }
            FibreModel::Medulla => {
                let m = &spec.medulla;
                let parts = medulla::Parts {
                    ior: spec.ior,
                    tilt: spec.tilt.to_radians(),
                    layers: m.layers,
                    absorption: absorption.map_or_else(|| Absorption::by_color(0.3), Absorption::Fixed),
                    radius: m.radius,
                    scattering: m.scattering,
                    medulla_absorption: m.absorption,
                    anisotropy: m.anisotropy,
                    width: m.width.map(f32::to_radians),
                };
                Self::Medulla(Medulla::new(parts, medulla::scatter::cache_folder().as_deref()))
            }
        }
    }

    /// The model of a scene's guard hairs.
    pub fn guard(scene: &Scene) -> Self {
        Self::new(&scene.guard.fibre, Layer::Guard, scene.render.shading == Shading::Paper)
    }

    /// The model of a scene's undercoat.
    pub fn undercoat(scene: &Scene) -> Self {
        Self::new(&scene.undercoat.fibre, Layer::Undercoat, scene.render.shading == Shading::Paper)
    }

    /// f(ω_i, ω_o) without the cosine, 1/sr.
    pub fn evaluate(&self, hit: &Hit, wi: Vec3, wo: Vec3) -> Vec3 {
        let a = Angles::new(wi, wo);
        self.scatter(hit, &a) / a.i[1].max(1e-6)
    }

    /// f cos θ_i: radiance towards the viewer per unit irradiance perpendicular to the light.
    pub fn scatter(&self, hit: &Hit, a: &Angles) -> Vec3 {
        match self {
            Self::KajiyaKay(model) => model.color(hit) * model.scatter(a),
            Self::Sadeghi(model) => model.scatter(hit, a),
            Self::Chiang(model) => model.scatter(hit, a),
            Self::Medulla(model) => model.scatter(hit, a),
        }
    }

    /// Whether the model depends on the offset h.
    pub fn is_near_field(&self) -> bool {
        matches!(self, Self::Chiang(_) | Self::Medulla(_))
    }

    /// The mean of [`Fibre::evaluate`] over the offset h, for a fibre too thin to resolve.
    pub fn far_field(&self, hit: &Hit, wi: Vec3, wo: Vec3) -> Vec3 {
        let a = Angles::new(wi, wo);
        self.scatter_far(hit, &a) / a.i[1].max(1e-6)
    }

    /// The mean of [`Fibre::scatter`] over the offset h.
    pub fn scatter_far(&self, hit: &Hit, a: &Angles) -> Vec3 {
        if !self.is_near_field() {
            return self.scatter(hit, a);
        }
        // Mirroring the offset is equivalent to mirroring the azimuth of the light.
        offsets(FAR_STEPS)
            .filter(|(h, _)| *h > 0.0)
            .map(|(h, weight)| {
                let hit = Hit { h, ..*hit };
                weight * (self.scatter(&hit, a) + self.scatter(&hit, &a.mirrored()))
            })
            .sum()
    }

    /// Samples ω_i for a given ω_o from four uniform numbers in 0..1; `None` where the density
    /// vanishes.
    pub fn sample(&self, hit: &Hit, wo: Vec3, u: [f32; 4]) -> Option<Sample> {
        let o = inclination(wo.x);
        let (sin, phi) = match self {
            Self::KajiyaKay(model) => model.sample(hit, o, u),
            Self::Sadeghi(model) => model.sample(hit, o, u),
            Self::Chiang(model) => model.sample(hit, o, u),
            Self::Medulla(model) => model.sample(hit, o, u),
        };
        let i = inclination(sin);
        let around = wo.z.atan2(wo.y) + phi;
        let direction = Vec3::new(i[0], i[1] * around.cos(), i[1] * around.sin());
        let a = Angles { i, o, phi };
        let pdf = self.density(hit, &a);
        (pdf > 1e-12 && pdf.is_finite()).then(|| Sample {
            direction,
            pdf,
            weight: self.scatter(hit, &a) / pdf,
        })
    }

    /// Probability density of [`Fibre::sample`], 1/sr.
    pub fn pdf(&self, hit: &Hit, wi: Vec3, wo: Vec3) -> f32 {
        self.density(hit, &Angles::new(wi, wo))
    }

    fn density(&self, hit: &Hit, a: &Angles) -> f32 {
        match self {
            Self::KajiyaKay(model) => model.pdf(hit, a),
            Self::Sadeghi(model) => model.pdf(hit, a),
            Self::Chiang(model) => model.pdf(hit, a),
            Self::Medulla(model) => model.pdf(hit, a),
        }
    }
}

/// Azimuth of a hair's glints, 30 to 45 degrees by a uniform number, radians.
// [Sadeghi2010]
pub fn glint_angle(u: f32) -> f32 {
    (30.0 + 15.0 * u).to_radians()
}
