//! Runs the passes step by step and reads their results back, to compare with the CPU twins and to
//! make figures of single steps.

use crate::prepare::Prepared;
use crate::tile_buffers::{COUNTER_BYTES, MarchCounts, TileBuffers, fragment_bytes, list_bytes};
use crate::twin::base_raster;
use crate::twin::film::{Sample, unpack};
use crate::twin::resolve::{Base, Node};
use crate::twin::undercoat_march::MarchInputs;
use bytemuck::Pod;
use glam::Vec2;
use pelage_core::{Error, Result, World};
use pelage_fur::camera::FLAG_SORTED_LISTS;
use pelage_fur::groom::PackedGroom;
use pelage_fur::layout::{BASE_WORDS, Bin, Frame, FurParameters, SAMPLE_FEATURE_WORDS, SAMPLE_WORDS};
use pelage_fur::parameters::Maps;
use pelage_fur::shell::Shell;
use pelage_fur::simplex::Field;
use pelage_fur::surface::corner_uv;
use pelage_fur::undercoat::Undercoat;
use pelage_fur::{camera, groom};
use pelage_gpu::recorder::{RasterTargets, Timings};
use pelage_gpu::{Buffer, Gpu, Recorder, Resource, Scope};
use std::ops::Deref;
use std::sync::Arc;

/// The frame globals of the scene's camera for a film of `film` samples.
pub fn frame_of(world: &World, film: [u32; 2]) -> Frame {
    camera::frame(&world.scene.camera, film, Vec2::ZERO, Vec2::ZERO, world.scene.render.seed)
}

/// A world after steps 1 to 3, with the results that the twins of later steps read.
pub struct PreparedWorld<'g> {
    /// The world.
    pub world: World,
    /// Its fur on the GPU.
    pub prepared: Prepared<'g>,
    /// The packed groom.
    pub packed: PackedGroom,
    /// Parameters of undercoat, lattice and lights as the passes read them.
    pub fur: FurParameters,
    /// The shell that the passes computed.
    pub shell: Shell,
    /// The buffer `node_light`, one entry per node of the lattice.
    pub source: Vec<[u32; 4]>,
    /// The packed media of all subelements; empty if they are evaluated.
    pub cells: Vec<u32>,
}

impl<'g> PreparedWorld<'g> {
    /// Runs steps 1 to 3 for the scene's camera and a film of `film` samples.
    ///
    /// # Errors
    /// As [`Prepared::new`].
    pub fn new(gpu: &'g Gpu, world: World, film: [u32; 2]) -> Result<Self> {
        Self::with_features(gpu, world, film, false)
    }

    /// [`PreparedWorld::new`] with kernels that make albedo, normal, tangent and coverages if
    /// `features`.
    ///
    /// # Errors
    /// As [`Prepared::new`].
    pub fn with_features(gpu: &'g Gpu, world: World, film: [u32; 2], features: bool) -> Result<Self> {
        let (frame, mut timings) = (frame_of(&world, film), Timings::default());
        let prepared = Prepared::with_features(gpu, &world, &frame, features, &mut timings)?;
        let mut read = Self {
            packed: groom::pack(&world)?,
            fur: prepared.fur,
            shell: Shell::default(),
            source: Vec::new(),
            cells: Vec::new(),
            prepared,
            world,
        };
        read.shell = Shell {
            vertices: read.read("shell_vertices", read.world.skin.positions.len())?,
            prisms: read.read("prisms", read.world.skin.triangles.len())?,
            corner_uv: corner_uv(&read.world.skin),
            light_reach: read.fur.lattice.reach,
        };
        read.source =
            read.read("node_light", (read.fur.lattice.columns * (read.fur.lattice.levels + 1)) as usize)?;
        if read.prepared.variant.stored {
            read.cells = read.read("media_or_uv", read.prepared.subelements as usize)?;
        }
        Ok(read)
    }

    /// The first `count` elements of a buffer of the prepared world or of its strands.
    ///
    /// # Errors
    /// [`Error::Gpu`] if there is none of that name; it lists the names that exist.
    pub fn read<T: Pod>(&self, name: &str, count: usize) -> Result<Vec<T>> {
        let of_strands = self.prepared.resident.as_ref().and_then(|strands| strands.buffer(name).ok());
        let buffer = of_strands.map_or_else(|| self.prepared.buffer(name), Ok)?;
        self.prepared.gpu.read(buffer, (count * size_of::<T>()) as u64)
    }

    /// The groom and its maps.
    pub fn maps(&self) -> Maps<'_> {
        Maps { groom: &self.packed.groom, texels: &self.packed.texels }
    }

    /// The noise of the scene's seed.
    pub fn noise(&self) -> Field {
        Field::new(self.world.scene.render.seed)
    }

    /// The undercoat, stored or evaluated as in the renderer.
    pub fn undercoat(&self) -> Undercoat<'_> {
        Undercoat { cells: &self.cells, ..self.evaluated_undercoat() }
    }

    /// The undercoat, evaluated even if the renderer stores it.
    pub fn evaluated_undercoat(&self) -> Undercoat<'_> {
        Undercoat { parameters: &self.fur.undercoat, noise: self.noise(), shell: &self.shell, cells: &[] }
    }
}

/// A tile of a prepared world, on which steps 4 to 7 run one by one.
pub struct Probe<'g> {
    /// The prepared world.
    pub of: Arc<PreparedWorld<'g>>,
    /// Frame globals of the tile.
    pub frame: Frame,
    buffers: TileBuffers,
    uniform: Buffer,
}

impl<'g> Deref for Probe<'g> {
    type Target = PreparedWorld<'g>;

    fn deref(&self) -> &Self::Target {
        &self.of
    }
}

impl<'g> Probe<'g> {
    /// A tile of `size` samples at `origin` of a film of `film` samples, with room for `capacity`
    /// fragments.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Gpu`].
    pub fn new(
        of: &Arc<PreparedWorld<'g>>,
        film: [u32; 2],
        origin: [i32; 2],
        size: [u32; 2],
        capacity: u64,
    ) -> Result<Self> {
        let gpu = of.prepared.gpu;
        let mut frame = frame_of(&of.world, film);
        frame.tile_origin = origin;
        frame.tile_size = size;
        frame.node_capacity = capacity as u32;
        let samples = u64::from(size[0]) * u64::from(size[1]);
        let features = of.prepared.variant.features;
        let bytes = list_bytes(samples, 0) + capacity * fragment_bytes(features);
        let buffers = TileBuffers::new(gpu, size, bytes, features)?;
        Ok(Self { of: of.clone(), frame, buffers, uniform: gpu.uniform("frame", &frame)? })
    }

    /// Number of samples of the tile.
    pub fn samples(&self) -> usize {
        let [w, h] = self.frame.tile_size;
        w as usize * h as usize
    }

    /// Position of the `i`-th sample in the tile.
    pub fn xy(&self, i: usize) -> [u32; 2] {
        let width = self.frame.tile_size[0] as usize;
        [(i % width) as u32, (i / width) as u32]
    }

    /// The resources of the prepared world and of the tile.
    pub fn scope(&self) -> Scope<'_> {
        self.buffers.add_to(&self.of.prepared.scope().with(&[&self.uniform]))
    }

    /// The targets of raster passes.
    pub fn targets(&self) -> RasterTargets<'_> {
        self.buffers.targets(self.frame.tile_size)
    }

    /// The tile's buffers.
    pub fn buffers(&self) -> &TileBuffers {
        &self.buffers
    }

    fn run(&self, record: impl FnOnce(&mut Recorder<'_>, &Scope<'_>) -> Result<()>) -> Result<()> {
        let mut recorder = Recorder::new(self.prepared.gpu);
        record(&mut recorder, &self.scope())?;
        recorder.submit(&mut Timings::default())
    }

    /// Step 4: fills `base_records`.
    ///
    /// # Errors
    /// [`Error::Gpu`].
    pub fn draw_base(&self) -> Result<()> {
        let p = &self.of.prepared;
        self.run(|recorder, scope| p.record_base(recorder, scope, &self.targets()))
    }

    /// Step 5: adds the entries into the shell to the lists.
    ///
    /// # Errors
    /// [`Error::Gpu`].
    pub fn draw_entries(&self) -> Result<()> {
        let p = &self.of.prepared;
        self.run(|recorder, scope| {
            p.passes.shell_entry.record(recorder, scope, &self.targets(), p.triangles, p.walls)
        })
    }

    /// Step 5: marches from the entries and adds shell or virtual fragments to the lists.
    ///
    /// # Errors
    /// [`Error::Gpu`].
    pub fn march(&self) -> Result<()> {
        let samples = self.samples() as u64;
        self.run(|recorder, scope| self.prepared.passes.undercoat_march.record(recorder, scope, samples))
    }

    /// Step 6: adds the fragments of all strands to the lists.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if they are not resident.
    pub fn draw_strands(&self) -> Result<()> {
        let p = &self.of.prepared;
        if p.strands == 0 {
            return Ok(());
        }
        let Some(strands) = &p.resident else {
            return Err(Error::Unsupported(
                "the guard hairs do not fit the memory budget of the scene".into(),
            ));
        };
        let all: Vec<u32> = (0..strands.count).collect();
        let list = p.gpu.upload("bins", 6, &all)?;
        let bin = p.gpu.uniform("bin", &Bin { start: 0, strands: strands.count })?;
        self.run(|recorder, scope| {
            let scope = strands.scope(scope).with(&[&list, &bin]);
            p.passes.guard_raster.record(recorder, &scope, strands.count, p.segments)
        })
    }

    /// Step 7: resolves the lists; `exact` marches the undercoat between the fragments.
    ///
    /// # Errors
    /// [`Error::Gpu`].
    pub fn resolve(&self, exact: bool) -> Result<Vec<Sample>> {
        let count = self.samples() as u64;
        self.run(|recorder, scope| self.prepared.passes.resolve.record(recorder, scope, count, exact))?;
        self.resolved()
    }

    /// The samples that `resolve` wrote.
    fn resolved(&self) -> Result<Vec<Sample>> {
        let features = self.prepared.variant.features;
        let of_sample = SAMPLE_WORDS + if features { SAMPLE_FEATURE_WORDS } else { 0 };
        let words: Vec<u32> = self.read("samples", self.samples() * of_sample as usize)?;
        Ok(words.chunks_exact(of_sample as usize).map(unpack).collect())
    }

    /// Sorts the lists and resolves them; the counts begin again.
    ///
    /// # Errors
    /// [`Error::Gpu`].
    pub fn sort_and_resolve(&self, exact: bool) -> Result<Vec<Sample>> {
        let gpu = self.prepared.gpu;
        let count = self.samples() as u64;
        let frame = Frame { flags: self.frame.flags | FLAG_SORTED_LISTS, ..self.frame };
        let frame = gpu.uniform("frame", &frame)?;
        let lists = self.buffers.buffer("fragment_lists")?;
        let longest = self.counters()?.longest;
        let mut runs = Vec::new();
        self.run(|recorder, scope| {
            let scope = scope.with(&[&frame]).and("lists_to_sort", Resource::Buffer(&lists.raw));
            let resolve = &self.prepared.passes.resolve;
            runs = resolve.record_sort(gpu, recorder, &scope, count, longest)?;
            recorder.clear(self.buffers.buffer("march_counters")?, COUNTER_BYTES);
            resolve.record(recorder, &scope, count, exact)
        })?;
        self.resolved()
    }

    /// What the march and `resolve` counted.
    ///
    /// # Errors
    /// [`Error::Gpu`].
    pub fn counters(&self) -> Result<MarchCounts> {
        self.buffers.counts(self.prepared.gpu)
    }

    /// The fragments of each sample, nearest first.
    ///
    /// # Errors
    /// As [`TileBuffers::lists`].
    pub fn lists(&self) -> Result<Vec<Vec<Node>>> {
        self.buffers.lists(self.prepared.gpu, self.samples())
    }

    /// The packed record of the skin at each sample.
    ///
    /// # Errors
    /// [`Error::Gpu`].
    pub fn base_records(&self) -> Result<Vec<[u32; BASE_WORDS as usize]>> {
        self.read("base_records", self.samples())
    }

    /// The skin at each sample, if it is hit.
    ///
    /// # Errors
    /// [`Error::Gpu`].
    pub fn bases(&self) -> Result<Vec<Option<Base>>> {
        let seen = self.base_records()?.into_iter().map(base_raster::unpack);
        Ok(seen
            .map(|b| {
                (b.z < base_raster::NO_BASE).then_some(Base {
                    z: b.z,
                    radiance: b.radiance,
                    transparency: b.transparency,
                })
            })
            .collect())
    }

    /// The first `count` elements of a buffer of the tile, of the prepared world or of its strands.
    ///
    /// # Errors
    /// [`Error::Gpu`] if there is none of that name; it lists the names that exist.
    pub fn read<T: Pod>(&self, name: &str, count: usize) -> Result<Vec<T>> {
        match self.buffers.buffer(name) {
            Ok(buffer) => self.prepared.gpu.read(buffer, (count * size_of::<T>()) as u64),
            Err(_) => self.of.read(name, count),
        }
    }

    /// Inputs of the march on this tile.
    pub fn inputs(&self) -> MarchInputs<'_> {
        MarchInputs {
            fur: &self.fur,
            undercoat: self.undercoat(),
            source: &self.source,
            frame: &self.frame,
            undercoat_fibre: &self.packed.undercoat_fibre,
        }
    }
}
