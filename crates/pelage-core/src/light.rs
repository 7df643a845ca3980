//! Lights: a scene's lights and its environment as a list of directional lights.

pub mod environment;
pub mod probe;

use crate::assets::Assets;
use crate::film::LARGEST_HALF;
use crate::scene::{Environment, Shading};
use crate::{Error, Result, Scene, SceneFault};
use environment::{Panorama, map_from_world, median_cut, uniform_sky};
use glam::Vec3;

/// Largest number of directional lights of a scene, those of its environment included.
pub const MAX_LIGHTS: usize = 64;

/// Largest number of directional lights made from an environment map.
pub const MAX_ENVIRONMENT_LIGHTS: u32 = 64;

/// A directional light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Unit vector from the scene towards the light, world space.
    pub direction: Vec3,
    /// Irradiance on a surface that faces the light, linear RGB.
    pub irradiance: Vec3,
    /// Whether the light comes from the environment map (Andersen et al. 2016 do not light the
    /// undercoat by it).
    pub environment: bool,
    /// Whether the undercoat is lit by it.
    pub undercoat: bool,
}

/// All directional lights of a scene: the given ones, then those made from the environment map.
/// Adds what is odd about the map, and which lights are too bright for half floats, to `notes`.
///
/// # Errors
/// [`Error::Scene`] for directions of length 0, irradiances and factors that are negative or not
/// finite, a number of environment lights outside 1..=64, more than [`MAX_LIGHTS`] lights, and a
/// map that is missing or damaged. Faults of values come all together.
pub fn lights_of(scene: &Scene, assets: &Assets, notes: &mut Vec<String>) -> Result<Vec<Light>> {
    let mut faults = Vec::new();
    let mut fault = |place: String, message: String| {
        faults.push(SceneFault { file: place.into(), line: 0, column: 0, message, help: None });
    };
    let usable = |v: &[f32]| v.iter().all(|x| x.is_finite() && *x >= 0.0);
    let mut lights = Vec::new();
    for (i, light) in scene.lights.iter().enumerate() {
        let direction = Vec3::from(light.direction).try_normalize();
        if direction.is_none() {
            fault(
                format!("lights[{i}].direction"),
                format!("found {:?}, expected a vector from the scene towards the light", light.direction),
            );
        }
        if !usable(&light.irradiance) {
            fault(
                format!("lights[{i}].irradiance"),
                format!("found {:?}, expected finite numbers not below 0", light.irradiance),
            );
        }
        if let Some(direction) = direction {
            let irradiance = Vec3::from(light.irradiance);
            lights.push(Light { direction, irradiance, environment: false, undercoat: true });
        }
    }
    if let Some(environment) = &scene.environment {
        if !(1..=MAX_ENVIRONMENT_LIGHTS).contains(&environment.lights) {
            fault(
                "environment.lights".into(),
                format!("found {}, expected 1 to {MAX_ENVIRONMENT_LIGHTS}", environment.lights),
            );
        }
        if !usable(&environment.tint) || !usable(&[environment.intensity]) || !environment.rotate.is_finite()
        {
            fault(
                "environment".into(),
                format!(
                    "found intensity {}, tint {:?} and rotate {}, expected finite numbers, intensity and tint not below 0",
                    environment.intensity, environment.tint, environment.rotate
                ),
            );
        }
    }
    let (given, made) = asked(scene);
    if given.saturating_add(made) > MAX_LIGHTS && made <= MAX_ENVIRONMENT_LIGHTS as usize {
        faults.push(SceneFault {
            file: "lights".into(),
            line: 0,
            column: 0,
            message: too_many(given, made),
            help: None,
        });
    }
    if !faults.is_empty() {
        return Err(Error::Scene(faults));
    }
    if let Some(environment) = &scene.environment {
        let undercoat = environment.undercoat && scene.render.shading != Shading::Paper;
        let made = environment_lights(environment, assets, notes)?;
        lights.extend(made.into_iter().map(|l| Light { undercoat, ..l }));
    }
    notes.extend(note_of_bright(&lights));
    Ok(lights)
}

/// Which lights are so bright that what they light may not fit into half floats.
fn note_of_bright(lights: &[Light]) -> Option<String> {
    let bright = |l: &&Light| l.irradiance.max_element() > LARGEST_HALF;
    let first = lights.iter().find(bright)?;
    let name = if first.environment {
        "of the environment's lights".to_owned()
    } else {
        let numbers: Vec<_> = (0..lights.len())
            .filter(|i| bright(&&lights[*i]) && !lights[*i].environment)
            .map(|i| format!("lights[{i}]"))
            .collect();
        numbers.join(", ")
    };
    let largest = lights.iter().filter(bright).map(|l| l.irradiance.max_element()).fold(0.0, f32::max);
    Some(format!(
        "light: {} with an irradiance up to {largest} ({name}), beyond {LARGEST_HALF}, the largest half float: bright \
         parts of the picture may be cut there. Divide all lights by the same factor and raise film.exposure \
         by its stops",
        lights.iter().filter(bright).count()
    ))
}

/// Numbers of the lights that `scene` gives and of those that its environment is converted to.
pub(crate) fn asked(scene: &Scene) -> (usize, usize) {
    (scene.lights.len(), scene.environment.as_ref().map_or(0, |e| e.lights as usize))
}

/// The message for more lights than [`MAX_LIGHTS`].
pub(crate) fn too_many(given: usize, made: usize) -> String {
    let total = given.saturating_add(made);
    format!(
        "lights: found {given} lights and environment.lights = {made}, together {total}, expected at most {MAX_LIGHTS}"
    )
}

/// The environment as directional lights in world space.
fn environment_lights(
    environment: &Environment,
    assets: &Assets,
    notes: &mut Vec<String>,
) -> Result<Vec<Light>> {
    let factor = Vec3::from(environment.tint) * environment.intensity;
    let Some(panorama) = Panorama::of(environment, assets, notes)? else {
        return Ok(uniform_sky(factor, environment.lights));
    };
    let world_from_map = map_from_world(environment.rotate).inverse();
    Ok(median_cut(&panorama, environment.lights)
        .into_iter()
        .map(|light| Light {
            direction: (world_from_map * light.direction).normalize(),
            irradiance: light.irradiance * factor,
            ..light
        })
        .collect())
}
