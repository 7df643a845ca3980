//! A standing marten-like animal: an implicit surface, polygonised and relaxed.

use super::UV_CM;
use crate::mesh::{Mesh, smoothed_normals};
use glam::{IVec3, Vec2, Vec3};
use std::collections::HashMap;

/// A limb: the surface at the radii `from.1` to `to.1` around the segment from `from.0` to `to.0`;
/// `blend` is the width over which it blends into the others. All cm; +x is forwards, y up from the
/// ground. Mirrored at z = 0.
struct Limb {
    from: ([f32; 3], f32),
    to: ([f32; 3], f32),
    blend: f32,
}

const fn limb(from: [f32; 3], r: f32, to: [f32; 3], s: f32, blend: f32) -> Limb {
    Limb { from: (from, r), to: (to, s), blend }
}

const LIMBS: [Limb; 21] = [
    // Trunk: hips, loin, chest.
    limb([-3.9, 4.45, 0.0], 1.75, [-1.0, 4.75, 0.0], 1.6, 1.0),
    limb([-1.0, 4.75, 0.0], 1.6, [2.4, 4.35, 0.0], 1.75, 0.5),
    // Neck and head.
    limb([2.7, 4.7, 0.0], 1.45, [5.0, 6.3, 0.0], 1.15, 1.2),
    limb([5.15, 6.55, 0.0], 1.3, [5.9, 6.5, 0.0], 1.15, 0.6),
    limb([5.9, 6.4, 0.35], 0.8, [7.2, 6.1, 0.15], 0.5, 0.4),
    limb([7.2, 6.1, 0.0], 0.5, [7.65, 6.1, 0.0], 0.36, 0.3),
    limb([5.8, 6.0, 0.4], 0.75, [6.7, 5.85, 0.2], 0.5, 0.5),
    // Ear.
    limb([4.85, 7.35, 0.75], 0.55, [4.85, 7.95, 1.0], 0.45, 0.35),
    limb([4.85, 7.5, 0.9], 0.5, [4.75, 7.6, 1.4], 0.38, 0.3),
    // Foreleg: shoulder, upper arm, forearm, paw.
    limb([2.5, 4.3, 0.95], 1.05, [2.1, 3.2, 1.2], 0.85, 0.6),
    limb([2.1, 3.2, 1.2], 0.8, [2.6, 1.6, 1.25], 0.58, 0.4),
    limb([2.6, 1.6, 1.25], 0.58, [2.6, 0.6, 1.25], 0.52, 0.3),
    limb([2.6, 0.5, 1.25], 0.5, [3.25, 0.42, 1.3], 0.42, 0.3),
    // Hind leg: thigh, shank, foot, paw.
    limb([-3.9, 4.1, 0.9], 1.35, [-3.3, 2.9, 1.25], 1.0, 0.7),
    limb([-3.3, 2.9, 1.25], 0.9, [-4.3, 1.9, 1.3], 0.62, 0.4),
    limb([-4.3, 1.9, 1.3], 0.6, [-4.05, 0.6, 1.3], 0.5, 0.3),
    limb([-4.05, 0.5, 1.3], 0.5, [-3.2, 0.42, 1.35], 0.44, 0.3),
    // Tail.
    limb([-4.9, 4.8, 0.0], 1.1, [-6.8, 4.5, 0.0], 0.82, 0.9),
    limb([-6.8, 4.5, 0.0], 0.82, [-9.0, 3.6, 0.0], 0.86, 0.3),
    limb([-9.0, 3.6, 0.0], 0.86, [-11.0, 3.0, 0.0], 0.74, 0.3),
    limb([-11.0, 3.0, 0.0], 0.74, [-12.0, 2.9, 0.0], 0.4, 0.2),
];

/// Approximate signed distance to the surface, cm, negative inside: a smooth union of the limbs.
fn field(p: Vec3) -> f32 {
    let p = Vec3::new(p.x, p.y, p.z.abs());
    LIMBS.iter().fold(f32::MAX, |d, limb| {
        let (a, b) = (Vec3::from(limb.from.0), Vec3::from(limb.to.0));
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        let radius = limb.from.1 + t * (limb.to.1 - limb.from.1);
        smooth_min(d, p.distance(a.lerp(b, t)) - radius, limb.blend)
    })
}

/// Minimum of a and b, rounded where they differ by less than k (the usual quadratic blend of
/// distance fields).
fn smooth_min(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k / 4.0
}

/// Gradient of the field by central differences.
fn gradient(p: Vec3) -> Vec3 {
    const H: f32 = 1e-2;
    let slope = |axis: Vec3| (field(p + H * axis) - field(p - H * axis)) / (2.0 * H);
    Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z))
}

/// Edge of the sampling lattice, cm.
const CELL: f32 = 0.32;
/// Length of the finished body from nose to tail, cm.
const LENGTH: f32 = 20.0;
/// Rounds of relaxation.
const ROUNDS: usize = 24;

/// The critter: closed, one part, about 20 cm long, feet down, nose towards +x.
pub(super) fn critter() -> Mesh {
    let (mut positions, quads) = surface_net();
    // Each quad is cut along its shorter diagonal.
    let mut triangles = Vec::with_capacity(2 * quads.len());
    for [a, b, c, d] in quads {
        let [pa, pb, pc, pd] = [a, b, c, d].map(|i| positions[i as usize]);
        let halves =
            if pa.distance(pc) <= pb.distance(pd) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
        triangles.extend(halves);
    }
    for _ in 0..ROUNDS {
        even_out(&mut positions, &triangles);
    }
    let mesh = super::centered(Mesh { positions, triangles, ..Mesh::default() });
    scaled_with_uv(mesh)
}

/// Relaxation: moves each vertex along the surface towards the area-weighted centre of the
/// triangles around it, so that small ones grow, then back onto the surface.
fn even_out(positions: &mut [Vec3], triangles: &[[u32; 3]]) {
    let normals = smoothed_normals(positions, triangles);
    let mut sums = vec![(Vec3::ZERO, 0.0_f32); positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        let area = (b - a).cross(c - a).length();
        for i in t {
            let sum = &mut sums[*i as usize];
            *sum = (sum.0 + area / 3.0 * (a + b + c), sum.1 + area);
        }
    }
    for (i, p) in positions.iter_mut().enumerate() {
        let pull = sums[i].0 / sums[i].1.max(f32::MIN_POSITIVE) - *p;
        *p += 0.6 * (pull - normals[i] * pull.dot(normals[i]));
        for _ in 0..2 {
            let slope = gradient(*p);
            *p -= slope * (field(*p) / slope.length_squared().max(0.25));
        }
    }
}

/// The surface field = 0 as quads, counter-clockwise from outside: one vertex in each lattice cell
/// that the surface passes, one quad around each lattice edge that it crosses (surface nets, Gibson
/// 1998).
// [Gibson1998]
fn surface_net() -> (Vec<Vec3>, Vec<[u32; 4]>) {
    // The lattice is symmetric to the plane z = 0.
    let (low, size) = (Vec3::new(-13.2, -0.6, -3.2), IVec3::new(68, 30, 20));
    let at = |c: IVec3| low + CELL * c.as_vec3();
    let index = |c: IVec3| ((c.z * (size.y + 1) + c.y) * (size.x + 1) + c.x) as usize;
    let lattice = |high: IVec3| {
        let row = move |z: i32, y: i32| (0..high.x).map(move |x| IVec3::new(x, y, z));
        (0..high.z).flat_map(move |z| (0..high.y).flat_map(move |y| row(z, y)))
    };
    let values: Vec<f32> = lattice(size + 1).map(|c| field(at(c))).collect();

    let axes = [IVec3::X, IVec3::Y, IVec3::Z];
    let mut positions = Vec::new();
    let mut vertex = HashMap::new();
    for cell in lattice(size) {
        let (mut sum, mut crossings) = (Vec3::ZERO, 0.0);
        for axis in 0..3 {
            let (u, v) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
            for start in [cell, cell + u, cell + v, cell + u + v] {
                let (a, b) = (values[index(start)], values[index(start + axes[axis])]);
                if (a < 0.0) != (b < 0.0) {
                    sum += at(start) + axes[axis].as_vec3() * (CELL * a / (a - b));
                    crossings += 1.0;
                }
            }
        }
        if crossings > 0.0 {
            vertex.insert(cell, positions.len() as u32);
            positions.push(sum / crossings);
        }
    }

    let mut quads = Vec::new();
    for start in lattice(size) {
        for axis in 0..3 {
            let inside = values[index(start)] < 0.0;
            if inside == (values[index(start + axes[axis])] < 0.0) {
                continue;
            }
            let (u, v) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
            let cells = [start, start - u, start - u - v, start - v].map(|c| vertex.get(&c).copied());
            let [Some(a), Some(b), Some(c), Some(d)] = cells else { continue };
            // u x v is the axis: counter-clockwise seen from its end, which is outside where the
            // start is inside.
            quads.push(if inside { [a, b, c, d] } else { [a, d, c, b] });
        }
    }
    (positions, quads)
}

/// Scales to `LENGTH` and gives each triangle the uv of a box: its position seen along the axis it
/// faces most.
fn scaled_with_uv(mut mesh: Mesh) -> Mesh {
    let half = mesh.positions.iter().map(|p| p.x).fold(f32::MIN, f32::max);
    mesh.positions.iter_mut().for_each(|p| *p *= LENGTH / (2.0 * half));
    let flat = |t: &[u32; 3]| {
        let p = t.map(|i| mesh.positions[i as usize]);
        let n = (p[1] - p[0]).cross(p[2] - p[0]);
        let size = n.abs();
        p.map(|p| {
            let uv = if size.z >= size.x && size.z >= size.y {
                Vec2::new(p.x * n.z.signum(), p.y)
            } else if size.x >= size.y {
                Vec2::new(-p.z * n.x.signum(), p.y)
            } else {
                Vec2::new(p.x, -p.z * n.y.signum())
            };
            uv / UV_CM
        })
    };
    mesh.corner_uv = Some(mesh.triangles.iter().map(flat).collect());
    mesh
}
