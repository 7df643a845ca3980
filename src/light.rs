//! Lights: everything that shines becomes a list of directional lights before the passes run.

use glam::Vec3;

/// A directional light as the passes read it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Unit vector from the scene towards the light, world space.
    pub direction: Vec3,
    /// Irradiance on a surface that faces the light, linear RGB.
    pub irradiance: Vec3,
    /// Whether the light comes from the environment map (Andersen et al. 2016 do not light the undercoat by it).
    pub environment: bool,
    /// Whether the undercoat is lit by it.
    pub undercoat: bool,
}

/// All directional lights of a scene: the given ones, then those made of the environment map.
pub fn lights_of(_scene: &crate::Scene, _assets: &crate::assets::Assets) -> crate::Result<Vec<Light>> {
    Ok(Vec::new())
}
