//! The skin, as the passes read it.

use crate::layout::ShellVertex;
use crate::parameters::pack_color;
use glam::{Vec2, Vec3};
use pelage_core::{Skin, World};

/// uv of the corners of all triangles, `[3 · triangle + corner]`; zero if the skin has no uv.
pub fn corner_uv(skin: &Skin) -> Vec<[f32; 2]> {
    match &skin.corner_uv {
        Some(uv) => uv.iter().flatten().map(|uv| uv.to_array()).collect(),
        None => vec![[0.0; 2]; 3 * skin.triangles.len()],
    }
}

/// uv of each vertex: that of one of its corners; zero if the skin has no uv.
pub fn vertex_uv(skin: &Skin) -> Vec<[f32; 2]> {
    let mut of_vertex = vec![[0.0; 2]; skin.positions.len()];
    if let Some(uv) = &skin.corner_uv {
        for (triangle, uv) in skin.triangles.iter().zip(uv) {
            for k in 0..3 {
                of_vertex[triangle[k] as usize] = uv[k].to_array();
            }
        }
    }
    of_vertex
}

/// The same surface with its vertices split where the uv of their corners differ, and the uv of
/// each vertex; `None` without uv.
pub fn split_at_seams(skin: &Skin) -> Option<(Skin, Vec<Vec2>)> {
    let corner_uv = skin.corner_uv.as_ref()?;
    let mut split = Skin { colored: skin.colored, ..Skin::default() };
    let mut uvs = Vec::new();
    let mut known = std::collections::HashMap::new();
    for (triangle, uv) in skin.triangles.iter().zip(corner_uv) {
        let corners = [0, 1, 2].map(|k| {
            let v = triangle[k] as usize;
            *known.entry((v, uv[k].to_array().map(f32::to_bits))).or_insert_with(|| {
                split.positions.push(skin.positions[v]);
                split.normals.push(skin.normals[v]);
                split.colors.push(skin.vertex_color(v).truncate());
                uvs.push(uv[k]);
                uvs.len() as u32 - 1
            })
        });
        split.triangles.push(corners);
    }
    split.corner_uv = skin.corner_uv.clone();
    Some((split, uvs))
}

/// The skin's vertices, with directions of extrusion for a shell `height` cm high; the heights are
/// left at 0.
pub fn skin_vertices(skin: &Skin, height: f32) -> Vec<ShellVertex> {
    let normals = shell_normals(skin, height);
    (0..skin.positions.len())
        .map(|i| ShellVertex {
            position: skin.positions[i].into(),
            height: 0.0,
            normal: normals[i].into(),
            color: pack_color(skin.vertex_color(i)),
        })
        .collect()
}

/// Level of subdivision and first subelement of each prism, and the total number of subelements.
///
/// Without a level in the scene, the longest edge is divided into parts of `underundercoat.cell`.
/// This does not depend on the camera, so that nothing pops.
// [Andersen2016] sec. 3 calls this dynamic resolution, without a criterion.
pub fn subdivide(skin: &Skin, world: &World, has_undercoat_layer: bool) -> (Vec<[u32; 2]>, u64) {
    let undercoat = &world.scene.undercoat;
    let layers = u64::from(undercoat.layers);
    let mut base = 0u64;
    let of_triangle = (0..skin.triangles.len())
        .map(|t| {
            let [a, b, c] = skin.corners(t);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            let wanted = (longest / undercoat.cell.max(1e-4)).max(1.0).log2().ceil() as u32;
            let d = undercoat.subdivision.unwrap_or(wanted.min(6));
            let first = base;
            if has_undercoat_layer {
                base += layers << (2 * d);
            }
            // Beyond 32 bits the volume is evaluated, and the index is only a label.
            [d, first as u32]
        })
        .collect();
    (of_triangle, base)
}

/// Directions in which a shell `height` cm high is extruded at the vertices, unit.
pub fn shell_normals(skin: &Skin, height: f32) -> Vec<Vec3> {
    extrusion_normals(skin, 0.7 * height)
}

/// The skin's normals, averaged over about `radius` cm, so that detail finer than the height of the
/// fur does not turn prisms over.
///
/// Repeated averaging over neighbours spreads with the square root of the number of rounds.
fn extrusion_normals(skin: &Skin, radius: f32) -> Vec<Vec3> {
    let mean_area = (skin.area() / skin.triangles.len().max(1) as f64) as f32;
    let edge = (mean_area * 2.309).sqrt().max(1e-6);
    let rounds = (2.0 * (radius / edge).powi(2)).round().clamp(0.0, 200.0) as u32;
    let mut normals = skin.normals.clone();
    for _ in 0..rounds {
        let mut sums = normals.clone();
        for triangle in &skin.triangles {
            let sum: Vec3 = triangle.iter().map(|v| normals[*v as usize]).sum();
            for v in triangle {
                sums[*v as usize] += sum;
            }
        }
        // On a thin ear the two sides would cancel: no normal may stray far from that of its own
        // surface.
        normals = (0..normals.len())
            .map(|i| match sums[i].try_normalize() {
                Some(n) if n.dot(skin.normals[i]) > 0.6 => n,
                _ => normals[i],
            })
            .collect();
    }
    normals
}

/// Indices of the edges opposite each corner, the same from both sides, and the number of edges.
pub fn number_edges(skin: &Skin) -> (Vec<[u32; 3]>, u32) {
    let mut known = std::collections::HashMap::with_capacity(2 * skin.triangles.len());
    let numbers = skin
        .triangles
        .iter()
        .map(|v| {
            [0, 1, 2].map(|k| {
                let (a, b) = (v[(k + 1) % 3], v[(k + 2) % 3]);
                let next = known.len() as u32;
                *known.entry((a.min(b), a.max(b))).or_insert(next)
            })
        })
        .collect();
    (numbers, known.len() as u32)
}
