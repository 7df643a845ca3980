//! Placement of samples: a regular grid in each pixel, and several passes over the image with
//! displaced grids or lens points where one grid does not hold them all.

use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use pelage_core::World;
use pelage_core::scene::{Coat, LensMethod, Scene};
use pelage_fur::camera;
use pelage_fur::layout::{Frame, Reconstruction};
use pelage_fur::random::r2;

/// How the film is sampled.
#[derive(Debug, Clone)]
pub struct SamplePlan {
    /// Samples along a pixel's edge in one pass over the image, 1 to 8.
    pub grid: u32,
    /// Passes over the image: displacement of the grid (samples) and point on the lens (lens
    /// diameters).
    pub passes: Vec<(Vec2, Vec2)>,
    /// Size of the film in samples of one pass.
    pub film: [u32; 2],
    /// Samples that the filter reaches beyond the pixel's own on each side.
    pub reach: u32,
}

/// Filter weights per axis that the shader's table holds.
const MAX_TAPS: u32 = 128;

impl SamplePlan {
    /// The plan for `film.spp` of a scene: the grid is the largest square of up to 8 by 8 samples
    /// that divides it (smaller if the filter's weights exceed their table, 1 by 1 with a lens),
    /// the quotient the number of passes.
    // [Roberts2018]
    pub fn new(scene: &Scene) -> Self {
        let spp = scene.film.spp.max(1);
        let lens = scene.camera.lens.as_ref().filter(|l| l.method == LensMethod::Samples && l.aperture > 0.0);
        let radius = radius(scene);
        let mut grid = (1..=8u32).rev().find(|k| spp.is_multiple_of(k * k)).unwrap_or(1);
        if lens.is_some() {
            // Each pass has one point on the lens, so each sample needs its own pass.
            grid = 1;
        }
        while grid > 1 && taps(radius, grid) > MAX_TAPS {
            grid = (1..grid).rev().find(|k| spp.is_multiple_of(k * k)).unwrap_or(1);
        }
        let count = spp / (grid * grid);
        let passes = (0..count)
            .map(|i| {
                let jitter = if count == 1 { Vec2::ZERO } else { r2(Vec2::splat(0.5), i) - 0.5 };
                (jitter, if lens.is_some() { disc(r2(Vec2::splat(0.5), i + 1)) * 0.5 } else { Vec2::ZERO })
            })
            .collect();
        Self {
            grid,
            passes,
            film: [scene.film.width * grid, scene.film.height * grid],
            reach: reach(radius, grid),
        }
    }

    /// The uniform `reconstruction` of the film pass, for a tile of `pixels` pixels in pass `pass`
    /// over the image.
    pub fn reconstruction(
        &self,
        scene: &Scene,
        pass: usize,
        pixels: [u32; 2],
        planes: u32,
    ) -> Reconstruction {
        let (weights, taps) = self.weights(scene, self.passes[pass].0.x);
        Reconstruction {
            origin: [self.reach as i32; 2],
            pixels,
            grid: self.grid,
            reach: self.reach as i32,
            taps,
            planes,
            accumulate: u32::from(pass > 0),
            scale: 1.0 / self.passes.len() as f32,
            weights,
            ..Reconstruction::zeroed()
        }
    }

    /// The frame globals of a pass over the image; the tile is not set.
    pub fn frame(&self, scene: &Scene, pass: usize) -> Frame {
        let (jitter, lens) = self.passes[pass];
        camera::frame(&scene.camera, self.film, lens, jitter, scene.render.seed)
    }

    /// Diameter of the circle of confusion, in samples, at the nearest or farthest point of the
    /// fur, whichever is larger. 0 if no pass samples the lens.
    // [Potmesil1981]
    pub fn blur_margin(&self, world: &World) -> f32 {
        let camera = &world.scene.camera;
        let Some(lens) = camera.lens.as_ref().filter(|_| self.passes.iter().any(|(_, l)| l.length() > 0.0))
        else {
            return 0.0;
        };
        let frame = self.frame(&world.scene, 0);
        let (low, high) = world.skin.bounds();
        let forward = Vec3::from(frame.forward);
        let focus =
            lens.focus.unwrap_or((Vec3::from(camera.target) - Vec3::from(camera.eye)).length()).max(1e-3);
        let largest = |of: fn(&Coat<'_>) -> f32| world.scene.largest(of);
        let fur = largest(|coat| coat.guard.length.max()) + largest(|coat| coat.undercoat.height.max());
        (0..8)
            .flat_map(|i| {
                let corner = Vec3::new(
                    if i & 1 == 0 { low.x } else { high.x },
                    if i & 2 == 0 { low.y } else { high.y },
                    if i & 4 == 0 { low.z } else { high.z },
                );
                let z = (corner - Vec3::from(camera.eye)).dot(forward);
                [z - fur, z + fur].map(|z| {
                    let z = z.max(frame.near);
                    (1.0 / z - 1.0 / focus).abs() * lens.aperture * 0.5 * frame.film_size[1] / frame.tan_y
                })
            })
            .fold(0.0, f32::max)
    }

    /// The filter's weights along an axis, normalised and packed four per vector, and their number.
    /// `jitter`: displacement of the grid, samples.
    fn weights(&self, scene: &Scene, jitter: f32) -> ([[f32; 4]; 32], u32) {
        let taps = self.grid + 2 * self.reach;
        let radius = radius(scene);
        let mut weights: Vec<f32> = (0..taps)
            .map(|i| {
                let x = (i as f32 - self.reach as f32 + 0.5 + jitter) / self.grid as f32 - 0.5;
                pelage_core::film::filter::weight_1d(scene.film.filter, f64::from(radius), f64::from(x))
                    as f32
            })
            .collect();
        let sum: f32 = weights.iter().sum();
        if sum.abs() > 1e-12 {
            weights.iter_mut().for_each(|w| *w /= sum);
        } else {
            let middle = weights.len() / 2;
            weights[middle] = 1.0;
        }
        let mut packed = Reconstruction::zeroed().weights;
        for (i, w) in weights.iter().enumerate() {
            packed[i / 4][i % 4] = *w;
        }
        (packed, taps)
    }
}

fn radius(scene: &Scene) -> f32 {
    scene.film.filter_radius.unwrap_or_else(|| pelage_core::film::filter::usual_radius(scene.film.filter))
}

fn reach(radius: f32, grid: u32) -> u32 {
    ((radius - 0.5).max(0.0) * grid as f32).ceil() as u32
}

fn taps(radius: f32, grid: u32) -> u32 {
    grid + 2 * reach(radius, grid)
}

/// Area-preserving map from the unit square to the unit disc.
// [Pharr2023]
fn disc(u: Vec2) -> Vec2 {
    Vec2::from_angle(std::f32::consts::TAU * u.y) * u.x.sqrt()
}
