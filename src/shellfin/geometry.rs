//! The skin as shells and fins read it: corners with their place in the texture, and edges with both faces.

use crate::Skin;
use crate::layout::{FinEdge, FurCorner};
use crate::skin::NONE;
use glam::Vec2;
use std::collections::BTreeMap;

/// Three corners a triangle: vertex, place on the patch (cm), the skin's own uv.
pub fn corners(skin: &Skin, corner_uv: &[[Vec2; 3]]) -> Vec<FurCorner> {
    let own = |t: usize, k: usize| skin.corner_uv.as_ref().map_or(Vec2::ZERO, |uv| uv[t][k]);
    skin.triangles
        .iter()
        .zip(corner_uv)
        .enumerate()
        .flat_map(|(t, (triangle, uv))| {
            [0, 1, 2].map(|k| FurCorner {
                vertex: triangle[k],
                padding: 0,
                uv: uv[k].into(),
                skin_uv: own(t, k).into(),
            })
        })
        .collect()
}

/// Every edge once, with the third vertices of the faces on its two sides: the face in which it runs from a to b, then
/// the other, or [`NONE`] at a border. Of more than two faces at an edge the first two count.
// [Tariq2007]: four vertices an edge, as a line with adjacency
pub fn edges(skin: &Skin) -> Vec<FinEdge> {
    let mut found: BTreeMap<(u32, u32), FinEdge> = BTreeMap::new();
    for triangle in &skin.triangles {
        for k in 0..3 {
            let (a, b, opposite) = (triangle[k], triangle[(k + 1) % 3], triangle[(k + 2) % 3]);
            found
                .entry((a.min(b), a.max(b)))
                .and_modify(|edge| {
                    if edge.opposite[1] == NONE {
                        edge.opposite[1] = opposite;
                    }
                })
                .or_insert(FinEdge { a, b, opposite: [opposite, NONE] });
        }
    }
    found.into_values().collect()
}

/// The skin's own uv, scaled so that one unit is one centimetre on the average of the area; `None` without uv.
pub fn uv_in_cm(skin: &Skin) -> Option<Vec<[Vec2; 3]>> {
    let uv = skin.corner_uv.as_ref()?;
    let flat: f64 = uv.iter().map(|[a, b, c]| f64::from((*b - *a).perp_dot(*c - *a).abs()) * 0.5).sum();
    let scale = (skin.area() / flat.max(1e-12)).sqrt() as f32;
    Some(uv.iter().map(|corners| corners.map(|p| p * scale)).collect())
}

/// Mean length of the edges, cm.
pub fn mean_edge(skin: &Skin, edges: &[FinEdge]) -> f32 {
    let at = |v: u32| skin.positions[v as usize];
    let sum: f64 = edges.iter().map(|e| f64::from(at(e.a).distance(at(e.b)))).sum();
    (sum / edges.len().max(1) as f64) as f32
}
