//! Steps 1 to 3, which do not depend on the tile: shell, volume, light and, if they fit the budget,
//! strands.

mod fur_grid;
mod lattice;
mod light;
mod objects;
mod occluders;
mod strands;
mod tables;

use crate::passes::{Passes, Variant};
pub use fur_grid::{FurCells, grid_bytes};
use lattice::Lattice;
pub use lattice::lattice_bytes;
pub use objects::geometry as object_geometry;
use pelage_core::scene::{LightLookup, MultipleModel, Storage};
use pelage_core::skin::NONE;
use pelage_core::{Error, Result, Skin, World};
use pelage_fur::groom::{self, PackedGroom};
use pelage_fur::layout::{Frame, FurParameters, LatticeParameters};
use pelage_fur::surface::{corner_uv, number_edges, skin_vertices, subdivide, vertex_uv};
use pelage_gpu::recorder::Timings;
use pelage_gpu::{Buffer, Buffers, Gpu, Recorder, Scope};
use pelage_transport::Table;
use std::sync::Arc;
pub use strands::{RootBatch, Strands, strand_bytes};
use tables::Tables;

/// A skin and its fur on the GPU.
pub struct Prepared<'g> {
    /// The device.
    pub gpu: &'g Gpu,
    /// The kernels.
    pub passes: Arc<Passes>,
    /// Parameters of undercoat, lattice and lights as uploaded.
    pub fur: FurParameters,
    /// Segments per strand.
    pub segments: u32,
    /// Number of skin triangles.
    pub triangles: u32,
    /// Number of walls over border edges of the skin.
    pub walls: u32,
    /// Number of guard hairs.
    pub strands: u64,
    /// Number of subelements of the volume.
    pub subelements: u64,
    /// Number of optical depths towards lights that end at the last step of their march.
    pub light_paths_cut: u64,
    /// All strands, if they fit the budget.
    pub resident: Option<Strands>,
    /// If they do not: ranges of triangles whose roots are drawn again for each tile.
    pub batches: Vec<RootBatch>,
    /// Bytes that strands may take.
    pub strand_budget: u64,
    /// What the passes are compiled for.
    pub variant: Variant,
    objects: Option<objects::PreparedObjects>,
    buffers: Buffers,
    /// `undercoat_fibre` for kernels that read its table in `maps_and_tables`; all others read it
    /// in `node_light`.
    rows_fibre: Buffer,
    tables: Tables,
}

/// Subelements of the undercoat, and whether their media are stored.
struct Volume {
    /// Subdivision level and first subelement of each prism.
    subdivisions: Vec<[u32; 2]>,
    subelements: u64,
    stored: bool,
}

impl Volume {
    /// Stores the media if the scene asks for it, or by default if they fit one binding and two
    /// fifths of the memory budget.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if they must be stored and exceed one binding.
    fn plan(gpu: &Gpu, world: &World) -> Result<Self> {
        let (subdivisions, subelements) = subdivide(&world.skin, world, groom::has_undercoat(&world.scene));
        let bytes = subelements * 4;
        let stored = match world.scene.undercoat.storage {
            Storage::Stored if bytes > gpu.binding_limit() => {
                return Err(Error::OutOfMemory { pass: "undercoat_density".into(), needed: bytes });
            }
            _ => stores_undercoat(world, bytes, gpu.binding_limit()),
        };
        Ok(Self { subdivisions, subelements, stored })
    }
}

/// Whether the media of the undercoat, `bytes` in all, are stored where a binding holds at most
/// `binding` bytes.
pub fn stores_undercoat(world: &World, bytes: u64, binding: u64) -> bool {
    match world.scene.undercoat.storage {
        Storage::Stored => true,
        Storage::Auto => bytes <= binding.min(world.scene.render.memory * 2 / 5),
        Storage::Evaluated => false,
    }
}

/// The variant of the passes for a scene.
fn variant_of(world: &World, packed: &PackedGroom, stored: bool, features: bool) -> Variant {
    Variant {
        stored,
        nested: world.scene.render.light == LightLookup::Nested,
        guard: packed.guard_fibre.number(),
        undercoat: packed.undercoat_fibre.number(),
        multiple: match groom::multiple_model(&world.scene) {
            MultipleModel::Auto | MultipleModel::None | MultipleModel::Similarity => 0,
            MultipleModel::Dual => 1,
            MultipleModel::Transport => 2,
        },
        coats: packed.groom.count,
        features,
    }
}

/// Uploads groom, maps, lights and skin, and allocates the shell.
fn upload(gpu: &Gpu, world: &World, packed: &PackedGroom, frame: &Frame) -> Result<Buffers> {
    let [shell_vertices, prisms] = objects::triangle_buffers(gpu, world)?;
    Ok(vec![
        gpu.uniform("frame", frame)?,
        gpu.uniform("groom", &packed.groom)?,
        gpu.uniform("noise", &packed.noise)?,
        light::upload_lights(gpu, &packed.lights)?,
        gpu.uniform("guard_fibre", &packed.guard_fibre.packed(packed.table_bases[0]))?,
        gpu.upload("maps_and_tables", 1, &packed.texels)?,
        gpu.upload("corner_uv", 1, &corner_uv(&world.skin))?,
        shell_vertices,
        prisms,
    ]
    .into())
}

impl<'g> Prepared<'g> {
    /// Runs steps 1 to 3 for the view of `frame`.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if the skin does not fit the budget, [`Error::Gpu`] if a pass fails.
    pub fn new(gpu: &'g Gpu, world: &World, frame: &Frame, timings: &mut Timings) -> Result<Self> {
        Self::with_features(gpu, world, frame, false, timings)
    }

    /// [`Prepared::new`]; if `features`, with kernels that make albedo, normal, tangent, coverages.
    ///
    /// # Errors
    /// As [`Prepared::new`].
    pub fn with_features(
        gpu: &'g Gpu,
        world: &World,
        frame: &Frame,
        features: bool,
        timings: &mut Timings,
    ) -> Result<Self> {
        let packed = groom::pack(world)?;
        let scattered =
            matches!(groom::multiple_model(&world.scene), MultipleModel::Dual | MultipleModel::Transport)
                .then(|| Table::of_world(world, &packed));
        let skin = &world.skin;
        let mut buffers = upload(gpu, world, &packed, frame)?;
        let volume = Volume::plan(gpu, world)?;
        let variant = variant_of(world, &packed, volume.stored, features);
        let tables = Tables::new(gpu, scattered.as_ref())?;
        let passes = Passes::of(gpu, variant)?;

        let fibre_table = packed.undercoat_fibre.texels();
        let room = gpu.binding_limit().saturating_sub(8 * fibre_table.len() as u64);
        let (edge_numbers, edges) = number_edges(skin);
        let tau_stride = groom::tau_stride(&world.scene, packed.light_parameters.count);
        let lattice = Lattice::plan(skin, world, &packed.undercoat, tau_stride, room);
        let columns = lattice.columns(skin, &edge_numbers, edges);
        let fur = FurParameters {
            undercoat: packed.undercoat,
            lattice: LatticeParameters {
                cells: lattice.cells,
                levels: lattice.levels,
                reach: lattice.reach,
                columns: columns.len() as u32,
                vertices: skin.positions.len() as u32,
                edges,
                tau_stride,
                padding: 0,
            },
            lights: packed.light_parameters,
        };
        let nodes = fur.lattice.columns * (fur.lattice.levels + 1);
        buffers.extend([
            gpu.uniform("fur", &fur)?,
            gpu.uniform("undercoat_fibre", &packed.undercoat_fibre.packed(2 * nodes))?,
            gpu.upload("columns", 2, &columns)?,
        ]);
        let mut prepared = Self {
            gpu,
            passes,
            fur,
            segments: packed.groom.segments,
            triangles: skin.triangles.len() as u32,
            walls: 0,
            strands: 0,
            subelements: volume.subelements,
            light_paths_cut: 0,
            resident: None,
            batches: Vec::new(),
            strand_budget: world.scene.render.memory * 3 / 10,
            variant,
            objects: None,
            buffers,
            rows_fibre: gpu
                .uniform("undercoat_fibre", &packed.undercoat_fibre.packed(packed.table_bases[1]))?,
            tables,
        };
        prepared.shell(skin, &volume, &edge_numbers, timings)?;
        prepared.volume(world, &volume, timings)?;
        prepared.light(world, &fibre_table, timings)?;
        prepared.prepare_objects(world, &packed)?;
        Ok(prepared)
    }

    /// Step 1: fills `shell_vertices` and `prisms`, and lists the border edges in `border`.
    fn shell(
        &mut self,
        skin: &Skin,
        volume: &Volume,
        edge_numbers: &[[u32; 3]],
        timings: &mut Timings,
    ) -> Result<()> {
        let gpu = self.gpu;
        let bytes = u64::from(self.triangles) * 12;
        let neighbours = gpu.storage("neighbours", 1, bytes)?;
        let inputs = [
            gpu.upload("triangles", 1, bytemuck::cast_slice::<[u32; 3], u32>(&skin.triangles))?,
            gpu.upload("skin_vertices", 1, &skin_vertices(skin, self.fur.undercoat.height))?,
            gpu.upload("vertex_uv", 1, &vertex_uv(skin))?,
            gpu.upload("subdivisions", 1, &volume.subdivisions)?,
            gpu.upload("edge_numbers", 1, bytemuck::cast_slice::<[u32; 3], u32>(edge_numbers))?,
        ];
        let scope = self.scope().with(&inputs.iter().collect::<Vec<_>>()).with(&[&neighbours]);
        let mut recorder = Recorder::new(gpu);
        let vertices = skin.positions.len() as u32;
        let _table = self.passes.edge_table.record(gpu, &mut recorder, &scope, 3 * self.triangles)?;
        let _counts =
            self.passes.shell_prisms.record(gpu, &mut recorder, &scope, vertices, self.triangles)?;
        recorder.submit(timings)?;
        let border: Vec<[u32; 2]> = gpu
            .read::<u32>(&neighbours, bytes)?
            .iter()
            .enumerate()
            .filter(|(_, n)| **n == NONE)
            .map(|(edge, _)| [edge as u32 / 3, edge as u32 % 3])
            .collect();
        self.walls = border.len() as u32;
        self.buffers.push(gpu.upload("border", 4, &border)?);
        Ok(())
    }

    /// Step 2: the media of the subelements, if they are stored, and the attributes of the
    /// lattice's columns.
    fn volume(&mut self, world: &World, volume: &Volume, timings: &mut Timings) -> Result<()> {
        let gpu = self.gpu;
        self.buffers.push(if volume.stored {
            gpu.storage("media_or_uv", 2, volume.subelements * 4)?
        } else {
            // Evaluation needs the uv, for which the march has no storage binding left.
            gpu.upload("media_or_uv", 2, &corner_uv(&world.skin))?
        });
        let mut recorder = Recorder::new(gpu);
        let scope = self.scope();
        let stored = volume.stored && groom::has_undercoat(&world.scene);
        let _counts = stored
            .then(|| {
                let pass = &self.passes.undercoat_density;
                pass.record(gpu, &mut recorder, &scope, self.triangles, self.fur.undercoat.layers)
            })
            .transpose()?;
        self.passes.shell_lattice.record(&mut recorder, &scope, self.fur.lattice.columns)?;
        recorder.submit(timings)
    }

    /// Number of nodes of the lattice.
    fn nodes(&self) -> u64 {
        u64::from(self.fur.lattice.columns) * u64::from(self.fur.lattice.levels + 1)
    }

    /// A buffer of steps 1 to 3 by its name.
    ///
    /// # Errors
    /// [`Error::Gpu`] if there is none of that name; it lists the names that exist.
    pub fn buffer(&self, name: &str) -> Result<&Buffer> {
        self.buffers.get(name)
    }

    /// Everything that later passes read, by name, except strands.
    pub fn scope(&self) -> Scope<'_> {
        self.tables.bind(self.buffers.add_to(&Scope::default()))
    }

    /// [`Prepared::scope`] for `shellfin_rows`, which reads the undercoat's scattering table in
    /// `maps_and_tables`.
    pub fn rows_scope(&self) -> Scope<'_> {
        self.scope().with(&[&self.rows_fibre])
    }
}
