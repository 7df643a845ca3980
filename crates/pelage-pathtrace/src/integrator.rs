//! Radiance along camera rays: light scattered once at the first hit, or paths of many scatterings.
//!
//! At each scattering, lights are sampled directly (next event estimation). Light of the sky is
//! also found by scattered rays that escape; multiple importance sampling by the balance heuristic
//! joins the two.
// [VeachGuibas1995] balance heuristic, [ArvoKirk1990] Russian roulette

use super::{
    bvh::{Ray, Stack},
    camera::{CameraRay, View},
    curve,
    geometry::{Geometry, HairHit, HairShading, Hit, RayOrigin},
    light::Lights,
    random::Numbers,
    surface::{Scattering, SurfaceShading},
};
use glam::{Vec3, Vec3A};
use pelage_core::light::Light;
use pelage_fur::Layer;
use pelage_fur::fibre::Fibre;
use pelage_fur::material::within_light;
use pelage_fur::random::{hash2, random};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How light is gathered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// The renderer's light model with exact visibility: each light at the first hit, once
    /// scattered.
    Single,
    /// All orders of scattering.
    Path,
}

/// How light of the sky is sampled. All three have the same mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strategy {
    /// Both, weighted by the balance heuristic.
    Both,
    /// Directions drawn in proportion to the sky's luminance.
    Light,
    /// Directions drawn by the scattering models.
    Scattering,
}

/// Number of skin and objects in [`PixelSample::layer`], where hairs are 0 (guard) and 1
/// (undercoat).
pub const BASE: usize = 2;

/// What one sample contributes to its pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PixelSample {
    /// Radiance.
    pub radiance: Vec3,
    /// What was hit first: 0 guard hair, 1 undercoat, [`BASE`] skin or object; `None` without a
    /// hit.
    pub layer: Option<usize>,
    /// How much of the background it hides: 1, of a shadow catcher the share of light that is
    /// missing; 0 without a hit.
    pub alpha: f32,
    /// Depth of the first hit, cm along the viewing direction.
    pub depth: f32,
    /// Normal at the first hit: smoothed, of a surface; of a hair, that of a ribbon that faces the
    /// camera. Times `alpha`.
    pub normal: Vec3,
    /// Colour of what was hit first.
    pub albedo: Vec3,
    /// Direction of the hair that was hit first, from root to tip; 0 on surfaces.
    pub tangent: Vec3,
    /// Weight by the pixel's filter.
    pub weight: f32,
    /// Rays traced for it.
    pub rays: u32,
}

/// Everything that samples are traced with.
pub struct Tracer {
    /// Surfaces and hairs.
    pub geometry: Geometry,
    /// Lights.
    pub lights: Lights,
    /// Camera.
    pub view: View,
    /// How light is gathered.
    pub integrator: Integrator,
    /// How light of the sky is sampled.
    pub strategy: Strategy,
    /// Largest number of scatterings of a path.
    pub depth: u32,
    /// Seed of the samples.
    pub seed: u32,
    /// Width of the image, pixels.
    pub width: u32,
}

/// A point of a path where light is scattered.
enum Vertex<'a> {
    /// Hit, shading data, the fibre's frame, and in it the direction back along the ray.
    Hair(HairHit, HairShading<'a>, [Vec3A; 3], Vec3),
    /// Shading data, and the direction back along the ray.
    Surface(SurfaceShading, Vec3),
}

/// Scatterings before Russian roulette may end a path.
const ROULETTE_FROM: u32 = 12;

/// Russian roulette ends no path that has a channel with a larger throughput than this.
const ROULETTE_BELOW: f32 = 0.1;

impl Tracer {
    /// Traces sample `index` of a pixel.
    pub fn sample(&self, pixel: [u32; 2], index: u32, stack: &mut Stack) -> PixelSample {
        let mut numbers = Numbers::new(self.seed, pixel[1] * self.width + pixel[0], index);
        let camera = self.view.ray(pixel, numbers.four());
        let mut sample = PixelSample { weight: camera.weight, ..PixelSample::default() };
        let mut ray = camera.ray;
        let mut from = RayOrigin::default();
        let mut throughput = Vec3::ONE;
        // Density with which the last scattering sampled the ray's direction.
        let mut scattering_pdf = 0.0;
        let most = if self.integrator == Integrator::Single { 1 } else { self.depth };
        let mut scatterings = 0;
        loop {
            let found = self.geometry.closest(&ray, &from, numbers.word(), stack);
            sample.rays += 1;
            if scatterings == 0 && self.catches(&mut sample, &camera, found.map(|f| f.1), &numbers, stack) {
                return sample;
            }
            let Some((hit, distance)) = found else {
                if let (Some(sky), true) = (&self.lights.sky, scatterings > 0) {
                    let (radiance, pdf) = sky.evaluate(ray.direction.into());
                    let share = match self.strategy {
                        Strategy::Both => scattering_pdf / (scattering_pdf + pdf),
                        Strategy::Light => 0.0,
                        Strategy::Scattering => 1.0,
                    };
                    sample.radiance += throughput * radiance * share;
                }
                return sample;
            };
            let (vertex, goes_on) = self.vertex(&hit, &ray, distance);
            if scatterings == 0 {
                record_first_hit(&mut sample, &camera.ray, &vertex);
                sample.depth = camera.depth + distance * camera.depth_rate;
            }
            if !goes_on || scatterings >= most {
                return sample;
            }
            let [pick, u, v, chance] = numbers.four();
            sample.radiance +=
                throughput * self.direct(&vertex, [pick, u, v], &numbers, stack, &mut sample.rays);
            scatterings += 1;
            // After the last scattering only the sky can still contribute.
            if scatterings >= most && (self.lights.sky.is_none() || self.strategy == Strategy::Light) {
                return sample;
            }
            let Some((direction, pdf, weight)) = vertex.sample(numbers.four()) else { return sample };
            throughput *= weight;
            scattering_pdf = pdf;
            let largest = throughput.max_element();
            if scatterings >= ROULETTE_FROM && largest < ROULETTE_BELOW {
                let survival = largest / ROULETTE_BELOW;
                if chance >= survival {
                    return sample;
                }
                throughput /= survival;
            }
            if throughput.max_element() <= 0.0 {
                return sample;
            }
            (ray, from) = self.leave(&vertex, Vec3A::from(direction));
        }
    }

    /// Whether the camera ray meets a shadow catcher before the hit at `distance`. Then the sample
    /// is done.
    fn catches(
        &self,
        sample: &mut PixelSample,
        camera: &CameraRay,
        distance: Option<f32>,
        numbers: &Numbers,
        stack: &mut Stack,
    ) -> bool {
        let limit = distance.unwrap_or(f32::INFINITY);
        let found = self.geometry.surfaces.closest_catcher(&camera.ray, limit, stack);
        let Some((hit, distance)) = found else { return false };
        let shading = self.geometry.surfaces.shading(&hit, &camera.ray, distance);
        sample.layer = Some(BASE);
        sample.alpha = self.missing_light(&shading, numbers, stack, &mut sample.rays);
        sample.normal = sample.alpha * shading.normal;
        sample.depth = camera.depth + distance * camera.depth_rate;
        true
    }

    /// The vertex of a hit, and whether paths go on from there: on the skin's inner side they end.
    fn vertex(&self, hit: &Hit, ray: &Ray, distance: f32) -> (Vertex<'_>, bool) {
        let back = -ray.direction;
        match hit {
            Hit::Hair(hair) => {
                let (y, z) = curve::frame(hair.axis, back);
                let local = Vec3::new(back.dot(hair.axis), back.dot(y), back.dot(z));
                (Vertex::Hair(*hair, self.geometry.hair_shading(hair), [hair.axis, y, z], local), true)
            }
            Hit::Surface(hit) => {
                let shading = self.geometry.surfaces.shading(hit, ray, distance);
                let ends = matches!(shading.scattering, Scattering::Skin(_)) && !hit.front;
                (Vertex::Surface(shading, back.into()), !ends)
            }
        }
    }

    /// The ray that leaves a vertex along a unit direction.
    fn leave(&self, vertex: &Vertex<'_>, direction: Vec3A) -> (Ray, RayOrigin) {
        match vertex {
            Vertex::Hair(hit, ..) => {
                (Ray::new(hit.position, direction), self.geometry.origin_on_hair(hit, direction))
            }
            Vertex::Surface(shading, _) => (Ray::new(shading.position, direction), RayOrigin::default()),
        }
    }

    /// Next event estimation: light that comes straight from lights and sky and is scattered back
    /// along the ray.
    fn direct(
        &self,
        vertex: &Vertex<'_>,
        [pick, u, v]: [f32; 3],
        numbers: &Numbers,
        stack: &mut Stack,
        rays: &mut u32,
    ) -> Vec3 {
        let mut sum = Vec3::ZERO;
        let mut add = |direction: Vec3, light: Vec3, decision: u32| {
            if light.max_element() <= 0.0 {
                return;
            }
            *rays += 1;
            let (ray, from) = self.leave(vertex, Vec3A::from(direction));
            if !self.geometry.blocked(&ray, &from, hash2(numbers.word(), decision), stack) {
                sum += light;
            }
        };
        // Where the light is looked for, and what it gives.
        let towards = |i: usize| {
            let (light, spread) = (&self.lights.directional[i], self.lights.spreads[i]);
            let way = match vertex {
                Vertex::Surface(shading, _) if spread > 0.0 && shading.is_object() => {
                    let seed = hash2(numbers.word(), 0x5f7e ^ i as u32);
                    let u = [random(seed, 0), random(seed, 1)];
                    within_light(light.direction, spread, u, shading.geometric_normal)
                }
                _ => light.direction,
            };
            (way, light.irradiance * vertex.scatter(light.direction, spread))
        };
        if self.integrator == Integrator::Single {
            for (i, light) in self.lights.directional.iter().enumerate() {
                if vertex.lit_by(light) {
                    let (way, light) = towards(i);
                    add(way, light, i as u32 + 1);
                }
            }
        } else if let Some((i, chance)) = self.lights.pick(pick) {
            let (way, light) = towards(i);
            add(way, light / chance, 1);
        }
        if let (Some(sky), true) = (&self.lights.sky, self.strategy != Strategy::Scattering) {
            let drawn = sky.sample([u, v]);
            if drawn.pdf > 0.0 {
                let share = match self.strategy {
                    Strategy::Both => drawn.pdf / (drawn.pdf + vertex.pdf(drawn.direction)),
                    _ => 1.0,
                };
                let light = drawn.radiance * vertex.scatter(drawn.direction, 0.0) * (share / drawn.pdf);
                add(drawn.direction, light, 0);
            }
        }
        sum
    }
}

impl Vertex<'_> {
    /// Whether a light of the renderer's model illuminates it.
    fn lit_by(&self, light: &Light) -> bool {
        match self {
            Self::Hair(_, shaded, ..) => shaded.layer == Layer::Guard || light.undercoat,
            Self::Surface(..) => true,
        }
    }

    fn local([x, y, z]: &[Vec3A; 3], direction: Vec3) -> Vec3 {
        let d = Vec3A::from(direction);
        Vec3::new(d.dot(*x), d.dot(*y), d.dot(*z))
    }

    /// Scattering from `direction` back along the ray, times the cosine of incidence, 1/sr. Lobes
    /// of objects are widened by `spread`.
    fn scatter(&self, direction: Vec3, spread: f32) -> Vec3 {
        match self {
            Self::Hair(_, shaded, frame, back) => {
                let wi = Self::local(frame, direction);
                let cos = (1.0 - wi.x * wi.x).max(0.0).sqrt();
                shaded.fibre.evaluate(&shaded.hit, wi, *back) * cos
            }
            Self::Surface(shading, back) => shading.scatter(*back, direction, spread),
        }
    }

    /// Probability density with which [`Vertex::sample`] draws a direction, 1/sr.
    fn pdf(&self, direction: Vec3) -> f32 {
        match self {
            Self::Hair(_, shaded, frame, back) => {
                shaded.fibre.pdf(&shaded.hit, Self::local(frame, direction), *back)
            }
            Self::Surface(shading, back) => shading.pdf(*back, direction),
        }
    }

    /// Samples a direction towards the light: the direction, its density (1/sr), and the weight of
    /// radiance from there.
    fn sample(&self, u: [f32; 4]) -> Option<(Vec3, f32, Vec3)> {
        match self {
            Self::Hair(_, shaded, [x, y, z], back) => {
                let fibre: &Fibre = shaded.fibre;
                let sampled = fibre.sample(&shaded.hit, *back, u)?;
                let d = sampled.direction;
                let direction = d.x * *x + d.y * *y + d.z * *z;
                Some((direction.normalize().into(), sampled.pdf, sampled.weight))
            }
            Self::Surface(shading, back) => shading.sample(*back, u),
        }
    }
}

/// Records what the camera ray hits first.
fn record_first_hit(sample: &mut PixelSample, ray: &Ray, vertex: &Vertex<'_>) {
    sample.alpha = 1.0;
    match vertex {
        Vertex::Hair(hair, shaded, _, _) => {
            sample.layer = Some(if shaded.layer == Layer::Guard { 0 } else { 1 });
            sample.albedo = shaded.hit.tint;
            sample.tangent = hair.axis.into();
            let back = Vec3::from(-ray.direction);
            let across = back - sample.tangent * back.dot(sample.tangent);
            sample.normal = across.try_normalize().unwrap_or(back);
        }
        Vertex::Surface(shading, _) => {
            sample.layer = Some(BASE);
            sample.albedo = shading.albedo();
            sample.normal = shading.normal;
        }
    }
}
