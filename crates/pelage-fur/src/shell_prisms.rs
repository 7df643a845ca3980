//! Twin of `shaders/shell_prisms.wgsl`: heights of the shell above the vertices of the skin, and
//! the complete shell.

use crate::groom::{self, PackedGroom};
use crate::layout::{Prism, ShellVertex};
use crate::parameters::{Maps, MeshPlace, Parameter, SkinPoint, pack_color, unpack_color};
use crate::shell::Shell;
use crate::surface::{corner_uv, number_edges, skin_vertices, subdivide, vertex_uv};
use glam::{Vec2, Vec3};
use pelage_core::mesh::topology;
use pelage_core::{Skin, World};

/// Rounds of the slope limit; each lets a lowered vertex lower those one edge further away.
pub const SPREAD_ROUNDS: usize = 24;

/// Height that the groom asks for over vertex `v`, cm. Vertex colours are rounded to eight bits per
/// channel, as on the GPU.
fn wanted_height(skin: &Skin, normals: &[Vec3], maps: &Maps<'_>, vertex_uv: &[[f32; 2]], v: usize) -> f32 {
    let at = SkinPoint {
        position: skin.positions[v],
        normal: normals[v],
        uv: Vec2::from(vertex_uv[v]),
        color: unpack_color(pack_color(skin.vertex_color(v))),
        place: MeshPlace::Vertex(v as u32),
    };
    maps.scalar(Parameter::UndercoatHeight, &at).max(0.0)
}

/// Trial heights for a prism that would turn over; the last one is accepted unchecked.
const FOLD_STEPS: u32 = 16;

/// Largest slope of the shell's top relative to the skin.
const STEEPEST: f32 = 0.8;

/// Heights of the shell over the vertices, cm, extruded along `normals`. They are the wanted
/// heights, lowered where a prism's top would keep less than a fifth of its triangle's area, and
/// around such places so that the top is nowhere too steep. A prism alone lowers its vertices to no
/// less than a twentieth.
pub fn heights(skin: &Skin, normals: &[Vec3], maps: &Maps<'_>, vertex_uv: &[[f32; 2]]) -> Vec<f32> {
    lowered(skin, normals, &wanted_heights(skin, normals, maps, vertex_uv))
}

/// Heights that the groom asks for over the vertices, cm.
pub fn wanted_heights(skin: &Skin, normals: &[Vec3], maps: &Maps<'_>, vertex_uv: &[[f32; 2]]) -> Vec<f32> {
    (0..skin.positions.len()).map(|v| wanted_height(skin, normals, maps, vertex_uv, v)).collect()
}

/// [`heights`] for given `wanted` heights, cm.
pub fn lowered(skin: &Skin, normals: &[Vec3], wanted: &[f32]) -> Vec<f32> {
    let mut heights = wanted.to_vec();
    for triangle in &skin.triangles {
        let mut part = 1.0;
        for _ in 1..FOLD_STEPS {
            if part_of_area(skin, normals, triangle, wanted, part) > 0.2 {
                break;
            }
            part *= 0.82;
        }
        for v in triangle.map(|v| v as usize) {
            heights[v] = heights[v].min(part * wanted[v]);
        }
    }
    for _ in 0..SPREAD_ROUNDS {
        let before = heights.clone();
        for t in &skin.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])].map(|(a, b)| (a as usize, b as usize)) {
                let rise = STEEPEST * skin.positions[a].distance(skin.positions[b]);
                heights[a] = heights[a].min(before[b] + rise);
                heights[b] = heights[b].min(before[a] + rise);
            }
        }
    }
    heights
}

/// Signed area of a triangle extruded by `part` of the heights, relative to its own area; negative
/// if it has turned over.
pub fn part_of_area(skin: &Skin, normals: &[Vec3], triangle: &[u32; 3], heights: &[f32], part: f32) -> f32 {
    let p = triangle.map(|v| skin.positions[v as usize]);
    let q = triangle.map(|v| skin.positions[v as usize] + part * heights[v as usize] * normals[v as usize]);
    let n = (p[1] - p[0]).cross(p[2] - p[0]);
    (q[1] - q[0]).cross(q[2] - q[0]).dot(n) / n.dot(n)
}

/// The shell of `world` with its packed groom. It has no optical-depth lattice: `light_reach` is 1.
pub fn shell_of(world: &World, packed: &PackedGroom) -> Shell {
    let skin = &world.skin;
    let mut vertices: Vec<ShellVertex> = skin_vertices(skin, packed.undercoat.height);
    let normals: Vec<Vec3> = vertices.iter().map(|v| v.normal.into()).collect();
    let maps = Maps { groom: &packed.groom, texels: &packed.texels };
    for (vertex, height) in vertices.iter_mut().zip(heights(skin, &normals, &maps, &vertex_uv(skin))) {
        vertex.height = height;
    }
    let neighbours = topology::neighbours(&skin.triangles).neighbours;
    let (subdivisions, _) = subdivide(skin, world, groom::has_undercoat(&world.scene));
    let (edges, _) = number_edges(skin);
    let prisms = (0..skin.triangles.len())
        .map(|t| {
            let [subdivision, cell_base] = subdivisions[t];
            Prism {
                vertices: skin.triangles[t],
                cell_base,
                neighbours: neighbours[t],
                subdivision,
                edges: edges[t],
                object: 0,
            }
        })
        .collect();
    Shell { vertices, prisms, corner_uv: corner_uv(skin), light_reach: 1.0 }
}
