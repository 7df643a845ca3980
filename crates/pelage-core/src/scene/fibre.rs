//! The table `fibre` of guard hairs and undercoat: how hairs scatter light.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Scattering model of a hair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FibreModel {
    /// Kajiya and Kay 1989: `diffuse`, `specular`, `specular_exponent`.
    KajiyaKay,
    /// Sadeghi et al. 2010, single scattering, plus Kajiya-Kay diffuse: `intensity`, `shift`,
    /// `width`, `azimuth_tt`, `glint`, `diffuse`. Bright hairs may scatter more light than they
    /// receive.
    Sadeghi,
    /// The same, darkened where it would scatter more light than it receives.
    SadeghiNormalised,
    /// Chiang et al. 2016, a rough dielectric cylinder: `roughness`, `tilt`, `ior`, `absorption`.
    Chiang,
    /// Yan et al. 2017, a cortex around a scattering medulla: `tilt`, `ior`, `absorption`,
    /// `medulla`.
    Medulla,
}

/// Scattering of a hair.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FibreSpec {
    /// The model; by default `sadeghi` for guard hairs, `kajiya_kay` for the undercoat.
    pub model: Option<FibreModel>,
    /// Sadeghi: intensity of R, TT, TRT.
    #[schemars(inner(range(min = 0.0)))]
    pub intensity: [f32; 3],
    /// Sadeghi: longitudinal shift of R, TT, TRT, degrees.
    #[schemars(inner(range(min = -90.0, max = 90.0)))]
    pub shift: [f32; 3],
    /// Sadeghi: longitudinal width of R, TT, TRT, degrees.
    #[schemars(inner(range(min = 0.1, max = 90.0)))]
    pub width: [f32; 3],
    /// Sadeghi: azimuthal width of TT, degrees.
    #[schemars(range(min = 0.1, max = 180.0))]
    pub azimuth_tt: f32,
    /// Sadeghi: glints, intensity and azimuthal width (degrees).
    #[schemars(inner(range(min = 0.0)))]
    pub glint: [f32; 2],
    /// Weight of the Kajiya-Kay diffuse term; by default 1 in `kajiya_kay`, 0.7 in `sadeghi`.
    #[schemars(range(min = 0.0))]
    pub diffuse: Option<f32>,
    /// Kajiya-Kay: weight of the specular term.
    #[schemars(range(min = 0.0))]
    pub specular: f32,
    /// Kajiya-Kay: exponent of the specular term.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub specular_exponent: f32,
    /// Chiang: longitudinal and azimuthal roughness.
    #[schemars(inner(range(min = 0.1, max = 1.0)))]
    pub roughness: [f32; 2],
    /// Chiang, medulla: tilt of the cuticle's scales, degrees.
    #[schemars(range(min = -15.0, max = 15.0))]
    pub tilt: f32,
    /// Chiang, medulla: index of refraction.
    #[schemars(range(min = 1.05, max = 2.5))]
    pub ior: f32,
    /// Chiang, medulla: absorption of the cortex (RGB), 1/radius; by default derived from the
    /// hair's colour.
    #[schemars(inner(range(min = 0.0, max = 1000.0)))]
    pub absorption: Option<[f32; 3]>,
    /// Medulla: the hair's interior and surface.
    pub medulla: MedullaSpec,
}

/// The medulla of a hair, and its surface. Lengths are in radii of the hair.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MedullaSpec {
    /// Radius of the medulla, relative to that of the hair.
    #[schemars(range(min = 0.0, max = 0.99))]
    pub radius: f32,
    /// Scattering coefficient, 1/radius.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub scattering: f32,
    /// Absorption coefficient, 1/radius.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub absorption: f32,
    /// Mean cosine of the scattering angle.
    #[schemars(range(min = -0.95, max = 0.95))]
    pub anisotropy: f32,
    /// Layers of the cuticle, which reflect more than one smooth surface.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub layers: f32,
    /// Longitudinal and azimuthal width of the unscattered lobes, degrees.
    #[schemars(inner(range(min = 2.0, max = 60.0)))]
    pub width: [f32; 2],
}

impl Default for FibreSpec {
    fn default() -> Self {
        Self {
            model: None,
            intensity: [0.08, 0.5, 0.06],
            shift: [-7.5, 3.75, 11.25],
            width: [7.5, 6.0, 15.0],
            azimuth_tt: 20.0,
            glint: [0.3, 8.0],
            diffuse: None,
            specular: 0.0,
            specular_exponent: 12.0,
            roughness: [0.3, 0.3],
            tilt: 2.0,
            ior: 1.55,
            absorption: None,
            medulla: MedullaSpec::default(),
        }
    }
}

impl Default for MedullaSpec {
    fn default() -> Self {
        Self {
            radius: 0.6,
            scattering: 1.7,
            absorption: 0.17,
            anisotropy: 0.44,
            layers: 0.5,
            width: [11.0, 8.0],
        }
    }
}
