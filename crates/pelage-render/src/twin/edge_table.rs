//! Twin of `shaders/edge_table.wgsl`: neighbours over the edges, by an ordinary hash map.
// [Andersen2016] sec. 3.2

use pelage_core::mesh::topology::edge_key;
use pelage_core::skin::NONE;
use std::collections::HashMap;

/// For each triangle the neighbours over the edges opposite its corners, [`NONE`] at a boundary. An
/// edge counts as a boundary unless its directed key and the reversed key each have exactly one
/// owner.
pub fn neighbours(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let side = |t: &[u32; 3], k: usize| (t[(k + 1) % 3], t[(k + 2) % 3]);
    let mut owners: HashMap<u64, Vec<u32>> = HashMap::new();
    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = side(t, k);
            owners.entry(edge_key(a, b)).or_default().push(i as u32);
        }
    }
    let only_owner = |a: u32, b: u32| match owners.get(&edge_key(a, b)).map(Vec::as_slice) {
        Some([owner]) => Some(*owner),
        _ => None,
    };
    triangles
        .iter()
        .map(|t| {
            [0, 1, 2].map(|k| {
                let (a, b) = side(t, k);
                only_owner(a, b).and(only_owner(b, a)).unwrap_or(NONE)
            })
        })
        .collect()
}
