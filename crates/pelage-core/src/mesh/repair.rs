//! From a soup of triangles to a skin: triangles that cannot carry fur are dropped, the rest is
//! welded, wound outwards and given normals.
//!
//! Geometry is computed in f64, so that it neither overflows nor underflows, whatever the file's
//! scale.

use super::{
    Mesh,
    topology::{Edge, neighbours, sorted_edges},
};
use crate::Skin;
use glam::{DVec3, Vec3};
use std::collections::{HashMap, HashSet};

/// A triangle counts as having no area if its height is at most this fraction of its longest side:
/// with f32 corners, its normal would be rounding noise.
const MIN_HEIGHT: f64 = 1e-7;

/// Makes `mesh` a skin. The second part lists what was repaired or could not be, each with its
/// count. The skin's notes hold the mesh's notes and that list.
pub(super) fn repair(mut mesh: Mesh) -> (Skin, Vec<String>) {
    let mut repairs = std::mem::take(&mut mesh.repairs);
    let mut report = |n: usize, what: &str| {
        if n > 0 {
            repairs.push(format!("{n} {what}"));
        }
    };
    // uv and colours that do not fit the mesh come from a caller, never from a file.
    if mesh.corner_uv.as_ref().is_some_and(|uv| uv.len() != mesh.triangles.len()) {
        report(1, "uv set dropped: its size is not that of the mesh");
        mesh.corner_uv = None;
    }
    if mesh.colors.len() != mesh.positions.len() {
        report(
            usize::from(!mesh.colors.is_empty()),
            "set of vertex colours dropped: its size is not that of the mesh",
        );
        mesh.colors = vec![Vec3::ONE; mesh.positions.len()];
    }

    let finite: Vec<bool> = mesh.positions.iter().map(|p| p.is_finite()).collect();
    let bad = keep(&mut mesh, |t, _| t.iter().all(|i| finite.get(*i as usize) == Some(&true)));
    report(bad, "triangles without three finite corners dropped");
    report(weld(&mut mesh), "vertices welded to others at the same position");
    report(keep(&mut mesh, |t, p| has_area(t.map(|i| p[i as usize]))), "zero-area triangles dropped");
    let mut seen = HashSet::with_capacity(mesh.triangles.len());
    let duplicates = keep(&mut mesh, |mut t, _| {
        t.sort_unstable();
        seen.insert(t)
    });
    report(duplicates, "duplicate triangles dropped");
    drop(seen);
    report(orient(&mut mesh), "triangles turned over for a consistent winding");
    report(drop_unused(&mut mesh), "unused vertices dropped");

    let topology = neighbours(&mesh.triangles);
    report(topology.non_manifold_edges, "non-manifold edges, treated as boundary");
    report(topology.inconsistent_edges, "edges with opposite winding, treated as boundary");
    report(topology.boundary_edges, "boundary edges: the mesh is open");
    let parts = components(&mesh);
    report(if parts > 1 { parts } else { 0 }, "separate parts");

    let normals = smoothed_normals(&mesh.positions, &mesh.triangles);
    let mut notes = mesh.notes;
    notes.extend(repairs.iter().cloned());
    let skin = Skin {
        positions: mesh.positions,
        normals,
        colors: mesh.colors,
        triangles: mesh.triangles,
        corner_uv: mesh.corner_uv,
        notes,
        ..Skin::default()
    };
    (skin, repairs)
}

/// Keeps the triangles that `wanted` accepts; returns how many were dropped.
fn keep(mesh: &mut Mesh, mut wanted: impl FnMut([u32; 3], &[Vec3]) -> bool) -> usize {
    let kept: Vec<bool> = mesh.triangles.iter().map(|t| wanted(*t, &mesh.positions)).collect();
    let filter = |i: &mut usize| {
        *i += 1;
        kept[*i - 1]
    };
    let mut at = 0;
    mesh.triangles.retain(|_| filter(&mut at));
    let mut at = 0;
    if let Some(uv) = &mut mesh.corner_uv {
        uv.retain(|_| filter(&mut at));
    }
    kept.iter().filter(|k| !**k).count()
}

/// Gives triangles with corners at exactly the same position the same vertex; returns how many used
/// vertices were joined to others. Colours of welded vertices are averaged.
///
/// Positions that are merely close stay separate: no distance is safe for every mesh (ears and
/// claws are thin).
fn weld(mesh: &mut Mesh) -> usize {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|i| used[*i as usize] = true);
    let mut first = HashMap::with_capacity(mesh.positions.len());
    let mut sums = vec![(Vec3::ZERO, 0.0_f32); mesh.positions.len()];
    let mut target: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let mut welded = 0;
    for i in (0..mesh.positions.len()).filter(|i| used[*i]) {
        // Adding zero turns -0 into 0, so that both have the same key.
        let key = (mesh.positions[i] + Vec3::ZERO).to_array().map(f32::to_bits);
        let to = *first.entry(key).or_insert(i as u32);
        welded += usize::from(to != i as u32);
        target[i] = to;
        let sum = &mut sums[to as usize];
        *sum = (sum.0 + mesh.colors[i], sum.1 + 1.0);
    }
    for (color, (sum, n)) in mesh.colors.iter_mut().zip(sums) {
        if n > 1.0 {
            *color = sum / n;
        }
    }
    mesh.triangles.iter_mut().flatten().for_each(|i| *i = target[*i as usize]);
    // Vertices that lose their triangles here count as welded, not as unused.
    if welded > 0 {
        drop_unused(mesh);
    }
    welded
}

fn has_area(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    (b - a).cross(c - a).length() > MIN_HEIGHT * longest
}

/// Removes vertices that no triangle uses; returns how many.
fn drop_unused(mesh: &mut Mesh) -> usize {
    let before = mesh.positions.len();
    let mut number = vec![u32::MAX; before];
    mesh.triangles.iter().flatten().for_each(|i| number[*i as usize] = 0);
    let mut next = 0;
    for (i, number) in number.iter_mut().enumerate().filter(|(_, number)| **number == 0) {
        mesh.positions[next] = mesh.positions[i];
        mesh.colors[next] = mesh.colors[i];
        *number = next as u32;
        next += 1;
    }
    mesh.positions.truncate(next);
    mesh.colors.truncate(next);
    mesh.triangles.iter_mut().flatten().for_each(|i| *i = number[*i as usize]);
    before - next
}

/// Winds each part of the mesh consistently: closed parts outwards (positive volume), open ones as
/// most of their triangles are wound. Returns how many triangles were turned over. One-sided
/// surfaces keep a seam of opposite winding.
fn orient(mesh: &mut Mesh) -> usize {
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
    let mut total = 0;
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
        let mut invert = 2 * flips > part.len();
        if closed {
            let volume = signed_volume(mesh, &part);
            // The volume of a sheet that is folded onto itself does not tell its outside.
            invert = if volume == 0.0 { invert } else { volume < 0.0 };
        }
        for &(t, flip) in part.iter().filter(|(_, flip)| *flip != invert) {
            debug_assert_ne!(flip, invert);
            mesh.triangles[t].swap(1, 2);
            if let Some(uv) = &mut mesh.corner_uv {
                uv[t].swap(1, 2);
            }
            total += 1;
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

/// Parts of the mesh that share no vertex.
fn components(mesh: &Mesh) -> usize {
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let mut parent: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let mut parts = parent.len();
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2])] {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            if a != b {
                parent[a.max(b) as usize] = a.min(b);
                parts -= 1;
            }
        }
    }
    parts
}

/// Unit normals, one per vertex: the sum of the triangle normals, each weighted by the triangle's
/// angle at the vertex (Thürmer and Wüthrich 1998). Where they cancel, the normal of the largest
/// triangle at the vertex; +y without any.
pub fn smoothed_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    let mut largest = vec![DVec3::ZERO; positions.len()];
    for t in triangles {
        let p = t.map(|i| positions[i as usize].as_dvec3());
        let cross = (p[1] - p[0]).cross(p[2] - p[0]);
        let Some(normal) = cross.try_normalize() else { continue };
        // [ThurmerWuthrich1998]
        for k in 0..3 {
            let i = t[k] as usize;
            let angle = (p[(k + 1) % 3] - p[k]).angle_between(p[(k + 2) % 3] - p[k]);
            sums[i] += normal * if angle.is_finite() { angle } else { 0.0 };
            if cross.length_squared() > largest[i].length_squared() {
                largest[i] = cross;
            }
        }
    }
    sums.iter()
        .zip(&largest)
        .map(|(sum, largest)| {
            // The angles' sum is of order 1: a length below 1e-4 means that directions cancel each
            // other.
            let sum = if sum.length_squared() > 1e-8 { *sum } else { *largest };
            sum.try_normalize().unwrap_or(DVec3::Y).as_vec3()
        })
        .collect()
}
