//! The groom's guard hairs on a torus: those of `shaders/guard_strands.wgsl`, upright. Comb and
//! gravity are left out, because the renderer bends the shells along the combed hair. A combed hair
//! rises less, so all are given the mean height of combed hair on the skin, and are made thicker by
//! the same factor so that each keeps its coverage.

use super::means::SkinSamples;
use super::strand::{Hair, HairSource, Knot};
use super::torus::{ClumpCentres, even_root};
use glam::{Vec2, Vec3, Vec4};
use pelage_fur::guard_strands::{end_colors, strand_at};
use pelage_fur::layout::Groom;
use pelage_fur::parameters::{Maps, MeshPlace, Parameter, SkinPoint};
use pelage_fur::random::hash2;
use pelage_fur::strand_curve::{color_at, control_polygon, leg_directions};

/// The point at which every hair grows before it is moved to its root on the torus.
const UPRIGHT: SkinPoint = SkinPoint {
    position: Vec3::ZERO,
    normal: Vec3::Z,
    uv: Vec2::ZERO,
    color: Vec4::ONE,
    place: MeshPlace::Vertex(0),
};

/// The guard hairs of a patch.
pub(super) struct GuardFur {
    /// The groom at its means, without comb and gravity.
    groom: Groom,
    count: u32,
    /// Number of hairs that each one represents.
    weight: f32,
    /// Length before its variation, cm.
    length: f32,
    /// Height of the tip of a combed hair relative to its length.
    rise: f32,
    clumps: ClumpCentres,
    seed: u32,
}

impl GuardFur {
    /// The groom's guard hairs on a torus of `patch` cm; at most `most`, each representing several
    /// if there are more.
    pub fn new(means: &SkinSamples, patch: f32, seed: u32, most: u32) -> Self {
        let seed = hash2(seed, 0x6775_6172);
        let area = patch * patch;
        let length = means.scalar(Parameter::GuardLength);
        let wanted = if length > 0.0 { means.scalar(Parameter::GuardDensity) * area } else { 0.0 };
        let (count, weight) = whole(wanted, most);
        let mut groom = means.mean_groom();
        let rise = rise(&groom, means);
        let mean = &mut groom.coats[0];
        mean.hairs.comb_direction = [0.0; 3];
        mean.hairs.gravity = 0.0;
        let clump = &mut mean.parameters[Parameter::GuardClump as usize].value;
        *clump = clump.map(|strength| strength.min(1.0));
        let clump_density = mean.hairs.clump_density;
        Self {
            groom,
            count,
            weight,
            length,
            rise,
            clumps: ClumpCentres::new(clump_density * area, Vec2::splat(patch), hash2(seed, 1)),
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

/// Height of the tip of a hair of length 1, combed and bent as the groom says, averaged over the
/// skin.
fn rise(groom: &Groom, means: &SkinSamples) -> f32 {
    let hairs = &groom.coats[0].hairs;
    let comb =
        Vec3::from(hairs.comb_direction) * groom.coats[0].parameters[Parameter::GuardComb as usize].value[0];
    let mean = means.over_normals(|n| {
        let lean = comb.reject_from_normalized(n);
        let polygon = control_polygon(n, leg_directions(n, lean, hairs.gravity));
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

impl HairSource for GuardFur {
    fn count(&self) -> u32 {
        self.count
    }

    fn root(&self, i: u32) -> [f32; 2] {
        even_root(self.seed, i, self.count)
    }

    fn hair(&self, i: u32) -> Hair {
        let groom = &self.groom;
        let seed = hash2(hash2(self.seed, 2), i);
        let root = self.root(i);
        let maps = Maps { groom, texels: &[] };
        let to_clump = |_: f32| self.clumps.nearest(root.into()).extend(0.0);
        let mut strand = strand_at(&maps, &UPRIGHT, [Vec3::X, Vec3::Y], seed, to_clump);
        strand.control = strand.control.map(|p| p * Vec3::new(1.0, 1.0, self.rise));
        let ends = end_colors(&maps, &UPRIGHT, seed);
        // Finer than the groom's tessellation: strongly bent frizz would show corners in the fin.
        let segments = groom.segments.max(32);
        let knots = (0..=segments)
            .map(|k| {
                let s = k as f32 / segments as f32;
                Knot {
                    offset: strand.point(s),
                    diameter: strand.diameter(s) / self.rise,
                    opacity: self.weight * strand.opacity(s),
                    color: color_at(strand.hairs.color_transition, ends, s),
                }
            })
            .collect();
        Hair { root, knots, guard: true }
    }
}
