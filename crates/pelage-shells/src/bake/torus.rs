//! Random structures on a torus: noise, clump centres and roots that wrap around.

use glam::{IVec3, Vec2};
use noise::{NoiseFn, Simplex};
use pelage_fur::guard_strands::nearest_centre;
use pelage_fur::random::{R2_STEPS, hash2, random};
use std::f64::consts::TAU;

/// Standard deviation of the `noise` crate's three-dimensional simplex noise over all points and
/// seeds.
pub(super) const NOISE_SPREAD: f64 = 0.279;

/// Points per side of the grid on which a noise is measured.
const GRID: u32 = 48;

/// Simplex noise with the period of the torus: four-dimensional noise on a flat torus embedded in
/// four dimensions, so that lengths are preserved. Its mean over the torus is 0, its standard
/// deviation that of three-dimensional simplex noise.
// [Gustavson2005]
pub(super) struct PeriodicNoise {
    simplex: Simplex,
    radius: [f64; 2],
    shift: f64,
    mean: f64,
    gain: f64,
}

impl PeriodicNoise {
    /// Noise with `periods` bumps along u and v; `shift` distinguishes noises of the same seed.
    /// With less than one bump the amplitude is lower.
    pub fn new(seed: u32, periods: [f32; 2], shift: f64) -> Self {
        let radius = periods.map(|p| f64::from(p) / TAU);
        let mut noise = Self { simplex: Simplex::new(seed), radius, shift, mean: 0.0, gain: 1.0 };
        let (mut sum, mut squares) = (0.0, 0.0);
        for (j, i) in (0..GRID).flat_map(|j| (0..GRID).map(move |i| (j, i))) {
            let x = noise.raw([i, j].map(|k| (f64::from(k) + 0.5) / f64::from(GRID)));
            sum += x;
            squares += x * x;
        }
        let count = f64::from(GRID * GRID);
        noise.mean = sum / count;
        let deviation = (squares / count - noise.mean * noise.mean).max(0.0).sqrt();
        // A torus smaller than a bump contains only part of it, which is not amplified to a whole
        // one.
        noise.gain = (NOISE_SPREAD / deviation.max(1e-6)).min(3.0);
        noise
    }

    fn raw(&self, uv: [f64; 2]) -> f64 {
        let [a, b] = uv.map(|x| TAU * x);
        let [r, s] = self.radius;
        let at = [r * a.cos(), r * a.sin(), s * b.cos(), s * b.sin()];
        self.simplex.get(at.map(|x| x + self.shift))
    }

    /// The noise at `uv`, in units of the torus's edges.
    pub fn at(&self, uv: Vec2) -> f32 {
        let wrapped = uv - uv.floor();
        ((self.raw([f64::from(wrapped.x), f64::from(wrapped.y)]) - self.mean) * self.gain) as f32
    }
}

/// Clump centres: one at a random place in each cell of a grid that wraps around.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClumpCentres {
    /// Cells along u and v.
    pub cells: [u32; 2],
    /// Edges of the torus, cm.
    pub patch: Vec2,
    /// Seed of the random places.
    pub seed: u32,
}

impl ClumpCentres {
    /// About `count` centres, in cells that are as nearly square as possible.
    pub fn new(count: f32, patch: Vec2, seed: u32) -> Self {
        let count = count.clamp(1.0, 1e8);
        let along = (count * patch.x / patch.y).sqrt().round().clamp(1.0, count.max(1.0));
        let cells = [along as u32, ((count / along).round() as u32).max(1)];
        Self { cells, patch, seed }
    }

    /// Vector from `uv` (in units of the torus's edges) to the nearest centre, cm.
    pub fn nearest(&self, uv: Vec2) -> Vec2 {
        let [columns, rows] = self.cells.map(|n| n as i32);
        let n = Vec2::new(columns as f32, rows as f32);
        let at = (uv - uv.floor()) * n;
        let cell = at.floor().as_ivec2().extend(0);
        let nearest = nearest_centre(
            (0..9).map(|i| cell + IVec3::new(i % 3 - 1, i / 3 - 1, 0)),
            |c| hash2(hash2(self.seed, c.x.rem_euclid(columns) as u32), c.y.rem_euclid(rows) as u32),
            |place| ((place.truncate() - at) / n * self.patch).extend(0.0),
        );
        nearest.truncate()
    }
}

/// Place of root `i` of `count` in units of the torus's edges: a jittered low-discrepancy sequence,
/// even but without visible rows.
// [Roberts2018]
pub(super) fn even_root(seed: u32, i: u32, count: u32) -> [f32; 2] {
    let h = hash2(seed, i);
    let shake = 2.0 / f64::from(count.max(1)).sqrt();
    [(0u32, R2_STEPS[0]), (1, R2_STEPS[1])].map(|(k, step)| {
        let start = f64::from(random(seed, k));
        let x = start + f64::from(i) * step + shake * f64::from(random(h, 20 + k) - 0.5);
        // Truncated to 24 bits, so that no place rounds up to 1.
        ((x - x.floor()) * 16_777_216.0).floor() as f32 / 16_777_216.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spread_of_simplex_noise_is_known() {
        let mut squares = 0.0;
        let mut count = 0.0;
        for seed in 0..8 {
            let noise = Simplex::new(seed);
            for i in 0..20_000u32 {
                let at = [0, 1, 2].map(|k| f64::from(random(i, k)) * 40.0);
                squares += noise.get(at).powi(2);
                count += 1.0;
            }
        }
        let deviation = f64::sqrt(squares / count);
        assert!((deviation - NOISE_SPREAD).abs() < 0.005, "{deviation}");
    }

    #[test]
    fn noise_wraps_and_keeps_mean_and_spread() {
        for periods in [[7.0, 7.0], [2.5, 7.0], [1.0, 1.0]] {
            let noise = PeriodicNoise::new(3, periods, 0.0);
            let n = 97;
            let places = (0..n * n).map(|i| Vec2::new((i % n) as f32, (i / n) as f32) / n as f32);
            let (mut sum, mut squares) = (0.0, 0.0);
            for p in places {
                let x = noise.at(p);
                assert!((x - noise.at(p + Vec2::new(1.0, -2.0))).abs() < 1e-4);
                sum += f64::from(x);
                squares += f64::from(x * x);
            }
            // There is no step at the border.
            for k in 0..50 {
                let y = k as f32 / 50.0;
                for (low, high) in [
                    (Vec2::new(1e-4, y), Vec2::new(1.0 - 1e-4, y)),
                    (Vec2::new(y, 1e-4), Vec2::new(y, 1.0 - 1e-4)),
                ] {
                    assert!((noise.at(low) - noise.at(high)).abs() < 0.02, "{periods:?} at {low}");
                }
            }
            let (mean, deviation) = (sum / f64::from(n * n), (squares / f64::from(n * n)).sqrt());
            assert!(mean.abs() < 0.02, "{periods:?}: mean {mean}");
            assert!((deviation / NOISE_SPREAD - 1.0).abs() < 0.05, "{periods:?}: {deviation}");
        }
    }

    #[test]
    fn the_nearest_clump_centre_is_found_across_the_border() {
        let centres = ClumpCentres::new(25.0, Vec2::new(2.0, 1.0), 5);
        for i in 0..200 {
            let uv = Vec2::new(random(i, 0), random(i, 1));
            let offset = centres.nearest(uv);
            assert!((offset - centres.nearest(uv + Vec2::new(-1.0, 3.0))).length() < 1e-4);
            // The centre itself has none nearer than itself.
            let there = centres.nearest(uv + offset / centres.patch);
            assert!(there.length() < 1e-4, "{there}");
        }
    }
}
