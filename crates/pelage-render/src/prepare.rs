//! Steps 1 to 3: everything that does not depend on the tile: shell, volume, light and, where they fit, the strands.

mod lattice;
mod occluders;
mod tables;

use crate::passes::hair_roots::HairRoots;
use crate::passes::{Passes, Variant};
use lattice::Lattice;
use occluders::bvh;
use pelage_core::scene::{FurLayers, LightLookup, MultipleModel, Storage};
use pelage_core::skin::NONE;
use pelage_core::{Error, Result, World};
use pelage_fur::groom;
use pelage_fur::groom::PackedGroom;
use pelage_fur::layout::{Frame, FurParameters, Root};
use pelage_fur::surface::{corner_uv, number_edges, skin_vertices, subdivide, vertex_uv};
use pelage_gpu::recorder::Timings;
use pelage_gpu::{Buffer, Gpu, Recorder, Scope};
use pelage_transport::Table;
use std::sync::Arc;
use tables::Tables;

/// A skin with its fur on the GPU.
pub struct Prepared<'g> {
    /// The device.
    pub gpu: &'g Gpu,
    /// The kernels.
    pub passes: Arc<Passes>,
    /// Undercoat and lattice parameters as uploaded.
    pub fur: FurParameters,
    /// Segments a strand.
    pub segments: u32,
    /// Triangles of the skin.
    pub triangles: u32,
    /// Border walls of the shell.
    pub walls: u32,
    /// Guard hairs.
    pub strands: u64,
    /// Subelements of the volume.
    pub subelements: u64,
    /// All strands, where they fit the budget.
    pub resident: Option<Strands>,
    /// Where they do not: ranges of triangles whose roots are made again for each tile.
    pub batches: Vec<RootBatch>,
    /// Bytes that strands may take.
    pub strand_budget: u64,
    /// What the passes are compiled for.
    pub variant: Variant,
    buffers: Vec<Buffer>,
    /// `undercoat_fibre` for kernels that read the table behind the maps' texels; for all others it lies behind the light's nodes.
    rows_fibre: Buffer,
    tables: Tables,
}

/// Strands on the GPU.
pub struct Strands {
    /// How many.
    pub count: u32,
    buffers: Vec<Buffer>,
}

impl Strands {
    /// A buffer by its name: `roots`, `strand_vertices`, `shades`.
    pub fn buffer(&self, name: &str) -> Option<&Buffer> {
        self.buffers.iter().find(|b| b.name == name)
    }

    /// `scope` with `batch`, `roots`, `strand_vertices` and `shades` added.
    pub fn scope<'a>(&'a self, scope: &Scope<'a>) -> Scope<'a> {
        scope.with(&self.buffers.iter().collect::<Vec<_>>())
    }

    /// Vertices of all strands, `segments + 1` each: position, then radius and opacity as the shader packs them.
    pub(crate) fn vertices(&self) -> Option<&Buffer> {
        self.buffers.iter().find(|b| b.name == "strand_vertices")
    }
}

/// Bytes of a strand on the GPU: root, vertices, shades.
pub fn strand_bytes(segments: u32) -> u64 {
    16 + (u64::from(segments) + 1) * 24
}

impl<'g> Prepared<'g> {
    /// Runs steps 1 to 3 for the view of `frame`.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if the skin does not fit the budget, [`Error::Gpu`] if a pass fails.
    pub fn new(gpu: &'g Gpu, world: &World, frame: &Frame, timings: &mut Timings) -> Result<Self> {
        let packed = groom::pack(world)?;
        let scattered =
            matches!(groom::multiple_model(&world.scene), MultipleModel::Dual | MultipleModel::Transport)
                .then(|| Table::of_world(world, &packed));
        let PackedGroom { groom, texels, table_bases, mut fur, guard_fibre, undercoat_fibre, noise, lights } =
            packed;
        let skin = &world.skin;
        let triangles = skin.triangles.len() as u32;
        let vertices = skin.positions.len() as u32;
        let budget = world.scene.render.memory;

        let mut made = vec![
            gpu.uniform("frame", frame)?,
            gpu.uniform("groom", &groom)?,
            gpu.uniform("noise", &noise)?,
            upload_lights(gpu, &lights)?,
            gpu.uniform("guard_fibre", &guard_fibre.packed(table_bases[0]))?,
            gpu.upload("map_texels", 1, &texels)?,
            gpu.upload("corner_uv", 1, &corner_uv(skin))?,
            gpu.storage("shell_vertices", 1, u64::from(vertices) * 32)?,
            gpu.storage("prisms", 1, u64::from(triangles) * 48)?,
        ];
        let has_undercoat_layer = groom::has_undercoat(&world.scene);
        let (subdivisions, cells) = subdivide(skin, world, has_undercoat_layer);
        let cell_bytes = cells * 4;
        let room = gpu.binding_limit().min(budget * 2 / 5);
        let stored = match world.scene.undercoat.storage {
            Storage::Stored if cell_bytes > gpu.binding_limit() => {
                return Err(Error::OutOfMemory { pass: "undercoat_density".into(), needed: cell_bytes });
            }
            Storage::Stored => true,
            Storage::Auto => cell_bytes <= room,
            Storage::Evaluated => false,
        };
        fur.storage = u32::from(stored);
        let nested = world.scene.render.light == LightLookup::Nested;
        let multiple = match groom::multiple_model(&world.scene) {
            MultipleModel::Auto | MultipleModel::None | MultipleModel::Similarity => 0,
            MultipleModel::Dual => 1,
            MultipleModel::Transport => 2,
        };
        let variant =
            Variant { stored, nested, guard: guard_fibre.number(), coat: undercoat_fibre.number(), multiple };
        let tables = Tables::new(gpu, scattered.as_ref())?;
        let passes = Passes::of(gpu, variant)?;
        let undercoat_table = undercoat_fibre.texels();
        let room = gpu.binding_limit().saturating_sub(8 * undercoat_table.len() as u64);
        let lattice = Lattice::plan(skin, world, &fur, room);
        fur.lattice = lattice.edge;
        fur.levels = lattice.levels;
        fur.light_reach = lattice.reach;
        let (edge_numbers, edges) = number_edges(skin);
        fur.edges = edges;
        let columns = lattice.columns(skin, &edge_numbers, edges);
        fur.columns = columns.len() as u32;
        made.push(gpu.uniform("fur", &fur)?);
        made.push(
            gpu.uniform("undercoat_fibre", &undercoat_fibre.packed(2 * fur.columns * (fur.levels + 1)))?,
        );

        // Step 1
        let neighbours = gpu.storage("neighbours", 1, u64::from(triangles) * 12)?;
        {
            let inputs = [
                gpu.upload("triangles", 1, bytemuck::cast_slice::<[u32; 3], u32>(&skin.triangles))?,
                gpu.upload("skin_vertices", 1, &skin_vertices(skin, fur.height))?,
                gpu.upload("vertex_uv", 1, &vertex_uv(skin))?,
                gpu.upload("subdivisions", 1, &subdivisions)?,
                gpu.upload("edge_numbers", 1, bytemuck::cast_slice::<[u32; 3], u32>(&edge_numbers))?,
            ];
            let scope = scope_of(&made).with(&inputs.iter().collect::<Vec<_>>()).with(&[&neighbours]);
            let mut recorder = Recorder::new(gpu);
            let _table = passes.edge_table.record(gpu, &mut recorder, &scope, 3 * triangles)?;
            let _counts = passes.shell_prisms.record(gpu, &mut recorder, &scope, vertices, triangles)?;
            recorder.submit(timings)?;
        }
        let border: Vec<[u32; 2]> = gpu
            .read::<u32>(&neighbours, u64::from(triangles) * 12)?
            .iter()
            .enumerate()
            .filter(|(_, n)| **n == NONE)
            .map(|(edge, _)| [edge as u32 / 3, edge as u32 % 3])
            .collect();
        drop(neighbours);
        let walls = border.len() as u32;
        made.push(gpu.upload("border", 4, &border)?);

        // Step 2
        let nodes = u64::from(fur.columns) * u64::from(fur.levels + 1);
        let pairs = groom::tau_pairs(fur.lights);
        let mut recorder = Recorder::new(gpu);
        let volume = if stored {
            gpu.storage("cells", 2, cell_bytes)?
        } else {
            // The volume's buffer carries the uv instead.
            gpu.upload("cells", 2, &corner_uv(skin))?
        };
        made.push(volume);
        made.push(gpu.upload("columns", 2, &columns)?);
        {
            let scope = scope_of(&made);
            let _counts = if stored && has_undercoat_layer {
                Some(passes.undercoat_density.record(gpu, &mut recorder, &scope, triangles, fur.layers)?)
            } else {
                None
            };
            passes.shell_lattice.record(&mut recorder, &scope, fur.columns)?;
            recorder.submit(timings)?;
        }

        let strand_budget = budget * 3 / 10;
        let mut prepared = Self {
            gpu,
            passes,
            fur,
            segments: groom.segments,
            triangles,
            walls,
            strands: 0,
            subelements: cells,
            resident: None,
            batches: Vec::new(),
            strand_budget,
            variant,
            buffers: made,
            tables,
            rows_fibre: gpu.uniform("undercoat_fibre", &undercoat_fibre.packed(table_bases[1]))?,
        };
        prepared.light(world, nodes, pairs, &undercoat_table, timings)?;
        Ok(prepared)
    }

    /// A buffer that later passes read, by its name.
    pub fn buffer(&self, name: &str) -> Option<&Buffer> {
        self.buffers.iter().find(|b| b.name == name)
    }

    /// Everything that later passes read, by name.
    pub fn scope(&self) -> Scope<'_> {
        self.tables.bind(scope_of(&self.buffers))
    }

    /// [`Prepared::scope`] for the rows of shells and fins.
    pub fn rows_scope(&self) -> Scope<'_> {
        self.scope().with(&[&self.rows_fibre])
    }

    /// Guard hairs' roots, what they take from the light, the light, and their shading.
    fn light(
        &mut self,
        world: &World,
        nodes: u64,
        pairs: u32,
        table: &[[u32; 2]],
        timings: &mut Timings,
    ) -> Result<()> {
        let gpu = self.gpu;
        let deposits = gpu.storage("deposits", 2, nodes * 4)?;
        let extinction = gpu.storage("lattice_extinction", 2, nodes * 4)?;
        if groom::has_guard(&world.scene) {
            let batches = self.root_batches(world, timings)?;
            let single = batches.len() == 1;
            for batch in &batches {
                let strands = self.grow(batch, timings)?;
                let mut recorder = Recorder::new(gpu);
                let scope = strands.scope(&self.scope()).with(&[&deposits, &extinction]);
                self.passes.guard_splat.record_deposit(&mut recorder, &scope, strands.count)?;
                recorder.submit(timings)?;
                if single {
                    self.resident = Some(strands);
                }
            }
            if !single {
                self.batches = batches;
            }
        }
        let mut recorder = Recorder::new(gpu);
        let scope = self.scope().with(&[&deposits, &extinction]);
        self.passes.guard_splat.record_normalise(&mut recorder, &scope, nodes)?;
        recorder.submit(timings)?;
        drop(deposits);

        let (bvh_nodes, bvh_triangles) = bvh(&world.skin);
        let tree = [gpu.upload("bvh_nodes", 2, &bvh_nodes)?, gpu.upload("bvh_triangles", 2, &bvh_triangles)?];
        let tau = gpu.storage("tau", 2, nodes * u64::from(self.fur.tau_stride) * 4)?;
        let source = gpu.storage("source", 2, nodes * 16 + table.len() as u64 * 8)?;
        if !table.is_empty() {
            gpu.queue.write_buffer(&source.raw, nodes * 16, bytemuck::cast_slice(table));
        }
        let base_light = gpu.storage("base_light", 2, u64::from(self.fur.columns) * 8)?;
        {
            let mut recorder = Recorder::new(gpu);
            let scope = self
                .scope()
                .with(&[&extinction, &tau, &source, &base_light])
                .with(&tree.iter().collect::<Vec<_>>());
            self.passes.light_occlusion.record(&mut recorder, &scope, self.fur.columns)?;
            let _sweeps = self.passes.undercoat_light.record(
                gpu,
                &mut recorder,
                &scope,
                self.fur.columns,
                self.fur.levels,
                pairs,
            )?;
            self.passes.undercoat_source.record(&mut recorder, &scope, nodes)?;
            recorder.submit(timings)?;
        }
        self.buffers.extend([tau, source, base_light, extinction]);
        if world.scene.render.fur == FurLayers::Shells {
            // The hairs are in the textures: here they only cast shadows.
            self.resident = None;
            self.batches.clear();
        }
        if let Some(strands) = &self.resident {
            self.shade(strands, timings)?;
        }
        Ok(())
    }

    /// Counts the roots of all triangles and cuts them into ranges whose strands fit the budget.
    pub(crate) fn root_batches(&mut self, world: &World, timings: &mut Timings) -> Result<Vec<RootBatch>> {
        let gpu = self.gpu;
        let density = world.scene.guard.density.max();
        let seed = world.scene.render.seed;
        let counts = gpu.storage("root_counts", 1, u64::from(self.triangles) * 4)?;
        let batch = HairRoots::batch(gpu, 0, self.triangles, density, seed)?;
        let mut recorder = Recorder::new(gpu);
        self.passes.hair_roots.record_count(
            &mut recorder,
            &self.scope().with(&[&counts, &batch]),
            self.triangles,
        )?;
        recorder.submit(timings)?;
        let counts: Vec<u32> = gpu.read(&counts, u64::from(self.triangles) * 4)?;
        self.strands = counts.iter().map(|c| u64::from(*c)).sum();
        let vertex_limit = gpu.binding_limit() / (16 * (u64::from(self.segments) + 1));
        let most = (self.strand_budget / strand_bytes(self.segments)).min(vertex_limit).max(1);
        let mut batches: Vec<RootBatch> = Vec::new();
        for (triangle, count) in counts.iter().enumerate() {
            let fits = batches.last().is_some_and(|b| b.strands + u64::from(*count) <= most);
            if !fits {
                batches.push(RootBatch {
                    first: triangle as u32,
                    counts: Vec::new(),
                    strands: 0,
                    density,
                    seed,
                });
            }
            if let Some(last) = batches.last_mut() {
                last.counts.push(*count);
                last.strands += u64::from(*count);
            }
        }
        if let Some(big) = batches.iter().find(|b| b.strands > most) {
            return Err(Error::OutOfMemory {
                pass: "guard_strands".into(),
                needed: big.strands * strand_bytes(self.segments),
            });
        }
        Ok(batches)
    }

    /// Makes the strands of a range of triangles.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Gpu`].
    pub fn grow(&self, batch: &RootBatch, timings: &mut Timings) -> Result<Strands> {
        let roots = self.roots(batch, timings)?;
        self.grow_from(roots, batch.strands as u32, timings)
    }

    /// Makes the roots of a range of triangles.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Gpu`].
    pub fn roots(&self, batch: &RootBatch, timings: &mut Timings) -> Result<Buffer> {
        let gpu = self.gpu;
        let triangles = batch.counts.len() as u32;
        let first_roots: Vec<u32> = batch
            .counts
            .iter()
            .scan(0, |sum, c| {
                let first = *sum;
                *sum += c;
                Some(first)
            })
            .collect();
        let roots = gpu.storage("roots", 3, batch.strands * std::mem::size_of::<Root>() as u64)?;
        let range = HairRoots::batch(gpu, batch.first, triangles, batch.density, batch.seed)?;
        let firsts = gpu.upload("first_roots", 1, &first_roots)?;
        let mut recorder = Recorder::new(gpu);
        let scope = self.scope().with(&[&range, &firsts, &roots]);
        self.passes.hair_roots.record_emit(&mut recorder, &scope, triangles)?;
        recorder.submit(timings)?;
        Ok(roots)
    }

    /// Makes the strands of the first `count` of `roots`.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Gpu`].
    pub fn grow_from(&self, roots: Buffer, count: u32, timings: &mut Timings) -> Result<Strands> {
        let gpu = self.gpu;
        let vertices = u64::from(count) * (u64::from(self.segments) + 1);
        let batch = gpu.uniform("batch", &[count, 0, 0, 0])?;
        let strand_vertices = gpu.storage("strand_vertices", 3, vertices * 16)?;
        let shades = gpu.storage("shades", 3, vertices * 8)?;
        let strands = Strands { count, buffers: vec![batch, roots, strand_vertices, shades] };
        let mut recorder = Recorder::new(gpu);
        self.passes.guard_strands.record(&mut recorder, &strands.scope(&self.scope()), count)?;
        recorder.submit(timings)?;
        Ok(strands)
    }

    /// Shades strands from the finished light.
    ///
    /// # Errors
    /// [`Error::Gpu`].
    pub fn shade(&self, strands: &Strands, timings: &mut Timings) -> Result<()> {
        let mut recorder = Recorder::new(self.gpu);
        self.passes.guard_shade.record(&mut recorder, &strands.scope(&self.scope()), strands.count)?;
        recorder.submit(timings)
    }
}

/// A range of triangles and the number of roots of each.
pub struct RootBatch {
    /// First triangle.
    pub first: u32,
    /// Roots of each triangle.
    pub counts: Vec<u32>,
    /// Their sum.
    pub strands: u64,
    density: f32,
    seed: u32,
}

fn scope_of(buffers: &[Buffer]) -> Scope<'_> {
    Scope::default().with(&buffers.iter().collect::<Vec<_>>())
}

fn upload_lights(gpu: &Gpu, lights: &[pelage_fur::layout::Light]) -> Result<Buffer> {
    let mut all = [<pelage_fur::layout::Light as bytemuck::Zeroable>::zeroed(); groom::MAX_LIGHTS];
    all[..lights.len()].copy_from_slice(lights);
    gpu.uniform("lights", &all)
}
