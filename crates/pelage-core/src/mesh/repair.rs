//! From a soup of triangles to a skin: triangles that cannot carry fur are dropped, the rest is
//! welded, wound outwards and given normals.
//!
//! Geometry is computed in f64, so that it neither overflows nor underflows, whatever the file's
//! scale.

use super::{Mesh, duplicates, orient, topology::neighbours};
use crate::Skin;
use crate::film::tonemap::srgb_decode;
use crate::skin::Section;
use glam::{DVec3, Vec3, Vec4};
use std::collections::HashMap;

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
        mesh.colors = Vec::new();
    }
    let colored = !mesh.colors.is_empty();
    mesh.colors.resize(mesh.positions.len(), Vec3::ONE);
    if mesh.srgb {
        mesh.colors.iter_mut().for_each(|c| *c = c.map(srgb_decode));
    }
    if mesh.alphas.len() != mesh.positions.len() {
        mesh.alphas.clear();
    }
    let sections = mesh.sections.len() as u32;
    if mesh.section_of.len() != mesh.triangles.len() || mesh.section_of.iter().any(|s| *s >= sections) {
        mesh.sections = vec![Section::default()];
        mesh.section_of = vec![0; mesh.triangles.len()];
    }

    let finite: Vec<bool> = mesh.positions.iter().map(|p| p.is_finite()).collect();
    let bad = keep(&mut mesh, |t, _| t.iter().all(|i| finite.get(*i as usize) == Some(&true)));
    report(bad, "triangles without three finite corners dropped");
    report(weld(&mut mesh), "vertices welded to others at the same position");
    report(keep(&mut mesh, |t, p| has_area(t.map(|i| p[i as usize]))), "zero-area triangles dropped");
    let repeated = duplicates::repeated(&mesh.triangles, &mesh.positions);
    let mut at = 0;
    let duplicates = keep(&mut mesh, |_, _| {
        at += 1;
        !repeated[at - 1]
    });
    report(duplicates, "duplicate triangles dropped");
    let turned = orient::orient(&mut mesh);
    report(turned.triangles, "triangles turned over for a consistent winding");
    report(turned.open_parts, "open parts turned outwards, because most of their surface faced inwards");
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
        colored,
        alphas: mesh.alphas,
        sections: mesh.sections,
        section_of: mesh.section_of,
        notes,
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
    mesh.section_of.retain(|_| filter(&mut at));
    let mut at = 0;
    if let Some(uv) = &mut mesh.corner_uv {
        uv.retain(|_| filter(&mut at));
    }
    kept.iter().filter(|k| !**k).count()
}

/// Gives triangles with corners at exactly the same position the same vertex; returns how many used
/// vertices were joined to others. Colours and alphas of welded vertices are
/// averaged.
///
/// Positions that are merely close stay separate: no distance is safe for every mesh (ears and
/// claws are thin).
fn weld(mesh: &mut Mesh) -> usize {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|i| used[*i as usize] = true);
    let mut first = HashMap::with_capacity(mesh.positions.len());
    let mut sums = vec![(Vec4::ZERO, 0.0_f32); mesh.positions.len()];
    let mut target: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let mut welded = 0;
    for i in (0..mesh.positions.len()).filter(|i| used[*i]) {
        // Adding zero turns -0 into 0, so that both have the same key.
        let key = (mesh.positions[i] + Vec3::ZERO).to_array().map(f32::to_bits);
        let to = *first.entry(key).or_insert(i as u32);
        welded += usize::from(to != i as u32);
        target[i] = to;
        let sum = &mut sums[to as usize];
        let alpha = mesh.alphas.get(i).copied().unwrap_or(1.0);
        *sum = (sum.0 + mesh.colors[i].extend(alpha), sum.1 + 1.0);
    }
    for (i, (sum, n)) in sums.into_iter().enumerate().filter(|(_, (_, n))| *n > 1.0) {
        mesh.colors[i] = sum.truncate() / n;
        if let Some(alpha) = mesh.alphas.get_mut(i) {
            *alpha = sum.w / n;
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
        if !mesh.alphas.is_empty() {
            mesh.alphas[next] = mesh.alphas[i];
        }
        *number = next as u32;
        next += 1;
    }
    mesh.positions.truncate(next);
    mesh.colors.truncate(next);
    mesh.alphas.truncate(next);
    mesh.triangles.iter_mut().flatten().for_each(|i| *i = number[*i as usize]);
    before - next
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
