//! Lights: directional lights, and a sky that is sampled in proportion to its luminance.

use glam::{Quat, Vec3};
use pelage_core::assets::Assets;
use pelage_core::film::tonemap::luminance;
use pelage_core::light::Light;
use pelage_core::light::environment::{Panorama, map_from_world};
use pelage_core::{Result, World};
use pelage_fur::material::spreads;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f32::consts::{PI, TAU};

/// Which lights a scene has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LightModel {
    /// Those of the renderer, the environment as directional lights: differences from the renderer
    /// then do not come from the lights.
    Scene,
    /// The environment itself, and the scene's directional lights.
    Map,
}

/// Radiance from all directions.
#[derive(Debug, Clone)]
pub struct Sky {
    /// Factor on the map, or the radiance itself.
    factor: Vec3,
    map: Option<Map>,
}

/// An environment map with its sampling: first a row is drawn, then a column. Radiance is constant
/// over a texel, so that all samples of a grey map have the same weight.
#[derive(Debug, Clone)]
struct Map {
    panorama: Panorama,
    map_from_world: Quat,
    /// Cumulative distribution of the rows, 0 to 1.
    rows: Vec<f32>,
    /// Cumulative distribution within each row, 0 to 1, `width + 1` values each.
    columns: Vec<f32>,
    /// Probability density of a direction for a luminance of 1, 1/sr.
    density: f32,
}

/// A direction towards the sky.
#[derive(Debug, Clone, Copy)]
pub struct SkySample {
    /// Unit, world space.
    pub direction: Vec3,
    /// Probability density, 1/sr.
    pub pdf: f32,
    /// Linear RGB.
    pub radiance: Vec3,
}

impl Sky {
    /// The environment of a scene; `None` if there is none or it is black.
    ///
    /// # Errors
    /// [`pelage_core::Error::Scene`] if the map is missing or damaged.
    pub fn load(world: &World, assets: &Assets) -> Result<Option<Self>> {
        let Some(environment) = &world.scene.environment else { return Ok(None) };
        let factor = Vec3::from(environment.tint) * environment.intensity;
        if factor.max_element() <= 0.0 {
            return Ok(None);
        }
        // Loading the world has reported the notes.
        Ok(match Panorama::of(environment, assets, &mut Vec::new())? {
            Some(panorama) => Self::of(panorama, environment.rotate, factor),
            None => Some(Self::uniform(factor)),
        })
    }

    /// The same radiance from everywhere.
    pub fn uniform(radiance: Vec3) -> Self {
        Self { factor: radiance, map: None }
    }

    /// A map turned by `degrees`, its radiance times `factor`; `None` for a black map.
    pub fn of(panorama: Panorama, degrees: f32, factor: Vec3) -> Option<Self> {
        let (width, height) = (panorama.width, panorama.height);
        let mut rows = Vec::with_capacity(height + 1);
        let mut columns = Vec::with_capacity((width + 1) * height);
        let mut total = 0f64;
        rows.push(0.0);
        let mut sums = Vec::with_capacity(height);
        for y in 0..height {
            let texels = &panorama.texels[y * width..][..width];
            let mut sum = 0f64;
            let mut running = vec![0f64];
            for texel in texels {
                sum += f64::from(luminance(Vec3::from(*texel)));
                running.push(sum);
            }
            columns.extend(running.iter().map(|r| if sum > 0.0 { (r / sum) as f32 } else { 0.0 }));
            total += sum * panorama.solid_angle(y);
            sums.push(total);
        }
        rows.extend(sums.iter().map(|s| (s / total) as f32));
        (total > 0.0).then(|| Self {
            factor,
            map: Some(Map {
                panorama,
                map_from_world: map_from_world(degrees),
                rows,
                columns,
                density: (1.0 / total) as f32,
            }),
        })
    }

    /// The largest luminance over density of [`Sky::sample`]: of an untinted sky, the irradiance on
    /// a surface that would face all of it.
    pub fn most(&self) -> f32 {
        match &self.map {
            Some(map) => self.factor.max_element() / map.density,
            None => luminance(self.factor) * 4.0 * PI,
        }
    }

    /// Radiance from a direction (unit, world space), linear RGB, and the density with which
    /// [`Sky::sample`] draws it, 1/sr.
    pub fn evaluate(&self, direction: Vec3) -> (Vec3, f32) {
        let Some(map) = &self.map else { return (self.factor, 0.25 / PI) };
        let [x, y] = map.panorama.texel_of((map.map_from_world * direction).as_dvec3());
        let column = (x as usize).min(map.panorama.width - 1);
        let row = (y as usize).min(map.panorama.height - 1);
        map.at(row * map.panorama.width + column, self.factor)
    }

    /// Draws a direction from two numbers in 0..1.
    pub fn sample(&self, u: [f32; 2]) -> SkySample {
        let Some(map) = &self.map else {
            let z = 1.0 - 2.0 * u[0];
            let (sin, cos) = (TAU * u[1]).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            return SkySample {
                direction: Vec3::new(r * cos, z, r * sin),
                pdf: 0.25 / PI,
                radiance: self.factor,
            };
        };
        let (width, height) = (map.panorama.width, map.panorama.height);
        let (row, down) = find(&map.rows, u[0]);
        let (column, right) = find(&map.columns[row * (width + 1)..][..=width], u[1]);
        // Uniform in solid angle within the texel.
        let edge = |y: usize| (y as f32 / height as f32 * PI).cos();
        let cos = edge(row) + (edge(row + 1) - edge(row)) * down;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let azimuth = ((column as f32 + right) / width as f32 - 0.5) * TAU;
        let (s, c) = azimuth.sin_cos();
        let (radiance, pdf) = map.at(row * width + column, self.factor);
        let direction = map.map_from_world.inverse() * Vec3::new(sin * s, cos, -sin * c);
        SkySample { direction: direction.normalize(), pdf, radiance }
    }
}

impl Map {
    fn at(&self, texel: usize, factor: Vec3) -> (Vec3, f32) {
        let radiance = Vec3::from(self.panorama.texels[texel]);
        (radiance * factor, luminance(radiance) * self.density)
    }
}

/// The interval of a cumulative distribution in which `u` lies, never an empty one, and the
/// position of `u` in it, 0..1.
fn find(sums: &[f32], u: f32) -> (usize, f32) {
    let last = sums.len() - 2;
    let mut i = sums.partition_point(|s| *s <= u).saturating_sub(1).min(last);
    // Beyond the last interval that is not empty.
    while i > 0 && sums[i + 1] <= sums[i] {
        i -= 1;
    }
    let width = sums[i + 1] - sums[i];
    (i, if width > 0.0 { ((u - sums[i]) / width).clamp(0.0, 0.999_999) } else { 0.5 })
}

/// All lights of a tracer.
#[derive(Debug, Clone)]
pub struct Lights {
    /// Directional lights.
    pub directional: Vec<Light>,
    /// Cumulative distribution of their luminances, 0 to 1.
    sums: Vec<f32>,
    /// The environment.
    pub sky: Option<Sky>,
    /// For each directional light half the angular radius of the part of the sky that it stands
    /// for, radians, by which objects' lobes are widened and shadows on them softened; 0 for a
    /// point.
    pub spreads: Vec<f32>,
}

impl Lights {
    /// Directional lights, picked in proportion to their luminance, and a sky.
    pub fn new(directional: Vec<Light>, sky: Option<Sky>) -> Self {
        let mut sums = vec![0f32];
        let mut sum = 0.0;
        for light in &directional {
            sum += luminance(light.irradiance);
            sums.push(sum);
        }
        sums.iter_mut().for_each(|s| *s /= sum.max(f32::MIN_POSITIVE));
        let spreads = vec![0.0; directional.len()];
        Self { directional, sums, sky, spreads }
    }

    /// The lights of `world` for a light model.
    ///
    /// # Errors
    /// [`pelage_core::Error::Scene`] if the environment's map is missing or damaged.
    pub fn of(world: &World, assets: &Assets, model: LightModel) -> Result<Self> {
        Ok(match model {
            LightModel::Scene => Self { spreads: spreads(world), ..Self::new(world.lights.clone(), None) },
            LightModel::Map => Self::new(
                world.lights.iter().filter(|l| !l.environment).copied().collect(),
                Sky::load(world, assets)?,
            ),
        })
    }

    /// Picks a directional light in proportion to its luminance: its index and the probability of
    /// the pick.
    pub fn pick(&self, u: f32) -> Option<(usize, f32)> {
        if self.directional.is_empty() {
            return None;
        }
        let (i, _) = find(&self.sums, u);
        let chance = self.sums[i + 1] - self.sums[i];
        (chance > 0.0).then_some((i, chance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_fur::random::random;

    fn sky() -> Sky {
        let (width, height) = (32, 16);
        let texels = (0..width * height)
            .map(|i| {
                let v = random(5, i as u32).powi(6) * if i % 7 == 0 { 0.0 } else { 3.0 };
                [v, 0.5 * v, 0.2 * v]
            })
            .collect();
        Sky::of(Panorama { width, height, texels }, 30.0, Vec3::ONE).expect("a sky that shines")
    }

    #[test]
    fn samples_have_the_density_that_is_looked_up() {
        let sky = sky();
        for i in 0..2000 {
            let s = sky.sample([random(1, i), random(2, i)]);
            let (radiance, pdf) = sky.evaluate(s.direction);
            let near = |a: f32, b: f32| (a - b).abs() <= 1e-4 * a.max(b);
            // Rounding moves a direction at a texel's edge to its neighbour.
            let at_edge = s.pdf != pdf
                && [1e-4, -1e-4].iter().any(|d| {
                    let beside = [Vec3::X, Vec3::Y, Vec3::Z]
                        .map(|a| sky.evaluate((s.direction + *d * a).normalize()).1);
                    beside.iter().any(|p| near(*p, s.pdf))
                });
            assert!(at_edge || (near(pdf, s.pdf) && (radiance - s.radiance).length() < 1e-4), "{i}");
        }
    }

    #[test]
    fn density_integrates_to_one_and_samples_to_the_total() {
        let sky = sky();
        let n = 400_000;
        let (mut one, mut all, mut by_sampling) = (0f64, 0f64, 0f64);
        for i in 0..n {
            let d = pelage_fur::random::random_direction(9, 2 * i);
            let (radiance, pdf) = sky.evaluate(d);
            one += f64::from(pdf * 4.0 * PI) / f64::from(n);
            all += f64::from(radiance.x * 4.0 * PI) / f64::from(n);
            let s = sky.sample([random(3, i), random(4, i)]);
            by_sampling += f64::from(s.radiance.x / s.pdf) / f64::from(n);
        }
        let total = sky.map.as_ref().map_or(0.0, |m| m.panorama.total().x);
        assert!((one - 1.0).abs() < 0.01, "{one}");
        assert!((by_sampling / total - 1.0).abs() < 1e-3, "{by_sampling} is not {total}");
        assert!((all / total - 1.0).abs() < 0.01, "{all} is not {total}");
    }
}
