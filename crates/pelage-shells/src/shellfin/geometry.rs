//! The skin, as shells and fins read it: corners with texture coordinates, and edges with both
//! adjacent faces.

use crate::lapped::Lapped;
use glam::Vec2;
use pelage_core::Skin;
use pelage_core::skin::NONE;
use pelage_fur::layout::{FinEdge, FurCorner};
use std::collections::BTreeMap;

/// The three corners of each triangle: vertex, place on the patch (`corner_uv`, cm) and the skin's
/// own uv.
pub fn corners(skin: &Skin, corner_uv: &[[Vec2; 3]]) -> Vec<FurCorner> {
    corner_uv.iter().enumerate().flat_map(|(t, uv)| corners_of(skin, t, uv, NONE)).collect()
}

/// Overlapping patches, as the shells draw them.
#[derive(Debug, Clone, Default)]
pub struct Overlapping {
    /// Corners in the order of pasting: those of a triangle once for each patch that touches it.
    pub corners: Vec<FurCorner>,
    /// The outlines of all patches, one after the other, cm, relative to the origin of the patch's
    /// uv.
    pub outlines: Vec<Vec2>,
    /// Points of each outline.
    pub points: u32,
}

impl Overlapping {
    /// The overlapping patches of a skin.
    pub fn new(skin: &Skin, lapped: &Lapped) -> Self {
        let corners = (0_u32..).zip(&lapped.patches).flat_map(|(number, patch)| {
            let faces = patch.faces.iter().zip(&patch.corner_uv);
            faces.flat_map(move |(t, uv)| corners_of(skin, *t as usize, uv, number))
        });
        let corners = corners.collect();
        let points = lapped.patches.first().map_or(0, |patch| patch.outline.len() as u32);
        let outlines = lapped.patches.iter().flat_map(|patch| patch.outline.iter().copied()).collect();
        Self { corners, outlines, points }
    }
}

fn corners_of(skin: &Skin, t: usize, uv: &[Vec2; 3], patch: u32) -> [FurCorner; 3] {
    let own = |k: usize| skin.corner_uv.as_ref().map_or(Vec2::ZERO, |uv| uv[t][k]);
    [0, 1, 2].map(|k| FurCorner {
        vertex: skin.triangles[t][k],
        patch_index: patch,
        uv: uv[k].into(),
        skin_uv: own(k).into(),
    })
}

/// Each edge once, with the third vertices of its two faces: first of the face in which it runs
/// from a to b, then of the other face, or [`NONE`] at a border. Of more than two faces on an edge,
/// the first two are used.
// [Tariq2007]: four vertices per edge, as a line with adjacency
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

/// Area of the skin in its own uv; `None` without uv.
pub fn uv_area(skin: &Skin) -> Option<f64> {
    let uv = skin.corner_uv.as_ref()?;
    Some(uv.iter().map(|[a, b, c]| f64::from((*b - *a).perp_dot(*c - *a).abs()) * 0.5).sum())
}

/// The skin's own uv, scaled so that one unit is one centimetre on average over the area; `None`
/// without uv.
pub fn uv_in_cm(skin: &Skin) -> Option<Vec<[Vec2; 3]>> {
    let uv = skin.corner_uv.as_ref()?;
    let scale = (skin.area() / uv_area(skin)?.max(1e-12)).sqrt() as f32;
    Some(uv.iter().map(|corners| corners.map(|p| p * scale)).collect())
}

/// Lengths of the edges, cm.
pub fn lengths(skin: &Skin, edges: &[FinEdge]) -> impl ExactSizeIterator<Item = f32> {
    let at = |v: u32| skin.positions[v as usize];
    edges.iter().map(move |e| at(e.a).distance(at(e.b)))
}
