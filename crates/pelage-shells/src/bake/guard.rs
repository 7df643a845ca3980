//! The groom's guard hairs on a torus: those of `shaders/guard_strands.wgsl`, upright. Comb and
//! gravity are left out, because the renderer bends the shells along the combed hair. A combed hair
//! rises less, so all are given the mean height of combed hair on the skin, and are made thicker by
//! the same factor so that each keeps its coverage.

use super::means::SkinSamples;
use super::strand::{Hair, HairSource, Knot};
use super::torus::{ClumpCentres, even_root};
use glam::{Vec2, Vec3};
use pelage_core::scene::Guard;
use pelage_fur::parameters::Parameter;
use pelage_fur::random::{hash2, random};
use pelage_fur::strand_curve::{
    bezier, control_polygon, curl_and_frizz, diameter, leg_directions, rayleigh, tip_share,
};
use std::f32::consts::TAU;

/// The guard hairs of a patch.
pub(super) struct GuardFur<'a> {
    guard: &'a Guard,
    count: u32,
    /// Number of hairs that each one represents.
    weight: f32,
    length: f32,
    /// Height of the tip of a combed hair relative to its length.
    rise: f32,
    thickness: f32,
    clump: f32,
    curl: f32,
    frizz: f32,
    color_root: Vec3,
    color_tip: Vec3,
    clumps: ClumpCentres,
    seed: u32,
}

impl<'a> GuardFur<'a> {
    /// The guard hairs of `guard` on a torus of `patch` cm; at most `most`, each representing
    /// several if there are more.
    pub fn new(guard: &'a Guard, means: &SkinSamples, patch: f32, seed: u32, most: u32) -> Self {
        let seed = hash2(seed, 0x6775_6172);
        let area = patch * patch;
        let length = means.scalar(Parameter::GuardLength);
        let wanted = if length > 0.0 { means.scalar(Parameter::GuardDensity) * area } else { 0.0 };
        let (count, weight) = whole(wanted, most);
        Self {
            guard,
            count,
            weight,
            length,
            rise: rise(guard, means),
            thickness: means.scalar(Parameter::GuardThickness),
            clump: means.scalar(Parameter::GuardClump).min(1.0),
            curl: means.scalar(Parameter::GuardCurl),
            frizz: means.scalar(Parameter::GuardFrizz),
            color_root: means.color(Parameter::GuardColorRoot),
            color_tip: means.color(Parameter::GuardColorTip),
            clumps: ClumpCentres::new(guard.clump_density * area, Vec2::splat(patch), hash2(seed, 1)),
            seed,
        }
    }

    /// Height below which the fraction `part` of the hairs' length x diameter lies, cm; 0 without
    /// hair.
    pub fn height_of(&self, part: f64) -> f32 {
        const BINS: usize = 1024;
        // A curl may rise slightly above the length of the hair.
        let top = (self.length * 1.25).max(1e-6);
        let mut area = vec![0.0f64; BINS];
        for i in 0..self.count {
            for pair in self.hair(i).knots.windows(2) {
                let [a, b] = [pair[0], pair[1]];
                for k in 0..8 {
                    let x = (k as f32 + 0.5) / 8.0;
                    let z = a.offset.z + (b.offset.z - a.offset.z) * x;
                    let amount = (b.offset - a.offset).length()
                        * (a.diameter * a.opacity * (1.0 - x) + b.diameter * b.opacity * x);
                    area[((z / top * BINS as f32).max(0.0) as usize).min(BINS - 1)] += f64::from(amount);
                }
            }
        }
        let wanted = part * area.iter().sum::<f64>();
        let mut sum = 0.0;
        let last = area.iter().position(|a| {
            sum += a;
            sum > 0.0 && sum >= wanted
        });
        last.map_or(0.0, |bin| top * (bin + 1) as f32 / BINS as f32)
    }
}

/// Height of the tip of a hair of length 1, combed and bent as `guard` says, averaged over the
/// skin.
fn rise(guard: &Guard, means: &SkinSamples) -> f32 {
    let comb = Vec3::from(guard.comb_direction).normalize_or_zero() * means.scalar(Parameter::GuardComb);
    let mean = means.over_normals(|n| {
        let lean = comb.reject_from_normalized(n);
        let polygon = control_polygon(n, leg_directions(n, lean, guard.gravity));
        polygon[2].dot(n) / 3.0
    });
    mean.clamp(0.1, 1.0)
}

/// The number of hairs to grow, at most `most`, and how many of the `wanted` ones each represents.
pub(super) fn whole(wanted: f32, most: u32) -> (u32, f32) {
    if wanted <= 0.0 {
        return (0, 0.0);
    }
    let count = (wanted.round() as u32).clamp(1, most.max(1));
    (count, wanted / count as f32)
}

impl HairSource for GuardFur<'_> {
    fn count(&self) -> u32 {
        self.count
    }

    fn root(&self, i: u32) -> [f32; 2] {
        even_root(self.seed, i, self.count)
    }

    fn hair(&self, i: u32) -> Hair {
        let g = self.guard;
        let seed = hash2(hash2(self.seed, 2), i);
        let root = self.root(i);
        let length = self.length * (1.0 - g.length_variation * random(seed, 0));
        let spread = g.spread.to_radians().tan() * rayleigh(random(seed, 1));
        let lean = (spread * Vec2::from_angle(TAU * random(seed, 2))).extend(0.0);
        let legs = leg_directions(Vec3::Z, lean, 0.0).map(|leg| leg * (length / 3.0));
        let polygon = control_polygon(Vec3::Z, legs);
        let pull = if self.clump > 0.0 { self.clump * self.clumps.nearest(root.into()) } else { Vec2::ZERO };
        let tone = 1.0 + g.color_variation * (2.0 * random(seed, 6) - 1.0);
        // Finer than the groom's tessellation: strongly bent frizz would show corners in the fin.
        let segments = g.segments.max(32);
        let knots = (0..=segments)
            .map(|k| {
                let s = k as f32 / segments as f32;
                let frequencies = [g.curl_frequency, g.frizz_frequency];
                let [curl, frizz] = curl_and_frizz(seed, length, frequencies, s);
                let across = pull * (s * s) + self.curl * s * curl + self.frizz * s * frizz;
                Knot {
                    offset: bezier(polygon, s) * Vec3::new(1.0, 1.0, self.rise) + across.extend(0.0),
                    diameter: self.thickness * diameter(g.diameter, g.widest, s) * 1e-4 / self.rise,
                    opacity: self.weight * g.opacity * (-g.tip_fade * s).exp(),
                    color: self.color(s, tone),
                }
            })
            .collect();
        Hair { root, knots, guard: true }
    }
}

impl GuardFur<'_> {
    fn color(&self, s: f32, tone: f32) -> Vec3 {
        let blend = tip_share(self.guard.color_transition, s);
        (self.color_root.lerp(self.color_tip, blend) * tone).clamp(Vec3::ZERO, Vec3::ONE)
    }
}
