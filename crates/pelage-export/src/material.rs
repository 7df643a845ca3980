//! Hair scattering by the parameters of the model of Chiang et al. 2016, which other renderers
//! have.

pub use pelage_fur::fibre::DARKEST;

use glam::Vec3;
use pelage_core::Scene;
use pelage_core::scene::{FibreModel, Shading};
use pelage_fur::Layer;
use pelage_fur::fibre::Absorption;
use pelage_fur::fibre::{azimuthal_scale, longitudinal_variance};
use std::f32::consts::PI;

/// Parameters of a hair in Chiang's model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HairMaterial {
    /// Absorption along a path of one hair radius, for linear RGB.
    pub absorption: Vec3,
    /// Longitudinal roughness, 0..1.
    pub beta_m: f32,
    /// Azimuthal roughness, 0..1.
    pub beta_n: f32,
    /// Tilt of the cuticle scales, degrees.
    pub alpha_degrees: f32,
    /// Refractive index, relative to air.
    pub ior: f32,
}

/// Material of a layer's hairs.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerMaterial {
    /// Parameters of all hairs; the absorption applies only if `colored` is false.
    pub hair: HairMaterial,
    /// Whether absorption follows from each hair's colour.
    pub colored: bool,
    /// How it differs from the scene's own model, if it does.
    pub approximates: Option<String>,
}

impl LayerMaterial {
    /// Absorption of a hair of colour `color`.
    pub fn absorption(&self, color: Vec3) -> Vec3 {
        if self.colored { absorption_of(color, self.hair.beta_n) } else { self.hair.absorption }
    }
}

/// The denominator of Chiang's fit of absorption to colour, for the azimuthal roughness `beta_n`.
// [Chiang2016] eq. 9
pub fn fit(beta_n: f32) -> f32 {
    Absorption::divisor(beta_n)
}

/// Absorption along a radius with which a mass of such hairs has about the colour `color`, linear
/// RGB, clamped to [`DARKEST`]..1.
// [Chiang2016] eq. 9
pub fn absorption_of(color: Vec3, beta_n: f32) -> Vec3 {
    Absorption::by_color(beta_n).of(color)
}

/// Inverse of the increasing function `f` on 0..1, by bisection.
fn inverse(f: impl Fn(f32) -> f32, wanted: f32) -> f32 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if f(middle) < wanted { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The longitudinal roughness whose reflection has the standard deviation `sigma`, radians.
pub fn beta_m_of(sigma: f32) -> f32 {
    inverse(longitudinal_variance, sigma * sigma)
}

/// The azimuthal roughness whose logistic distribution has the standard deviation `sigma`, radians.
pub fn beta_n_of(sigma: f32) -> f32 {
    inverse(azimuthal_scale, sigma * 3f32.sqrt() / PI)
}

/// The material of a layer of `scene`.
pub fn of(scene: &Scene, layer: Layer) -> LayerMaterial {
    let (spec, whose, usual) = match layer {
        Layer::Guard => (&scene.guard.fibre, "guard hairs", FibreModel::Sadeghi),
        Layer::Undercoat => (&scene.undercoat.fibre, "the undercoat's hairs", FibreModel::KajiyaKay),
    };
    let paper = scene.render.shading == Shading::Paper;
    let model = spec.model.filter(|_| !paper).unwrap_or(usual);
    let chiang = |[beta_m, beta_n]: [f32; 2], alpha_degrees: f32| HairMaterial {
        absorption: spec.absorption.map_or(Vec3::ZERO, Vec3::from),
        beta_m,
        beta_n,
        alpha_degrees,
        ior: spec.ior,
    };
    let (hair, lost) = match model {
        FibreModel::Chiang => (chiang(spec.roughness, spec.tilt), None),
        FibreModel::Sadeghi | FibreModel::SadeghiNormalised => {
            let roughness = [beta_m_of(spec.width[0].to_radians()), beta_n_of(spec.azimuth_tt.to_radians())];
            let mut lost = vec![format!("lobe intensities {:?}", spec.intensity)];
            if spec.glint[0] > 0.0 {
                lost.push(format!("glints {:?}", spec.glint));
            }
            let diffuse = spec.diffuse.unwrap_or(0.7);
            if diffuse > 0.0 {
                lost.push(format!("a diffuse part of {diffuse}"));
            }
            // The lobe R is shifted by twice the tilt, towards the root.
            let hair = HairMaterial { absorption: Vec3::ZERO, ..chiang(roughness, -0.5 * spec.shift[0]) };
            let lost = format!(
                "by Sadeghi et al. 2010 in the scene, by Chiang et al. 2016 here: roughness and tilt follow from the widths of R and TT \
                 and the shift of R, absorption from colour; left out: {}",
                lost.join(", ")
            );
            (hair, Some(lost))
        }
        FibreModel::KajiyaKay => {
            let hair = HairMaterial { absorption: Vec3::ZERO, ..chiang([0.6; 2], 0.0) };
            let lost = format!(
                "by Kajiya and Kay 1989 in the scene (diffuse {}, specular {}), by Chiang et al. 2016 with roughness 0.6 here",
                spec.diffuse.unwrap_or(1.0),
                spec.specular
            );
            (hair, Some(lost))
        }
        FibreModel::Medulla => {
            let [along, around] = spec.medulla.width.map(f32::to_radians);
            let lost = format!(
                "by Yan et al. 2017 in the scene, by Chiang et al. 2016 here: left out is the medulla, {} of the radius",
                spec.medulla.radius
            );
            (chiang([beta_m_of(along), beta_n_of(around)], spec.tilt), Some(lost))
        }
    };
    let given = matches!(model, FibreModel::Chiang | FibreModel::Medulla) && spec.absorption.is_some();
    LayerMaterial { hair, colored: !given, approximates: lost.map(|lost| format!("{whose} scatter {lost}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roughness_is_found_again() {
        for beta in [0.05, 0.2, 0.5, 0.9] {
            assert!((beta_m_of(longitudinal_variance(beta).sqrt()) - beta).abs() < 1e-4, "{beta}");
            let sigma = azimuthal_scale(beta) * PI / 3f32.sqrt();
            assert!((beta_n_of(sigma) - beta).abs() < 1e-4, "{beta}");
        }
    }

    /// pbrt's documentation: a reflectance of one absorbs nothing, and darker ones absorb more.
    #[test]
    fn absorption_grows_as_colour_darkens() {
        assert_eq!(absorption_of(Vec3::ONE, 0.3), Vec3::ZERO);
        let a = absorption_of(Vec3::new(0.5, 0.2, 0.0), 0.3);
        assert!(a.x < a.y && a.y < a.z && a.is_finite(), "{a}");
        // By hand: ln 0.5 = -0.693147, the fit at 0.3 is 5.888..., squared.
        let fit = 5.969 - 0.0645 + 0.22788 - 0.28971 + 0.045_149_4 + 0.000_595_35;
        assert!((a.x - (std::f32::consts::LN_2 / fit).powi(2)).abs() < 1e-6, "{a}");
    }
}
