//! Objects on the GPU: their triangles stand behind those of the skin.

use super::Prepared;
use super::fur_grid::FurCells;
use crate::passes::objects::Objects;
use bytemuck::Zeroable;
use pelage_core::scene::FurLayers;
use pelage_core::{Result, Skin, World};
use pelage_fur::groom::PackedGroom;
use pelage_fur::layout::{ObjectMaterials, Prism, ShellVertex};
use pelage_fur::shell::Shell;
use pelage_fur::surface::corner_uv;
use pelage_gpu::{Buffer, Gpu, Recorder, Scope, recorder::RasterTargets};

/// Vertices and triangles of all objects of a world, in the order of the scene, as they follow
/// those of the skin in `shell_vertices` and `prisms`.
pub fn geometry(world: &World) -> (Vec<ShellVertex>, Vec<Prism>) {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for (number, object) in (1..).zip(&world.objects) {
        let first = (world.skin.positions.len() + vertices.len()) as u32;
        vertices.extend(vertices_of(&object.surface));
        for (corners, uv) in object.surface.triangles.iter().zip(corner_uv(&object.surface).chunks_exact(3)) {
            let [a, b, c] = [0, 1, 2].map(|k| uv[k].map(f32::to_bits));
            triangles.push(Prism {
                vertices: corners.map(|v| first + v),
                cell_base: 0,
                neighbours: [a[0], a[1], b[0]],
                subdivision: b[1],
                edges: [c[0], c[1], 0],
                object: number,
            });
        }
    }
    (vertices, triangles)
}

fn vertices_of(surface: &Skin) -> impl Iterator<Item = ShellVertex> {
    let color = |v: usize| {
        let c = surface.colors.get(v).copied().unwrap_or(glam::Vec3::ONE);
        let [r, g, b] = c.to_array().map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u32);
        r | (g << 8) | (b << 16) | (255 << 24)
    };
    (0..surface.positions.len()).map(move |v| ShellVertex {
        position: surface.positions[v].into(),
        height: 0.0,
        normal: surface.normals[v].into(),
        color: color(v),
    })
}

/// Numbers and corners of the triangles that block light: those of the skin, and those of objects
/// that are no shadow catchers.
pub(super) fn blockers(world: &World) -> (Vec<u32>, Vec<[glam::Vec3; 3]>) {
    let surfaces = std::iter::once((&world.skin, true))
        .chain(world.objects.iter().map(|o| (&o.surface, !o.shadow_catcher)));
    let (mut numbers, mut corners) = (Vec::new(), Vec::new());
    let mut first = 0;
    for (surface, blocks) in surfaces {
        let count = surface.triangles.len();
        if blocks {
            numbers.extend(first..first + count as u32);
            corners.extend((0..count).map(|t| surface.corners(t)));
        }
        first += count as u32;
    }
    (numbers, corners)
}

/// What the pass `objects` needs beside the buffers of the other passes.
pub(super) struct PreparedObjects {
    pass: Objects,
    /// Number of triangles.
    pub triangles: u32,
}

/// Allocates `shell_vertices` and `prisms` for the skin and the objects, and fills in the latter.
pub(super) fn triangle_buffers(gpu: &Gpu, world: &World) -> Result<[Buffer; 2]> {
    let (vertices, triangles) = geometry(world);
    let before = (world.skin.positions.len() as u64 * 32, world.skin.triangles.len() as u64 * 48);
    let all = [
        gpu.storage("shell_vertices", 1, before.0 + vertices.len() as u64 * 32)?,
        gpu.storage("prisms", 1, before.1 + triangles.len() as u64 * 48)?,
    ];
    if !triangles.is_empty() {
        gpu.queue.write_buffer(&all[0].raw, before.0, bytemuck::cast_slice(&vertices));
        gpu.queue.write_buffer(&all[1].raw, before.1, bytemuck::cast_slice(&triangles));
    }
    Ok(all)
}

impl Prepared<'_> {
    /// Number of triangles of all objects.
    pub fn object_triangles(&self) -> u32 {
        self.objects.as_ref().map_or(0, |o| o.triangles)
    }

    /// Uploads the materials of the objects and the grid of the fur's extinction, if objects are
    /// drawn: pictures of shells and fins show their shadows alone.
    pub(super) fn prepare_objects(&mut self, world: &World, packed: &PackedGroom) -> Result<()> {
        let gpu = self.gpu;
        let triangles: usize = world.objects.iter().map(|o| o.surface.triangles.len()).sum();
        if triangles == 0 || world.scene.render.fur == FurLayers::Shells {
            return Ok(());
        }
        let shell = Shell {
            vertices: gpu.read(self.buffer("shell_vertices")?, world.skin.positions.len() as u64 * 32)?,
            prisms: gpu.read(self.buffer("prisms")?, u64::from(self.triangles) * 48)?,
            corner_uv: corner_uv(&world.skin),
            light_reach: self.fur.lattice.reach,
        };
        let mut materials = ObjectMaterials::zeroed();
        for (to, from) in materials.materials.iter_mut().zip(&packed.objects) {
            *to = *from;
        }
        let fur = FurCells::of(world, packed, &shell);
        self.buffers.extend([
            gpu.uniform("object_materials", &materials)?,
            gpu.uniform("fur_grid", &fur.grid)?,
            gpu.upload("fur_cells", 5, &fur.cells)?,
        ]);
        self.objects = Some(PreparedObjects {
            pass: Objects::new(gpu, self.variant, self.fur.lights.count)?,
            triangles: triangles as u32,
        });
        Ok(())
    }

    /// Records step 4: the skin and the objects at all samples of a tile.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record_base(
        &self,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        targets: &RasterTargets<'_>,
    ) -> Result<()> {
        let all = self.triangles + self.object_triangles();
        self.passes.base_raster.record(recorder, scope, targets, all)?;
        if let Some(objects) = &self.objects {
            let samples = u64::from(targets.size[0]) * u64::from(targets.size[1]);
            objects.pass.record(recorder, scope, samples)?;
        }
        Ok(())
    }
}

/// Adds the buffers of a hierarchy over the blockers of light.
pub(super) fn hierarchy(gpu: &Gpu, world: &World) -> Result<[Buffer; 2]> {
    let (numbers, corners) = blockers(world);
    let (nodes, order) = super::occluders::bvh(&corners);
    let order: Vec<u32> = order.iter().map(|i| numbers.get(*i as usize).copied().unwrap_or(0)).collect();
    Ok([gpu.upload("bvh_nodes", 2, &nodes)?, gpu.upload("bvh_triangles", 2, &order)?])
}
