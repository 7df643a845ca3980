//! Meshes without fur.

use super::{Color, MeshSpec};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A mesh without fur that stands in the scene: an eye, a collar, the ground.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields, default)]
pub struct ObjectSpec {
    /// Name in messages and exported files; each object has its own.
    pub name: String,
    /// Its mesh, in the same world as the skin.
    pub mesh: MeshSpec,
    /// Its material.
    pub material: ObjectMaterial,
    /// Show only the shadow that falls on it, to composite it over a photograph: a black surface
    /// whose alpha is the share of the light that is missing, 1 - visible / unshadowed irradiance
    /// (luminances). It blocks no light, and hides what is behind it.
    pub shadow_catcher: bool,
}

/// An opaque material: the metallic-roughness model of glTF 2.0 with the clear coat of
/// KHR_materials_clearcoat; index of refraction 1.5.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ObjectMaterial {
    /// Base colour: reflectance of a dielectric's inside, or a metal's colour at normal incidence.
    pub color: Color,
    /// Roughness; its square is the width of the GGX distribution. Default 0.5.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
    /// 0: dielectric (default), 1: metal.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub metallic: f32,
    /// Strength of the clear coat. Default 0.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub clearcoat: f32,
    /// Roughness of the clear coat. Default 0.03.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub clearcoat_roughness: f32,
}

impl Default for ObjectMaterial {
    fn default() -> Self {
        Self {
            color: Color::Constant([0.5; 3]),
            roughness: 0.5,
            metallic: 0.0,
            clearcoat: 0.0,
            clearcoat_roughness: 0.03,
        }
    }
}
