//! Twin of `shaders/guard_strands.wgsl`: guard hairs as tessellated cubic Bézier curves.
// [Andersen2016] sec. 2

use crate::layout::{Groom, Root};
use crate::parameters::{Maps, Parameter, skin_point};
use crate::random::{hash2, random};
use crate::shell::Shell;
use crate::strand_curve::{self, bezier, control_polygon, curl_and_frizz, leg_directions, rayleigh};
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
    side: Vec3,
    other: Vec3,
    curl: f32,
    frizz: f32,
    thickness: f32,
    seed: u32,
}

/// Vector from `p` (cm) to the nearest clump centre, cm; each cell of a jittered grid has one
/// centre.
// [Worley1996]
fn to_clump(groom: &Groom, p: Vec3) -> Vec3 {
    let size = 1.0 / groom.clump_density.max(1e-6).sqrt();
    let cell = (p / size).floor().as_ivec3();
    let mut best = Vec3::ZERO;
    let mut least = 1e30;
    for i in 0..27 {
        let c = cell + IVec3::new(i % 3, (i / 3) % 3, i / 9) - 1;
        let h = hash2(hash2(c.x as u32, c.y as u32), c.z as u32 ^ groom.seed);
        let jitter = Vec3::new(random(h, 0), random(h, 1), random(h, 2));
        let offset = (c.as_vec3() + jitter) * size - p;
        if offset.dot(offset) < least {
            least = offset.dot(offset);
            best = offset;
        }
    }
    best
}

/// Diameter at `s` (0 root, 1 tip), cm.
pub fn diameter(groom: &Groom, s: f32) -> f32 {
    strand_curve::diameter(groom.diameter, groom.widest, s)
}

/// The strand that grows from a root.
pub fn strand(shell: &Shell, maps: &Maps<'_>, root: &Root) -> Strand {
    let groom = maps.groom;
    let seed = root.seed;
    let [l1, l2] = root.lambda;
    let at = skin_point(shell, root.prism, Vec3::new(1.0 - l1 - l2, l1, l2));
    let n = at.normal;
    let across = if n.x.abs() > 0.7 { Vec3::Y } else { Vec3::X };
    let side = across.cross(n).normalize();
    let other = n.cross(side);
    let length = maps.scalar(Parameter::GuardLength, &at) * (1.0 - groom.length_variation * random(seed, 0));
    let comb_direction = Vec3::from(groom.comb_direction);
    let combed = comb_direction - n * n.dot(comb_direction);
    let spread = groom.spread * rayleigh(random(seed, 1));
    let phi = TAU * random(seed, 2);
    let lean =
        combed * maps.scalar(Parameter::GuardComb, &at) + spread * (phi.cos() * side + phi.sin() * other);
    let legs = leg_directions(n, lean, groom.gravity).map(|leg| leg * (length / 3.0));
    let control = control_polygon(n, legs);
    let clump = maps.scalar(Parameter::GuardClump, &at);
    let pull = if clump > 0.0 {
        let offset = to_clump(groom, at.position);
        clump * (offset - n * n.dot(offset))
    } else {
        Vec3::ZERO
    };
    Strand {
        root: at.position,
        normal: n,
        length,
        control,
        pull,
        side,
        other,
        curl: maps.scalar(Parameter::GuardCurl, &at),
        frizz: maps.scalar(Parameter::GuardFrizz, &at),
        thickness: maps.scalar(Parameter::GuardThickness, &at),
        seed,
    }
}

impl Strand {
    /// Point at `s` (0 root, 1 tip), world space, cm.
    pub fn point(&self, groom: &Groom, s: f32) -> Vec3 {
        let frequencies = [groom.curl_frequency, groom.frizz_frequency];
        let [curl, frizz] = curl_and_frizz(self.seed, self.length, frequencies, s)
            .map(|across| across.x * self.side + across.y * self.other);
        self.root
            + bezier(self.control, s)
            + self.pull * s * s
            + self.curl * s * curl
            + self.frizz * s * frizz
    }

    /// The tessellated strand, `groom.segments + 1` packed vertices (see [`vertex`]).
    pub fn vertices(&self, groom: &Groom) -> Vec<[f32; 4]> {
        (0..=groom.segments)
            .map(|k| {
                let s = k as f32 / groom.segments as f32;
                let radius = 0.5 * self.thickness * diameter(groom, s);
                vertex(self.point(groom, s), radius, groom.opacity * (-groom.tip_fade * s).exp())
            })
            .collect()
    }
}
