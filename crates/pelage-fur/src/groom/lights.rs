//! The lights, as the passes read them.

use crate::layout::{Light, LightParameters, MAX_LIGHTS};
use crate::material::spreads;
use bytemuck::Zeroable;
use pelage_core::World;
use pelage_core::film::tonemap::luminance;

/// Packs the lights; the key lights are the two brightest of those that light the undercoat, by
/// luminance.
// [BT709]
pub(super) fn pack_lights(world: &World) -> (LightParameters, Vec<Light>) {
    let mut lights: Vec<Light> = world
        .lights
        .iter()
        .zip(spreads(world))
        .take(MAX_LIGHTS)
        .map(|(l, spread)| Light {
            direction: l.direction.into(),
            undercoat: u32::from(l.undercoat),
            irradiance: l.irradiance.into(),
            spread,
        })
        .collect();
    let mut order: Vec<usize> = (0..lights.len()).filter(|i| lights[*i].undercoat == 1).collect();
    order.sort_by(|a, b| {
        let power = |i: usize| luminance(world.lights[i].irradiance);
        power(*b).total_cmp(&power(*a))
    });
    let mut parameters = LightParameters {
        count: lights.len() as u32,
        keys: order.len().min(2) as u32,
        key_lights: [u32::MAX; 2],
        ..LightParameters::zeroed()
    };
    for (k, i) in order.into_iter().take(2).enumerate() {
        let [x, y, z] = lights[i].direction;
        let [r, g, b] = lights[i].irradiance;
        parameters.key_lights[k] = i as u32;
        parameters.key_direction[k] = [x, y, z, 0.0];
        parameters.key_irradiance[k] = [r, g, b, 0.0];
    }
    lights.resize(MAX_LIGHTS, Light::zeroed());
    (parameters, lights)
}
