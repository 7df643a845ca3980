//! Shadow catchers: the share of the light that is missing where a camera ray meets one.

use super::bvh::{Ray, Stack};
use super::geometry::RayOrigin;
use super::integrator::Tracer;
use super::random::Numbers;
use super::surface::SurfaceShading;
use glam::{Vec3, Vec3A};
use pelage_core::film::tonemap::luminance;
use pelage_fur::material::within_light;
use pelage_fur::random::{hash2, random};

/// Directions that are tried before a point counts as unlit.
const TRIES: u32 = 4096;

impl Tracer {
    /// Alpha of a shadow catcher: 1 - visible / unshadowed irradiance, by luminance; 0 where no
    /// light comes from. With a sky, 0 or 1, whose mean is the alpha.
    pub(super) fn missing_light(
        &self,
        shading: &SurfaceShading,
        numbers: &Numbers,
        stack: &mut Stack,
        rays: &mut u32,
    ) -> f32 {
        let mut open = |direction: Vec3, decision: u32| {
            *rays += 1;
            let ray = Ray::new(shading.position, Vec3A::from(direction));
            let word = hash2(numbers.word(), decision);
            !self.geometry.blocked(&ray, &RayOrigin::default(), word, stack)
        };
        let cosine = |direction: Vec3| shading.normal.dot(direction).max(0.0);
        let directional = (0..).zip(self.lights.directional.iter().zip(&self.lights.spreads));
        let Some(sky) = &self.lights.sky else {
            let (mut arriving, mut unshadowed) = (0.0, 0.0);
            for (i, (light, spread)) in directional {
                let irradiance = luminance(light.irradiance) * cosine(light.direction);
                if irradiance > 0.0 {
                    unshadowed += irradiance;
                    let seed = hash2(numbers.word(), 0x5f7e ^ i);
                    let u = [random(seed, 0), random(seed, 1)];
                    let way = within_light(light.direction, *spread, u, shading.geometric_normal);
                    arriving += if open(way, i) { irradiance } else { 0.0 };
                }
            }
            return if unshadowed > 0.0 { 1.0 - arriving / unshadowed } else { 0.0 };
        };
        // Lights and sky together are drawn by what they give a surface that faces them, and kept
        // with the chance of their cosine: the direction that is kept has the density of the
        // unshadowed irradiance, so that the share of blocked ones is what is missing.
        let of_sky = sky.most();
        let whole = of_sky + self.lights.directional.iter().map(|l| luminance(l.irradiance)).sum::<f32>();
        let seed = hash2(numbers.word(), 0xca7c);
        for k in 0..TRIES {
            let number = |n: u32| random(seed, 4 * k + n);
            let mut pick = whole * number(0) - of_sky;
            let (direction, weight) = if pick < 0.0 {
                let drawn = sky.sample([number(1), number(2)]);
                let weight = luminance(drawn.radiance) / (drawn.pdf * of_sky);
                (drawn.direction, if weight.is_finite() { weight } else { 0.0 })
            } else {
                let mut chosen = Vec3::ZERO;
                for light in &self.lights.directional {
                    chosen = light.direction;
                    pick -= luminance(light.irradiance);
                    if pick < 0.0 {
                        break;
                    }
                }
                (chosen, 1.0)
            };
            if number(3) < weight * cosine(direction) {
                return if open(direction, k) { 0.0 } else { 1.0 };
            }
        }
        0.0
    }
}
