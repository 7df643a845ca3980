//! The groom's undercoat on a torus, realised as hairs with the number, thickness and unevenness of
//! the volume (`shaders/shared/clumps.wgsl`).
//!
//! Hairs are denser where the noise is high, end where the volume's noise ends them, and wander as
//! the volume's tangents do. Their optical depth is the volume's, hairs/cm² times diameter, however
//! they bend.

use super::guard::whole;
use super::means::SkinSamples;
use super::strand::{Hair, HairSource, Knot};
use super::torus::PeriodicNoise;
use glam::{Vec2, Vec3};
use pelage_core::scene::{NoiseDomain, Undercoat};
use pelage_fur::parameters::Parameter;
use pelage_fur::random::{hash2, random, random_direction};
use pelage_fur::undercoat::{
    LEAN_STRETCH, LOCKS_SCALE, LOCKS_SHIFT, SWELLS_SHIFT, clump_factor, end_height, hair_top, taper,
};

/// Knots of a hair besides its root.
const SEGMENTS: u32 = 9;

/// Largest relative variation of brightness between hairs.
const TONE: f32 = 0.2;

/// Rejection-sampling attempts for a root; the last candidate is accepted.
const ATTEMPTS: u32 = 64;

/// The undercoat of a patch.
pub(super) struct UndercoatFur<'a> {
    undercoat: &'a Undercoat,
    count: u32,
    /// Number of hairs that each one represents.
    weight: f32,
    /// Height of the volume, cm.
    pub height: f32,
    patch: f32,
    color_root: Vec3,
    color_tip: Vec3,
    clumps: PeriodicNoise,
    locks: PeriodicNoise,
    swells: PeriodicNoise,
    seed: u32,
}

impl<'a> UndercoatFur<'a> {
    /// The undercoat `undercoat` on a torus of `patch` cm, as at most `most` hairs, each
    /// representing several if there are more. `combed` stretches the noise along u, as the
    /// volume's is along its lean.
    pub fn new(
        undercoat: &'a Undercoat,
        means: &SkinSamples,
        patch: f32,
        combed: bool,
        seed: u32,
        most: u32,
    ) -> Self {
        let thick = undercoat.diameter[0] > 0.0;
        let height = if thick { means.scalar(Parameter::UndercoatHeight) } else { 0.0 };
        let wanted =
            if height > 0.0 { means.scalar(Parameter::UndercoatDensity) * patch * patch } else { 0.0 };
        let (count, weight) = whole(wanted, most);
        // In the uv domain, frequencies are per unit of uv.
        let unit = match undercoat.noise_domain {
            NoiseDomain::Uv => means.uv_unit().unwrap_or(1.0),
            NoiseDomain::Object => 1.0,
        };
        let stretch = if combed && undercoat.lean > 0.0 { 1.0 - LEAN_STRETCH } else { 1.0 };
        let periods = |frequency: f32, stretch: f32| {
            let n = (frequency * patch / unit).min(1e4);
            [n * stretch, n]
        };
        Self {
            undercoat,
            count,
            weight,
            height,
            patch,
            color_root: means.color(Parameter::UndercoatColorRoot),
            color_tip: means.color(Parameter::UndercoatColorTip),
            clumps: PeriodicNoise::new(seed, periods(undercoat.noise_frequency, stretch), 0.0),
            locks: PeriodicNoise::new(
                seed,
                periods(LOCKS_SCALE * undercoat.noise_frequency, stretch),
                f64::from(LOCKS_SHIFT),
            ),
            swells: PeriodicNoise::new(
                seed,
                periods(undercoat.height_frequency, 1.0),
                f64::from(SWELLS_SHIFT),
            ),
            seed: hash2(seed, 0x756e_6465),
        }
    }

    /// The volume's clump factor at height `t` above `at`, in units of the torus's edges.
    fn clump(&self, at: Vec2, t: f32) -> f32 {
        clump_factor(self.undercoat.noise_contrast, t, self.clumps.at(at), self.locks.at(at))
    }
}

/// Height at which the clump factor is evaluated for drawing roots: where hairs compete most.
const MIDDLE: f32 = 0.5;

impl HairSource for UndercoatFur<'_> {
    fn count(&self) -> u32 {
        self.count
    }

    fn root(&self, i: u32) -> [f32; 2] {
        let seed = hash2(self.seed, i);
        let mut at = Vec2::ZERO;
        for k in 0..ATTEMPTS {
            at = Vec2::new(random(seed, 3 * k + 100), random(seed, 3 * k + 101));
            // The noises stay within about ±1, so the factor stays below 1 + 0.675 x 1.1 times the
            // contrast.
            if random(seed, 3 * k + 102) * (1.0 + 0.75 * self.undercoat.noise_contrast)
                < self.clump(at, MIDDLE)
            {
                break;
            }
        }
        at.to_array()
    }

    fn hair(&self, i: u32) -> Hair {
        let undercoat = self.undercoat;
        let seed = hash2(self.seed, i);
        let root = self.root(i);
        let at = Vec2::from(root);
        // The fractions of ended hairs are evenly distributed, so that the volume thins out as
        // hairs end one after the other.
        let ended = (0.618_034 * f64::from(i) + f64::from(random(self.seed, 0))).fract() as f32;
        let top = hair_top(undercoat.height_variation, self.swells.at(at), self.locks.at(at));
        let end = end_height(top, ended).clamp(0.02, 1.0);
        let height = end * self.height;
        let jitter = 2.0 * Vec2::new(random(seed, 0), random(seed, 1)) - 1.0;
        let turns = [0, 1, 2].map(|k| random_direction(seed, 10 + 2 * k));
        let ratio = undercoat.diameter[1] / undercoat.diameter[0].max(1e-6);
        let middle = self.clump(at, MIDDLE).max(1e-3);
        // DEVIATION: the volume has one colour per height. Dense hairs of a single colour look like
        // fog, so brightness varies between hairs, as far as the mean can be kept.
        let brightest = self.color_root.max(self.color_tip).max_element().max(1e-3);
        let tone = 1.0 + TONE.min((1.0 / brightest - 1.0).max(0.0)) * (2.0 * random(seed, 2) - 1.0);
        let mut offset = Vec3::ZERO;
        let mut length = 0.0;
        let mut knots: Vec<Knot> = (0..=SEGMENTS)
            .map(|k| {
                let s = k as f32 / SEGMENTS as f32;
                let t = s * end;
                let growth = t.powf(undercoat.jitter_exponent);
                if k > 0 {
                    // The direction is interpolated between three random ones.
                    let x = 2.0 * s;
                    let turn =
                        if x < 1.0 { turns[0].lerp(turns[1], x) } else { turns[1].lerp(turns[2], x - 1.0) };
                    let d = Vec3::Z + undercoat.tangent_jitter * growth * turn;
                    let step = (d / d.z.max(0.3)).truncate().extend(1.0) * (height / SEGMENTS as f32);
                    length += step.length();
                    offset += step;
                }
                let clump = self.clump(at + undercoat.uv_jitter * growth * jitter / self.patch, t).max(0.0);
                Knot {
                    offset,
                    diameter: undercoat.diameter[0] * taper(ratio, t) * 1e-4,
                    opacity: self.weight * clump / middle,
                    color: self.color_root.lerp(self.color_tip, t) * tone,
                }
            })
            .collect();
        // Bends lengthen a hair but must not increase the optical depth.
        let straight = if length > 0.0 { height / length } else { 1.0 };
        knots.iter_mut().for_each(|k| k.opacity *= straight);
        Hair { root, knots, guard: false }
    }
}
