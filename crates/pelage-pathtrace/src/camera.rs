//! Rays from the camera: through a point of the pixel, drawn by its filter, and a point of the
//! lens.

use super::bvh::{Bounds, Ray};
use glam::{Vec2, Vec3, Vec3A};
use pelage_core::film::filter;
use pelage_core::scene::Scene;
use pelage_fur::layout::Frame;
use pelage_fur::{camera, view};
use std::f32::consts::TAU;

/// Steps of the filter's table.
const STEPS: usize = 512;

/// Draws offsets along one axis in proportion to the absolute value of the reconstruction filter.
// [Ernst2006] filter importance sampling
#[derive(Debug, Clone)]
struct FilterSampler {
    /// Pixels.
    radius: f32,
    /// Cumulative distribution, 0 to 1.
    sums: Vec<f32>,
    /// Weight of a sample in each step: the filter's value over the density.
    weights: Vec<f32>,
}

/// A camera that makes rays.
#[derive(Debug, Clone)]
pub struct View {
    frame: Frame,
    /// Diameter of the aperture (cm) and focus distance (cm), if there is a lens.
    lens: Option<(f32, f32)>,
    filter: FilterSampler,
    bounds: Bounds,
}

/// A ray from the camera.
#[derive(Debug, Clone, Copy)]
pub struct CameraRay {
    /// Starts where it comes near the scene, so that points on it are as exact as those of rays
    /// within.
    pub ray: Ray,
    /// Depth of its start, cm along the viewing direction.
    pub depth: f32,
    /// Change of depth per length of the ray.
    pub depth_rate: f32,
    /// Weight by the pixel's filter; negative in the outer lobes of some.
    pub weight: f32,
}

impl FilterSampler {
    fn new(scene: &Scene) -> Self {
        let kind = scene.film.filter;
        let radius = scene.film.filter_radius.unwrap_or_else(|| filter::usual_radius(kind));
        let width = 2.0 * f64::from(radius) / STEPS as f64;
        let value = |i: usize| {
            filter::weight_1d(kind, f64::from(radius), (i as f64 + 0.5) * width - f64::from(radius))
        };
        let values: Vec<f64> = (0..STEPS).map(value).collect();
        let whole: f64 = values.iter().sum();
        let absolute: f64 = values.iter().map(|v| v.abs()).sum();
        let mut sum = 0.0;
        let mut sums = vec![0.0];
        for v in &values {
            sum += v.abs() / absolute;
            sums.push(sum as f32);
        }
        let weights = values.iter().map(|v| (v.signum() * absolute / whole) as f32).collect();
        Self { radius, sums, weights }
    }

    /// Offset from the pixel's centre, pixels, and the sample's weight, for a number in 0..1.
    fn draw(&self, u: f32) -> (f32, f32) {
        let i = (self.sums.partition_point(|s| *s <= u).saturating_sub(1)).min(STEPS - 1);
        let width = self.sums[i + 1] - self.sums[i];
        let within = if width > 0.0 { ((u - self.sums[i]) / width).clamp(0.0, 1.0) } else { 0.5 };
        (((i as f32 + within) / STEPS as f32 * 2.0 - 1.0) * self.radius, self.weights[i])
    }
}

impl View {
    /// The view of a scene whose content lies within `bounds`.
    pub fn new(scene: &Scene, bounds: Bounds) -> Self {
        let film = [scene.film.width, scene.film.height];
        let frame = camera::frame(&scene.camera, film, Vec2::ZERO, Vec2::ZERO, 0);
        let lens = scene.camera.lens.as_ref().filter(|l| l.aperture > 0.0).map(|l| {
            let distance = Vec3::from(scene.camera.target).distance(Vec3::from(scene.camera.eye));
            (l.aperture, l.focus.unwrap_or(distance).max(1e-3))
        });
        Self { frame, lens, filter: FilterSampler::new(scene), bounds }
    }

    /// The ray of a pixel, for two numbers that draw from the filter and two that draw from the
    /// lens, each in 0..1.
    pub fn ray(&self, pixel: [u32; 2], u: [f32; 4]) -> CameraRay {
        let (x, wx) = self.filter.draw(u[0]);
        let (y, wy) = self.filter.draw(u[1]);
        let mut frame = self.frame;
        if let Some((aperture, focus)) = self.lens {
            let offset = Vec2::from_angle(TAU * u[3]) * (0.5 * aperture * u[2].sqrt());
            let moved =
                Vec3::from(frame.eye) + offset.x * Vec3::from(frame.right) + offset.y * Vec3::from(frame.up);
            frame.eye = moved.into();
            frame.lens_shear = (offset / focus).into();
        }
        let at = Vec2::new(pixel[0] as f32 + 0.5 + x, pixel[1] as f32 + 0.5 + y);
        let slope = view::ray_through(&frame, at);
        let length = slope.length();
        let direction = slope / length;
        let (eye, d) = (Vec3::from(frame.eye).as_dvec3(), direction.as_dvec3());
        let start = self.distance(Vec3::from(frame.eye), direction).max(frame.near * length);
        let origin = (eye + f64::from(start) * d).as_vec3();
        CameraRay {
            ray: Ray::new(Vec3A::from(origin), Vec3A::from(direction)),
            depth: start / length,
            depth_rate: 1.0 / length,
            weight: wx * wy,
        }
    }

    /// Distance to the box around the scene.
    fn distance(&self, origin: Vec3, direction: Vec3) -> f32 {
        let mut enter = 0f32;
        for k in 0..3 {
            let (low, high) = (self.bounds.low[k], self.bounds.high[k]);
            if direction[k].abs() > 1e-9 {
                let (a, b) = ((low - origin[k]) / direction[k], (high - origin[k]) / direction[k]);
                enter = enter.max(a.min(b));
            }
        }
        // A ray that misses the box may start anywhere.
        if enter.is_finite() { 0.9999 * enter } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_core::scene::Filter;

    #[test]
    fn drawn_offsets_have_the_moments_of_the_filter() {
        for kind in [Filter::Box, Filter::Triangle, Filter::Gaussian, Filter::Mitchell] {
            let mut scene = Scene::default();
            scene.film.filter = kind;
            let sampler = FilterSampler::new(&scene);
            let radius = f64::from(filter::usual_radius(kind));
            let n = 200_000;
            let (mut sums, mut wanted) = ([0f64; 3], [0f64; 3]);
            for i in 0..n {
                let (x, w) = sampler.draw((i as f32 + 0.5) / n as f32);
                let at = (f64::from(i) + 0.5) / f64::from(n) * 2.0 * radius - radius;
                let f = filter::weight_1d(kind, radius, at);
                for (k, (sum, want)) in sums.iter_mut().zip(&mut wanted).enumerate() {
                    *sum += f64::from(w) * f64::from(x).powi(2 * k as i32) / f64::from(n);
                    *want += f * at.powi(2 * k as i32);
                }
            }
            for k in 0..3 {
                let want = wanted[k] / wanted[0];
                assert!((sums[k] - want).abs() < 2e-3 * (1.0 + want), "{kind:?} {k}: {} {want}", sums[k]);
            }
        }
    }
}
