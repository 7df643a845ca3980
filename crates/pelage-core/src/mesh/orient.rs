//! Winds the parts of a mesh consistently and outwards.

use super::Mesh;
use super::topology::{Edge, sorted_edges};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// What was turned over.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Turned {
    pub triangles: usize,
    /// Open parts that were turned as a whole, against the winding of most of their triangles.
    pub open_parts: usize,
}

/// Winds each part of the mesh consistently: closed parts outwards (positive volume), open ones by
/// [`inwardness`] where they enclose something, else as most of their triangles are wound.
/// One-sided surfaces keep a seam of opposite winding.
pub(super) fn orient(mesh: &mut Mesh) -> Turned {
    let count = mesh.triangles.len();
    // The neighbour, and whether both run along the common edge in the same direction.
    let mut beyond: Vec<[Option<(u32, bool)>; 3]> = vec![[None; 3]; count];
    for group in sorted_edges(&mesh.triangles).chunk_by(|a: &Edge, b: &Edge| a.key == b.key) {
        if let [a, b] = group {
            let same = a.reversed == b.reversed;
            beyond[a.triangle as usize][a.corner as usize] = Some((b.triangle, same));
            beyond[b.triangle as usize][b.corner as usize] = Some((a.triangle, same));
        }
    }
    let mut turned: Vec<Option<bool>> = vec![None; count];
    let mut part = Vec::new();
    let mut total = Turned::default();
    for start in 0..count {
        if turned[start].is_some() {
            continue;
        }
        turned[start] = Some(false);
        part.clear();
        part.push((start, false));
        let (mut at, mut closed) = (0, true);
        while let Some(&(t, flip)) = part.get(at) {
            at += 1;
            for side in beyond[t] {
                let Some((other, same)) = side else {
                    closed = false;
                    continue;
                };
                if turned[other as usize].is_none() {
                    turned[other as usize] = Some(flip != same);
                    part.push((other as usize, flip != same));
                }
            }
        }
        let flips = part.iter().filter(|(_, flip)| *flip).count();
        let most = 2 * flips > part.len();
        let invert = if closed {
            let volume = signed_volume(mesh, &part);
            // The volume of a sheet that is folded onto itself does not tell its outside.
            if volume == 0.0 { most } else { volume < 0.0 }
        } else {
            let inward = inwardness(mesh, &part);
            let invert = if inward.abs() < ENCLOSED { most } else { inward > 0.0 };
            total.open_parts += usize::from(invert != most);
            invert
        };
        for &(t, _) in part.iter().filter(|(_, flip)| *flip != invert) {
            mesh.triangles[t].swap(1, 2);
            if let Some(uv) = &mut mesh.corner_uv {
                uv[t].swap(1, 2);
            }
            total.triangles += 1;
        }
    }
    total
}

/// Signed volume within the triangles, with those marked `true` turned over.
fn signed_volume(mesh: &Mesh, part: &[(usize, bool)]) -> f64 {
    let Some(&(first, _)) = part.first() else { return 0.0 };
    let origin = mesh.positions[mesh.triangles[first][0] as usize].as_dvec3();
    let volume = |&(t, flip): &(usize, bool)| {
        let [a, b, c] = mesh.triangles[t].map(|i| mesh.positions[i as usize].as_dvec3() - origin);
        let v = a.dot(b.cross(c)) / 6.0;
        if flip { -v } else { v }
    };
    part.iter().map(volume).sum()
}

/// An open part whose inwardness is at least this, of at most 1, has an inside, as half of a sphere
/// does. Below it, the file's winding says which side is out.
const ENCLOSED: f64 = 0.4;

/// Triangles at which the winding number is taken, and the number of solid angles at most.
const SAMPLES: usize = 64;
const MAX_ANGLES: usize = 1 << 28;

/// How far an open part, with its triangles marked `true` turned over, is wound inwards: -1 for a
/// closed surface that faces outwards, 1 for one that faces inwards, 0 for a flat sheet.
///
/// It is the mean over the surface of the sum of the winding numbers on both sides of it, which for
/// a triangle is twice the part's solid angle there, as a fraction of the full one. The triangle
/// itself is seen edge-on and adds nothing.
// [Jacobson2013]
fn inwardness(mesh: &Mesh, part: &[(usize, bool)]) -> f64 {
    let corners = |&(t, flip): &(usize, bool)| {
        let [a, b, c] = mesh.triangles[t].map(|i| mesh.positions[i as usize].as_dvec3());
        if flip { [a, c, b] } else { [a, b, c] }
    };
    let samples = SAMPLES.min((MAX_ANGLES / part.len().max(1)).max(8)).min(part.len());
    let (sum, weight) = (0..samples)
        .into_par_iter()
        .map(|k| {
            let chosen = k * part.len() / samples;
            let [a, b, c] = corners(&part[chosen]);
            let (at, area) = ((a + b + c) / 3.0, (b - a).cross(c - a).length());
            let others = part.iter().enumerate().filter(|(i, _)| *i != chosen);
            let angle: f64 = others.map(|(_, t)| solid_angle(corners(t).map(|p| p - at))).sum();
            (area * angle / TAU, area)
        })
        .collect::<Vec<_>>()
        .into_iter()
        .fold((0.0, 0.0), |(sum, weight), (s, w)| (sum + s, weight + w));
    // Seen from inside, a surface that faces outwards has a positive solid angle.
    if weight > 0.0 { -sum / weight } else { 0.0 }
}

/// Signed solid angle of a triangle seen from the origin, positive if it faces away from it.
// [VanOosteromStrackee1983]
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(b.cross(c)).atan2(below)
}
