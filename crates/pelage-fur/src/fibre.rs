//! Scattering of light by one hair: the models that strands, volume and path tracer share.
//!
//! Directions are given in the fibre's frame: x along the tangent from root to tip, so that `sin θ = w.x` and
//! `φ = atan2(w.z, w.y)`; both directions leave the hair. A model is a function f with
//! `L_o = ∫ f(ω_i, ω_o) L_i cos θ_i dω_i`; it loses nothing where `∫ f cos θ_i dω_i = 1` for every ω_o.
//!
//! Chiang's model and that of hairs with a medulla scatter by the offset across the fibre, and by the eye's inclination: seen the
//! other way round they are not the same. The others are far fields by themselves.

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
    /// A diffuse term and a highlight.
    KajiyaKay(KajiyaKay),
    /// Lobes by the artist's choice, normalised or not.
    Sadeghi(Sadeghi),
    /// A rough dielectric cylinder.
    Chiang(Chiang),
    /// A cortex around a medulla that scatters.
    Medulla(Medulla),
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

/// Two directions as the models see them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles {
    /// Sine and cosine of the inclination of the light.
    pub i: [f32; 2],
    /// Of the eye.
    pub o: [f32; 2],
    /// Azimuth of the light less that of the eye, -π..π.
    pub phi: f32,
}

fn inclination(sin: f32) -> [f32; 2] {
    let sin = sin.clamp(-1.0, 1.0);
    [sin, (1.0 - sin * sin).max(0.0).sqrt()]
}

impl Angles {
    /// Of directions in the fibre's frame.
    pub fn new(wi: Vec3, wo: Vec3) -> Self {
        let phi = lobes::wrap(wi.z.atan2(wi.y) - wo.z.atan2(wo.y));
        Self { i: inclination(wi.x), o: inclination(wo.x), phi }
    }

    /// Of a light `l` and an eye `v` around a hair of unit tangent `tangent`, all in one space; the azimuth without its sign, as
    /// far fields are even in it.
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

/// Offsets at which a far field is a mean: even steps of the angle of incidence on the cross section.
const FAR_STEPS: u32 = 200;

/// Offsets h with weights that sum to 1.
pub fn offsets(steps: u32) -> impl Iterator<Item = (f32, f32)> {
    let step = PI / steps as f32;
    let whole = 1.0 / (0.5 * step).sin() * step; // of the sum of the cosines, 2 in the limit
    (0..steps).map(move |k| {
        let gamma = (k as f32 + 0.5) * step - FRAC_PI_2;
        (gamma.sin(), gamma.cos() * step / whole)
    })
}

impl Fibre {
    /// The model of a scene's table, for a layer whose table may leave it open; `shading = "paper"` has the layer's own.
    pub fn new(spec: &FibreSpec, layer: Layer, paper: bool) -> Self {
        let usual = match layer {
            Layer::Guard => FibreModel::Sadeghi,
            Layer::Undercoat => FibreModel::KajiyaKay,
        };
        let model = if paper { usual } else { spec.model.unwrap_or(usual) };
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

    /// That of the guard hairs of a scene.
    pub fn guard(scene: &Scene) -> Self {
        Self::new(&scene.guard.fibre, Layer::Guard, scene.render.shading == Shading::Paper)
    }

    /// That of a scene's undercoat.
    pub fn undercoat(scene: &Scene) -> Self {
        Self::new(&scene.undercoat.fibre, Layer::Undercoat, scene.render.shading == Shading::Paper)
    }

    /// f(ω_i, ω_o), without the cosine, 1/sr.
    pub fn evaluate(&self, hit: &Hit, wi: Vec3, wo: Vec3) -> Vec3 {
        let a = Angles::new(wi, wo);
        self.scatter(hit, &a) / a.i[1].max(1e-6)
    }

    /// f cos θ_i: what the hair sends to the eye for an irradiance of 1 across the light.
    pub fn scatter(&self, hit: &Hit, a: &Angles) -> Vec3 {
        match self {
            Self::KajiyaKay(model) => model.color(hit) * model.scatter(a),
            Self::Sadeghi(model) => model.scatter(hit, a),
            Self::Chiang(model) => model.scatter(hit, a),
            Self::Medulla(model) => model.scatter(hit, a),
        }
    }

    /// Whether the model depends on the offset across the fibre.
    pub fn is_near_field(&self) -> bool {
        matches!(self, Self::Chiang(_) | Self::Medulla(_))
    }

    /// [`Fibre::evaluate`], the mean over the offset h: a fibre too thin to see across.
    pub fn far_field(&self, hit: &Hit, wi: Vec3, wo: Vec3) -> Vec3 {
        let a = Angles::new(wi, wo);
        self.scatter_far(hit, &a) / a.i[1].max(1e-6)
    }

    /// [`Fibre::scatter`], the mean over the offset h.
    pub fn scatter_far(&self, hit: &Hit, a: &Angles) -> Vec3 {
        if !self.is_near_field() {
            return self.scatter(hit, a);
        }
        // Light from the other side and an offset to the other side is the same.
        offsets(FAR_STEPS)
            .filter(|(h, _)| *h > 0.0)
            .map(|(h, weight)| {
                let hit = Hit { h, ..*hit };
                weight * (self.scatter(&hit, a) + self.scatter(&hit, &a.mirrored()))
            })
            .sum()
    }

    /// Draws ω_i for ω_o with four random numbers in 0..1.
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
