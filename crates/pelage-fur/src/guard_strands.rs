//! Twin of `shaders/guard_strands.wgsl`: guard hairs as tessellated cubic Bézier curves.
// [Andersen2016] sec. 2

use crate::layout::{Groom, GuardHairs, Root};
use crate::parameters::{Maps, Parameter, SkinPoint, root_point};
use crate::random::{hash2, random};
use crate::shell::Shell;
use crate::strand_curve::{
    self, bezier, control_polygon, curl_and_frizz, leg_directions, rayleigh, side_at, sides,
};
use crate::strands::vertex;
use glam::{IVec3, Vec3};
use std::f32::consts::TAU;

/// A strand before tessellation. Vectors are relative to the root, in cm, except `root` itself.
#[derive(Debug, Clone, Copy)]
pub struct Strand {
    /// Root on the skin, world space, cm.
    pub root: Vec3,
    /// Normal of the skin, unit.
    pub normal: Vec3,
    /// Length, cm.
    pub length: f32,
    /// The inner control points and the tip, cm.
    pub control: [Vec3; 3],
    pull: Vec3,
    sides: [Vec3; 2],
    curl: f32,
    frizz: f32,
    thickness: f32,
    /// The guard hairs at the root.
    pub hairs: GuardHairs,
    seed: u32,
}

/// Vector from a point to the nearest centre of a jittered grid, which has one in each cell.
/// `cells` are the cells around the point; `seed` is that of a cell, and `offset` the vector from
/// the point to a place of the grid, whose cells are units.
// [Worley1996]
pub fn nearest_centre(
    cells: impl Iterator<Item = IVec3>,
    seed: impl Fn(IVec3) -> u32,
    offset: impl Fn(Vec3) -> Vec3,
) -> Vec3 {
    let mut best = Vec3::ZERO;
    let mut least = 1e30;
    for cell in cells {
        let h = seed(cell);
        let jitter = Vec3::new(random(h, 0), random(h, 1), random(h, 2));
        let offset = offset(cell.as_vec3() + jitter);
        if offset.dot(offset) < least {
            least = offset.dot(offset);
            best = offset;
        }
    }
    best
}

/// Vector from `p` (cm) to the nearest clump centre, cm.
fn to_clump(groom: &Groom, clump_density: f32, p: Vec3) -> Vec3 {
    let size = 1.0 / clump_density.max(1e-6).sqrt();
    let cell = (p / size).floor().as_ivec3();
    nearest_centre(
        (0..27).map(|i| cell + IVec3::new(i % 3, (i / 3) % 3, i / 9) - 1),
        |c| hash2(hash2(c.x as u32, c.y as u32), c.z as u32 ^ groom.seed),
        |place| place * size - p,
    )
}

/// Diameter at `s` (0 root, 1 tip), cm.
pub fn diameter(hairs: &GuardHairs, s: f32) -> f32 {
    strand_curve::diameter(hairs.diameter, hairs.widest, s)
}

/// Opacity at `s` (0 root, 1 tip).
pub fn opacity(hairs: &GuardHairs, s: f32) -> f32 {
    hairs.opacity * (-hairs.tip_fade * s).exp()
}

/// Colours at the root and the tip of the hair with this seed, linear RGB.
pub fn end_colors(maps: &Maps<'_>, at: &SkinPoint, seed: u32) -> [Vec3; 2] {
    let tone = 1.0 + maps.hairs_at(at).color_variation * (2.0 * random(seed, 6) - 1.0);
    [Parameter::GuardColorRoot, Parameter::GuardColorTip].map(|p| maps.color(p, at) * tone)
}

/// The strand that grows from a root.
pub fn strand(shell: &Shell, maps: &Maps<'_>, root: &Root) -> Strand {
    let at = root_point(shell, root);
    strand_at_point(maps, &at, root.seed)
}

/// The strand with this seed that grows at a point of the skin.
pub fn strand_at_point(maps: &Maps<'_>, at: &SkinPoint, seed: u32) -> Strand {
    let place = at.position - Vec3::from(maps.groom.origin);
    strand_at(maps, at, sides(at.normal), seed, |density| to_clump(maps.groom, density, place))
}

/// The strand with this seed that grows at a point of the skin. `sides` are those of its normal,
/// from the first of which azimuths are measured; `to_clump` gives the vector from the point to the
/// nearest clump centre, cm, where there are as many 1/cm² as its argument says.
pub fn strand_at(
    maps: &Maps<'_>,
    at: &SkinPoint,
    sides: [Vec3; 2],
    seed: u32,
    to_clump: impl Fn(f32) -> Vec3,
) -> Strand {
    let hairs = maps.hairs_at(at);
    let n = at.normal;
    let length = maps.scalar(Parameter::GuardLength, at) * (1.0 - hairs.length_variation * random(seed, 0));
    let spread = hairs.spread * rayleigh(random(seed, 1));
    let random_side = side_at(sides, TAU * random(seed, 2));
    let lean = maps.combed_lean(at, n) + spread * random_side;
    let legs = leg_directions(n, lean, hairs.gravity).map(|leg| leg * (length / 3.0));
    let control = control_polygon(n, legs);
    Strand {
        root: at.position,
        normal: n,
        length,
        control,
        pull: maps.clump_pull(at, to_clump),
        sides,
        curl: maps.scalar(Parameter::GuardCurl, at),
        frizz: maps.scalar(Parameter::GuardFrizz, at),
        thickness: maps.scalar(Parameter::GuardThickness, at),
        hairs,
        seed,
    }
}

impl Strand {
    /// Point at `s` (0 root, 1 tip), world space, cm.
    pub fn point(&self, s: f32) -> Vec3 {
        let frequencies = [self.hairs.curl_frequency, self.hairs.frizz_frequency];
        let [side, other] = self.sides;
        let [curl, frizz] = curl_and_frizz(self.seed, self.length, frequencies, s)
            .map(|across| across.x * side + across.y * other);
        self.root
            + bezier(self.control, s)
            + self.pull * s * s
            + self.curl * s * curl
            + self.frizz * s * frizz
    }

    /// Diameter at `s` (0 root, 1 tip), cm, thickness included.
    pub fn diameter(&self, s: f32) -> f32 {
        self.thickness * diameter(&self.hairs, s)
    }

    /// Opacity at `s` (0 root, 1 tip).
    pub fn opacity(&self, s: f32) -> f32 {
        opacity(&self.hairs, s)
    }

    /// The tessellated strand, `groom.segments + 1` packed vertices (see [`vertex`]).
    pub fn vertices(&self, groom: &Groom) -> Vec<[f32; 4]> {
        (0..=groom.segments)
            .map(|k| {
                let s = k as f32 / groom.segments as f32;
                vertex(self.point(s), 0.5 * self.diameter(s), self.opacity(s))
            })
            .collect()
    }
}
