//! Triangles that cover what others cover already: the same corners again, or the same four corners
//! cut along the other diagonal.

use super::topology::{Edge, sorted_edges};
use glam::{DVec3, Vec3};
use std::collections::HashSet;

/// For each of `triangles`, which must have three different corners and welded positions: whether
/// an earlier one, in either winding, or an earlier pair covers the same.
pub(super) fn repeated(triangles: &[[u32; 3]], positions: &[Vec3]) -> Vec<bool> {
    let mut seen = HashSet::with_capacity(triangles.len());
    let mut repeated: Vec<bool> = triangles
        .iter()
        .map(|t| {
            let mut key = *t;
            key.sort_unstable();
            !seen.insert(key)
        })
        .collect();
    drop(seen);
    let kept: Vec<u32> = (0..triangles.len() as u32).filter(|t| !repeated[*t as usize]).collect();
    let edges = sorted_edges(&kept.iter().map(|t| triangles[*t as usize]).collect::<Vec<_>>());
    let crowded: HashSet<u64> = edges
        .chunk_by(|a, b| a.key == b.key)
        .filter(|group| group.len() > 2)
        .map(|group| group[0].key)
        .collect();
    // Two triangles on both sides of a common edge make a quad. It is there twice if two others
    // make it on both sides of its other diagonal.
    let mut quads: Vec<Quad> = Vec::new();
    for group in edges.chunk_by(|a: &Edge, b: &Edge| a.key == b.key).filter(|g| (2..=8).contains(&g.len())) {
        for (i, a) in group.iter().enumerate() {
            for b in &group[i + 1..] {
                let pair = [kept[a.triangle as usize], kept[b.triangle as usize]];
                let far = |edge: &Edge, t: u32| triangles[t as usize][edge.corner as usize];
                let (c, d) = (far(a, pair[0]), far(b, pair[1]));
                let (p, q) = ((a.key >> 32) as u32, a.key as u32);
                let outer = [(p, c), (c, q), (q, d), (d, p)];
                let doubled = outer.iter().any(|(v, w)| crowded.contains(&edge_of(*v, *w)));
                let at = [p, q, c, d].map(|v| positions[v as usize].as_dvec3());
                if c != d && on_both_sides(at) && (doubled || flat(at)) {
                    let mut corners = [p, q, c, d];
                    corners.sort_unstable();
                    quads.push(Quad { corners, diagonal: a.key, other: edge_of(c, d), pair });
                }
            }
        }
    }
    quads.sort_unstable_by_key(|quad| (quad.corners, quad.pair));
    for group in quads.chunk_by(|a, b| a.corners == b.corners) {
        for (i, a) in group.iter().enumerate() {
            for b in group[i + 1..].iter().filter(|b| b.diagonal == a.other) {
                let all_there = [a.pair, b.pair].as_flattened().iter().all(|t| !repeated[*t as usize]);
                if all_there {
                    let later = if a.pair.iter().min() > b.pair.iter().min() { a.pair } else { b.pair };
                    later.iter().for_each(|t| repeated[*t as usize] = true);
                }
            }
        }
    }
    repeated
}

/// Two triangles on both sides of a common edge.
struct Quad {
    /// Sorted.
    corners: [u32; 4],
    /// The common edge.
    diagonal: u64,
    /// The edge between the corners that are not common.
    other: u64,
    pair: [u32; 2],
}

fn edge_of(a: u32, b: u32) -> u64 {
    super::topology::edge_key(a.min(b), a.max(b))
}

/// Whether c and d lie on different sides of the edge from p to q, seen along the quad's normal.
fn on_both_sides([p, q, c, d]: [DVec3; 4]) -> bool {
    let edge = q - p;
    let across = |v: DVec3| (v - p) - edge * ((v - p).dot(edge) / edge.length_squared());
    across(c).dot(across(d)) < 0.0
}

/// Whether four points lie in a plane, up to a thousandth of their extent.
fn flat([a, b, c, d]: [DVec3; 4]) -> bool {
    let (u, v, w) = (b - a, c - a, d - a);
    let longest = u.length_squared().max(v.length_squared()).max(w.length_squared()).sqrt();
    u.dot(v.cross(w)).abs() <= 1e-3 * longest.powi(3)
}
