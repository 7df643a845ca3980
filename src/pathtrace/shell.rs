//! The prism shell on the CPU: the one that the passes build on the GPU, in which hairs find their way up.

use crate::groom::PackedGroom;
use crate::layout::{Prism, ShellVertex};
use crate::mesh::topology;
use crate::prepare::{corner_uv, number_edges, skin_vertices, subdivide, vertex_uv};
use crate::reference::groom::Maps;
use crate::reference::shell::Shell;
use crate::reference::shell_prisms::heights;
use crate::{World, groom};
use glam::Vec3;

/// The shell of `world`, its groom packed as `packed`. The light lattice is not part of it: `light_reach` is 1.
pub fn shell(world: &World, packed: &PackedGroom) -> Shell {
    let skin = &world.skin;
    let mut vertices: Vec<ShellVertex> = skin_vertices(skin, packed.fur.height);
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
                padding: 0,
            }
        })
        .collect();
    Shell { vertices, prisms, corner_uv: corner_uv(skin), light_reach: 1.0 }
}
