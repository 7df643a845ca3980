//! Twin of `shaders/guard_strands.wgsl`: guard hairs as cubic Bezier curves, tessellated.

use crate::layout::{Groom, Root};
use crate::parameters::{Maps, Parameter, skin_point};
use crate::random::{hash2, random};
use crate::shell::Shell;
use crate::strands::vertex;
use glam::{IVec3, Vec3};
use std::f32::consts::TAU;

/// A strand before tessellation. Vectors are relative to the root, cm.
#[derive(Debug, Clone, Copy)]
pub struct Strand {
    /// Root on the skin, world, cm.
    pub root: Vec3,
    /// Normal of the skin.
    pub normal: Vec3,
    /// Length, cm.
    pub length: f32,
    /// Inner control points and the tip.
    pub control: [Vec3; 3],
    pull: Vec3,
    side: Vec3,
    other: Vec3,
    curl: f32,
    frizz: f32,
    thickness: f32,
    seed: u32,
}

/// Vector from `p` to the nearest clump centre: one centre in each cell of a jittered grid.
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
    let [root, widest, tip] = groom.diameter;
    if s < groom.widest {
        let x = s / groom.widest.max(1e-3);
        return root + (widest - root) * (x * x * (3.0 - 2.0 * x));
    }
    let x = (s - groom.widest) / (1.0 - groom.widest).max(1e-3);
    widest + (tip - widest) * x * x
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
    // Rayleigh distributed: the lean has a normal distribution along both axes.
    let spread = groom.spread * (-2.0 * (1.0 - random(seed, 1)).ln()).sqrt();
    let phi = TAU * random(seed, 2);
    let lean =
        combed * maps.scalar(Parameter::GuardComb, &at) + spread * (phi.cos() * side + phi.sin() * other);
    let fall = Vec3::new(0.0, -groom.gravity, 0.0);
    let directions = [n + 0.5 * lean, n + 0.9 * lean + 0.35 * fall, n + 1.25 * lean + fall];
    let [e1, e2, e3] = directions.map(|e| e.normalize() * (length / 3.0));
    let above = |p: Vec3| p - n * p.dot(n).min(0.0);
    let p2 = e1 + e2;
    // The third leg starts from the second before that is raised.
    let control = [e1, above(p2), above(p2 + e3)];
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
    /// Point at `s` (0 root, 1 tip), world, cm.
    pub fn point(&self, groom: &Groom, s: f32) -> Vec3 {
        let r = 1.0 - s;
        let [p1, p2, p3] = self.control;
        let bezier = 3.0 * r * r * s * p1 + 3.0 * r * s * s * p2 + s * s * s * p3;
        let phase = TAU * random(self.seed, 3);
        let turn = phase + TAU * groom.curl_frequency * self.length * s;
        let curl = (turn.cos() - phase.cos()) * self.side + (turn.sin() - phase.sin()) * self.other;
        let wave = [(4, 1.0), (5, 1.37)]
            .map(|(k, f)| TAU * random(self.seed, k) + TAU * groom.frizz_frequency * self.length * s * f);
        let frizz = wave[0].sin() * self.side + wave[1].sin() * self.other;
        self.root + bezier + self.pull * s * s + self.curl * s * curl + self.frizz * s * frizz
    }

    /// Packed vertices.
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
