//! Radiance along rays: light at the first hit alone, or paths of many scatterings.

use super::{
    bvh::{Ray, Stack},
    camera::View,
    curve,
    geometry::{Geometry, HairHit, Hit, RayOrigin, Shaded, SkinHit},
    light::Lights,
    random::Numbers,
};
use glam::{Vec3, Vec3A};
use pelage_core::light::Light;
use pelage_fur::Layer;
use pelage_fur::fibre::Fibre;
use pelage_fur::random::hash2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f32::consts::{PI, TAU};

/// How light is gathered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// The renderer's light model with exact visibility: each light at the first hit, once scattered.
    Single,
    /// All orders of scattering.
    Path,
}

/// How light of the sky is found. All three have the same mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strategy {
    /// Both, weighted by the balance heuristic.
    Both,
    /// Directions drawn from the sky.
    Light,
    /// Directions drawn from the scattering.
    Scattering,
}

/// Layer of the skin among the contributions; hairs have 0 (guard) and 1 (undercoat).
pub const BASE: usize = 2;

/// What one sample sees.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Seen {
    /// Radiance.
    pub radiance: Vec3,
    /// What was hit first: guard hair, undercoat, skin.
    pub layer: Option<usize>,
    /// Depth of the first hit, cm along the viewing direction.
    pub depth: f32,
    /// Smoothed normal of the skin, whatever is before it.
    pub normal: Vec3,
    /// Weight in the pixel.
    pub weight: f32,
    /// Rays traced.
    pub rays: u32,
}

/// Everything that samples are traced with.
pub struct Tracer {
    /// Skin and hairs.
    pub geometry: Geometry,
    /// Lights.
    pub lights: Lights,
    /// Camera.
    pub view: View,
    /// How.
    pub integrator: Integrator,
    /// How light of the sky is found.
    pub strategy: Strategy,
    /// Most scatterings of a path.
    pub depth: u32,
    /// Seed of the samples.
    pub seed: u32,
    /// Pixels of a row.
    pub width: u32,
}

/// A scattering place.
enum Place<'a> {
    Hair(HairHit, Shaded<'a>, [Vec3A; 3], Vec3),
    Skin { reflectance: Vec3, normal: Vec3, flat: Vec3, position: Vec3A },
}

/// Scatterings before paths may be ended by chance.
const ROULETTE_FROM: u32 = 12;

/// Paths that carry more than this never end by chance.
const ROULETTE_BELOW: f32 = 0.1;

/// Distance that keeps rays from the triangle that they leave, in parts of the coordinates' size.
const SKIN_OFFSET: f32 = 2e-6;

impl Tracer {
    /// Traces sample `index` of a pixel.
    pub fn sample(&self, pixel: [u32; 2], index: u32, stack: &mut Stack) -> Seen {
        let mut numbers = Numbers::new(self.seed, pixel[1] * self.width + pixel[0], index);
        let camera = self.view.ray(pixel, numbers.four());
        let mut seen = Seen { weight: camera.weight, ..Seen::default() };
        let mut ray = camera.ray;
        let mut from = RayOrigin::default();
        let mut carried = Vec3::ONE;
        // Density with which the last scattering drew the ray's direction.
        let mut drawn = 0.0;
        let most = if self.integrator == Integrator::Single { 1 } else { self.depth };
        let mut scatterings = 0;
        loop {
            let found = self.geometry.closest(&ray, &from, numbers.word(), stack);
            seen.rays += 1;
            let Some((hit, distance)) = found else {
                if let (Some(sky), true) = (&self.lights.sky, scatterings > 0) {
                    let (radiance, pdf) = sky.look(ray.direction.into());
                    let share = match self.strategy {
                        Strategy::Both => drawn / (drawn + pdf),
                        Strategy::Light => 0.0,
                        Strategy::Scattering => 1.0,
                    };
                    seen.radiance += carried * radiance * share;
                }
                return seen;
            };
            let place = self.place(&hit, &ray, distance);
            if scatterings == 0 {
                self.note(&mut seen, &hit, &camera.ray, &place, stack);
                seen.depth = camera.depth + distance * camera.depth_rate;
            }
            let Some(place) = place else { return seen };
            if scatterings >= most {
                return seen;
            }
            let [pick, u, v, chance] = numbers.four();
            seen.radiance += carried * self.direct(&place, [pick, u, v], &numbers, stack, &mut seen.rays);
            scatterings += 1;
            // Beyond the last scattering only the sky is left to be seen.
            if scatterings >= most && (self.lights.sky.is_none() || self.strategy == Strategy::Light) {
                return seen;
            }
            let Some((direction, pdf, weight)) = place.sample(numbers.four()) else { return seen };
            carried *= weight;
            drawn = pdf;
            let largest = carried.max_element();
            if scatterings >= ROULETTE_FROM && largest < ROULETTE_BELOW {
                let survival = largest / ROULETTE_BELOW;
                if chance >= survival {
                    return seen;
                }
                carried /= survival;
            }
            if carried.max_element() <= 0.0 {
                return seen;
            }
            (ray, from) = self.leave(&place, Vec3A::from(direction));
        }
    }

    /// Notes what is hit first.
    fn note(&self, seen: &mut Seen, hit: &Hit, ray: &Ray, place: &Option<Place<'_>>, stack: &mut Stack) {
        let skin = match (hit, place) {
            (Hit::Hair(_), Some(Place::Hair(_, shaded, _, _))) => {
                seen.layer = Some(if shaded.layer == Layer::Guard { 0 } else { 1 });
                self.geometry.closest_skin(ray, stack).map(|(skin, _)| skin)
            }
            (Hit::Skin(skin), _) => {
                seen.layer = Some(BASE);
                Some(*skin)
            }
            (Hit::Hair(_), _) => None,
        };
        if let Some(skin) = skin {
            seen.normal = self.geometry.skin(&skin).1;
        }
    }

    /// The scattering place of a hit; `None` on the skin's inner side, where rays end.
    fn place(&self, hit: &Hit, ray: &Ray, distance: f32) -> Option<Place<'_>> {
        match hit {
            Hit::Hair(hair) => {
                let back = -ray.direction;
                let (y, z) = curve::frame(hair.axis, back);
                let local = Vec3::new(back.dot(hair.axis), back.dot(y), back.dot(z));
                Some(Place::Hair(*hair, self.geometry.shaded(hair), [hair.axis, y, z], local))
            }
            Hit::Skin(skin) => self.skin_place(skin, ray, distance),
        }
    }

    fn skin_place(&self, skin: &SkinHit, ray: &Ray, distance: f32) -> Option<Place<'_>> {
        skin.front.then(|| {
            let (reflectance, normal, flat) = self.geometry.skin(skin);
            let at = ray.origin + distance * ray.direction;
            let offset = SKIN_OFFSET * (1.0 + at.abs().max_element());
            Place::Skin { reflectance, normal, flat, position: at + offset * Vec3A::from(flat) }
        })
    }

    fn leave(&self, place: &Place<'_>, direction: Vec3A) -> (Ray, RayOrigin) {
        match place {
            Place::Hair(hit, ..) => {
                (Ray::new(hit.position, direction), self.geometry.departure(hit, direction))
            }
            Place::Skin { position, .. } => (Ray::new(*position, direction), RayOrigin::default()),
        }
    }

    /// Light that comes straight from lights and sky and is scattered back along the ray.
    fn direct(
        &self,
        place: &Place<'_>,
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
            let (ray, from) = self.leave(place, Vec3A::from(direction));
            if !self.geometry.blocked(&ray, &from, hash2(numbers.word(), decision), stack) {
                sum += light;
            }
        };
        let towards = |light: &Light| light.irradiance * place.scatter(light.direction);
        if self.integrator == Integrator::Single {
            for (i, light) in (1..).zip(&self.lights.directional) {
                if place.lit_by(light) {
                    add(light.direction, towards(light), i);
                }
            }
        } else if let Some((light, chance)) = self.lights.pick(pick) {
            add(light.direction, towards(light) / chance, 1);
        }
        if let (Some(sky), true) = (&self.lights.sky, self.strategy != Strategy::Scattering) {
            let sample = sky.sample([u, v]);
            if sample.pdf > 0.0 {
                let share = match self.strategy {
                    Strategy::Both => sample.pdf / (sample.pdf + place.pdf(sample.direction)),
                    _ => 1.0,
                };
                let light = sample.radiance * place.scatter(sample.direction) * (share / sample.pdf);
                add(sample.direction, light, 0);
            }
        }
        sum
    }
}

impl Place<'_> {
    /// Whether a light of the renderer's model shines on it.
    fn lit_by(&self, light: &Light) -> bool {
        match self {
            Self::Hair(_, shaded, ..) => shaded.layer == Layer::Guard || light.undercoat,
            Self::Skin { .. } => true,
        }
    }

    fn local([x, y, z]: &[Vec3A; 3], direction: Vec3) -> Vec3 {
        let d = Vec3A::from(direction);
        Vec3::new(d.dot(*x), d.dot(*y), d.dot(*z))
    }

    /// Scattering from `direction` back along the ray, times the cosine of the incidence, 1/sr.
    fn scatter(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Hair(_, shaded, frame, back) => {
                let wi = Self::local(frame, direction);
                let cos = (1.0 - wi.x * wi.x).max(0.0).sqrt();
                shaded.fibre.evaluate(&shaded.hit, wi, *back) * cos
            }
            Self::Skin { reflectance, normal, flat, .. } => {
                if flat.dot(direction) <= 0.0 {
                    return Vec3::ZERO;
                }
                *reflectance * (normal.dot(direction).max(0.0) / PI)
            }
        }
    }

    fn pdf(&self, direction: Vec3) -> f32 {
        match self {
            Self::Hair(_, shaded, frame, back) => {
                shaded.fibre.pdf(&shaded.hit, Self::local(frame, direction), *back)
            }
            Self::Skin { normal, .. } => normal.dot(direction).max(0.0) / PI,
        }
    }

    /// Draws a direction: with its density and the weight of what comes from there.
    fn sample(&self, u: [f32; 4]) -> Option<(Vec3, f32, Vec3)> {
        match self {
            Self::Hair(_, shaded, [x, y, z], back) => {
                let fibre: &Fibre = shaded.fibre;
                let drawn = fibre.sample(&shaded.hit, *back, u)?;
                let d = drawn.direction;
                let direction = d.x * *x + d.y * *y + d.z * *z;
                Some((direction.normalize().into(), drawn.pdf, drawn.weight))
            }
            Self::Skin { reflectance, normal, flat, .. } => {
                let (side, other) = normal.any_orthonormal_pair();
                let (sin, cos) = (TAU * u[1]).sin_cos();
                let r = u[0].sqrt();
                let height = (1.0 - u[0]).max(0.0).sqrt();
                let direction = (r * cos * side + r * sin * other + height * *normal).normalize();
                (flat.dot(direction) > 0.0).then_some((direction, height / PI, *reflectance))
            }
        }
    }
}
