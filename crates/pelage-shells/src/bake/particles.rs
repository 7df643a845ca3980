//! Hair grown by particles that rise through a box with periodic sides.
// [Lengyel2001] sec. 2.2

use super::strand::{Hair, HairSource, Knot};
use super::torus::{ClumpCentres, even_root};
use glam::{Vec2, Vec3};
use pelage_core::scene::Particles;
use pelage_fur::random::{hash2, random};
use std::f32::consts::TAU;

/// The hairs of `source = "particles"`.
pub(super) struct ParticleFur<'a> {
    parameters: &'a Particles,
    patch: Vec2,
    height: f32,
    seed: u32,
    steps: u32,
    clumps: ClumpCentres,
}

impl<'a> ParticleFur<'a> {
    /// Hair in a box of `patch` x `patch` x `height` cm.
    pub fn new(parameters: &'a Particles, patch: f32, height: f32, seed: u32) -> Self {
        let seed = hash2(seed, 0x7061_7274);
        let edge = Vec2::splat(patch);
        // Eight steps per turn, so that curls are round.
        let turns = if parameters.curl > 0.0 { parameters.curl_frequency.clamp(0.0, 100.0) } else { 0.0 };
        let steps = 12.max((8.0 * turns).ceil() as u32);
        let clumps = ClumpCentres::new(parameters.clumps as f32, edge, hash2(seed, 1));
        Self { parameters, patch: edge, height, seed, steps, clumps }
    }
}

impl HairSource for ParticleFur<'_> {
    fn count(&self) -> u32 {
        self.parameters.count
    }

    fn root(&self, i: u32) -> [f32; 2] {
        even_root(self.seed, i, self.parameters.count)
    }

    // DEVIATION: the paper does not say how the particles move. Here curl and clumps are offsets
    // from the particle's path, so that their radius and place can be set, and every particle rises
    // by equal steps.
    fn hair(&self, i: u32) -> Hair {
        let p = self.parameters;
        let seed = hash2(hash2(self.seed, 2), i);
        let root = self.root(i);
        let edge = self.patch.x;
        let height = self.height * (1.0 - p.length_variation * random(seed, 0)).max(1e-3);
        let tone = 1.0 + p.color_variation * (2.0 * random(seed, 1) - 1.0);
        let phase = TAU * random(seed, 2);
        let to_clump = if p.clump > 0.0 { p.clump * self.clumps.nearest(root.into()) } else { Vec2::ZERO };
        let (mut path, mut slope) = (Vec2::ZERO, Vec2::new(p.lean, 0.0));
        let ds = 1.0 / self.steps as f32;
        let knots = (0..=self.steps)
            .map(|k| {
                let s = k as f32 * ds;
                if k > 0 {
                    // Horizontal velocity per height: a random walk, and a drop that grows towards
                    // the tip.
                    let kick = Vec2::new(gauss(seed, 2 * k + 10), gauss(seed, 2 * k + 11));
                    slope += p.noise * ds.sqrt() * kick + Vec2::new(p.gravity * ds, 0.0);
                    path += slope * (height * ds);
                }
                let turn = phase + TAU * p.curl_frequency * s;
                let curl =
                    p.curl * edge * s.min(0.25) * 4.0 * (Vec2::from_angle(turn) - Vec2::from_angle(phase));
                let across = path + curl + s * s * to_clump;
                let color = Vec3::from(p.color_root).lerp(Vec3::from(p.color_tip), s) * tone;
                Knot {
                    offset: across.extend(height * s),
                    diameter: edge * (p.diameter[0] + (p.diameter[1] - p.diameter[0]) * s),
                    opacity: 1.0,
                    color: color.clamp(Vec3::ZERO, Vec3::ONE),
                }
            })
            .collect();
        Hair { root, knots, guard: false }
    }
}

/// Approximately a standard normal deviate: the scaled sum of four uniform numbers.
fn gauss(seed: u32, k: u32) -> f32 {
    let sum: f32 = (0..4).map(|j| random(hash2(seed, k), j)).sum();
    (sum - 2.0) * 3f32.sqrt()
}
