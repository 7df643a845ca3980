//! Triangles that cover what others cover already: the same corners again, or the same four corners
//! cut along the other diagonal.

use super::topology::{Edge, sorted_edges};
use glam::{DVec3, Vec3};
use std::collections::{HashMap, HashSet};

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
    let sides: HashMap<u64, u32> = edges
        .chunk_by(|a, b| a.key == b.key)
        .filter(|group| group.len() > 2)
        .map(|group| (group[0].key, group.len() as u32))
        .collect();
    // Two triangles on a common edge make a quad. It is there twice if another pair has the same
    // corners and the other diagonal as its edge.
    let mut quads: HashMap<[u32; 4], (u64, [u32; 2])> = HashMap::new();
    for group in edges.chunk_by(|a: &Edge, b: &Edge| a.key == b.key).filter(|g| (2..=8).contains(&g.len())) {
        for (i, a) in group.iter().enumerate() {
            for b in &group[i + 1..] {
                let pair = [kept[a.triangle as usize], kept[b.triangle as usize]];
                let far = |edge: &Edge, t: u32| triangles[t as usize][edge.corner as usize];
                let (c, d) = (far(a, pair[0]), far(b, pair[1]));
                let (p, q) = ((a.key >> 32) as u32, a.key as u32);
                let outer = [(p, c), (c, q), (q, d), (d, p)];
                let doubled = outer.iter().any(|(v, w)| sides.contains_key(&edge_of(*v, *w)));
                if !doubled && !flat([p, q, c, d].map(|v| positions[v as usize])) {
                    // Two triangles of a tetrahedron, say.
                    continue;
                }
                let mut key = [p, q, c, d];
                key.sort_unstable();
                match quads.get(&key) {
                    None => {
                        quads.insert(key, (a.key, pair));
                    }
                    Some((other, first)) if *other != a.key => {
                        let free = |pair: &[u32; 2]| pair.iter().all(|t| !repeated[*t as usize]);
                        if free(first) && free(&pair) {
                            let later = if first.iter().min() > pair.iter().min() { *first } else { pair };
                            later.iter().for_each(|t| repeated[*t as usize] = true);
                        }
                    }
                    Some(_) => {}
                }
            }
        }
    }
    repeated
}

fn edge_of(a: u32, b: u32) -> u64 {
    super::topology::edge_key(a.min(b), a.max(b))
}

/// Whether four points lie in a plane, up to a thousandth of their extent.
fn flat(corners: [Vec3; 4]) -> bool {
    let [a, b, c, d] = corners.map(|p: Vec3| p.as_dvec3());
    let (u, v, w): (DVec3, DVec3, DVec3) = (b - a, c - a, d - a);
    let longest = u.length_squared().max(v.length_squared()).max(w.length_squared()).sqrt();
    u.dot(v.cross(w)).abs() <= 1e-3 * longest.powi(3)
}
