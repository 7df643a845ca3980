//! A tile of a world through the renderer's passes, with what each leaves read back for the CPU twins and for pictures.

use bytemuck::Pod;
use glam::{Vec2, Vec4};
use pelage_core::{Error, Result, World};
use pelage_fur::camera;
use pelage_fur::groom;
use pelage_fur::groom::PackedGroom;
use pelage_fur::layout::{Frame, FurParameters};
use pelage_fur::shell::Shell;
use pelage_fur::simplex::Field;
use pelage_fur::surface::corner_uv;
use pelage_fur::undercoat::Undercoat;
use pelage_gpu::kernel::{DEPTH_FORMAT, ID_FORMAT};
use pelage_gpu::recorder::{RasterTargets, Timings};
use pelage_gpu::{Buffer, Gpu, Recorder, Resource, Scope};
use pelage_render::prepare::Prepared;
use pelage_render::twin::base_raster;
use pelage_render::twin::film::{Sample, halves, unpack};
use pelage_render::twin::resolve::{Base, Node, sort};
use pelage_render::twin::undercoat_march::MarchInputs;

/// Fragments a sample for which there is room, if a binding holds them.
const FRAGMENTS: u64 = 256;

/// A tile of one sample a pixel, and its world after steps 1 to 3.
pub(super) struct Probe<'a> {
    pub(super) world: &'a World,
    pub(super) prepared: Prepared<'a>,
    pub(super) packed: PackedGroom,
    /// Undercoat and lattice as the passes read them.
    pub(super) fur: FurParameters,
    pub(super) shell: Shell,
    /// The light lattice as the march reads it.
    pub(super) source: Vec<[u32; 4]>,
    /// The stored volume; empty where it is evaluated.
    pub(super) cells: Vec<u32>,
    /// The tile.
    pub(super) frame: Frame,
    capacity: u64,
    buffers: Vec<Buffer>,
    ids: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl<'a> Probe<'a> {
    /// Runs steps 1 to 4 for the tile of `size` pixels at `origin` of a film of `film` pixels, and finds the entries into the shell.
    pub(super) fn new(
        gpu: &'a Gpu,
        world: &'a World,
        film: [u32; 2],
        origin: [u32; 2],
        size: [u32; 2],
    ) -> Result<Self> {
        let scene = &world.scene;
        let mut frame = camera::frame(&scene.camera, film, Vec2::ZERO, Vec2::ZERO, scene.render.seed);
        let prepared = Prepared::new(gpu, world, &frame, &mut Timings::default())?;
        let fur = prepared.fur;
        let samples = u64::from(size[0]) * u64::from(size[1]);
        let most = (gpu.binding_limit() / 4 - 1 - samples) / 5;
        let capacity = (FRAGMENTS * samples).min(most);
        frame.tile_origin = origin.map(|x| x as i32);
        frame.tile_size = size;
        frame.node_capacity = capacity as u32;
        let buffers = vec![
            gpu.uniform("frame", &frame)?,
            gpu.storage("base_records", 5, samples * 16)?,
            gpu.storage("fragment_lists", 6, (1 + samples + 5 * capacity) * 4)?,
            gpu.storage("samples", 7, samples * 32)?,
            gpu.storage("lost_rays", 7, 16)?,
        ];
        let texture = |format, usage| {
            let descriptor = wgpu::TextureDescriptor {
                label: Some("probe"),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            };
            gpu.device.create_texture(&descriptor).create_view(&Default::default())
        };
        use wgpu::TextureUsages as U;
        let ids = texture(ID_FORMAT, U::RENDER_ATTACHMENT | U::TEXTURE_BINDING);
        let depth = texture(DEPTH_FORMAT, U::RENDER_ATTACHMENT);
        let mut probe = Self {
            world,
            packed: groom::pack(world)?,
            fur,
            shell: Shell::default(),
            source: Vec::new(),
            cells: Vec::new(),
            frame,
            capacity,
            buffers,
            ids,
            depth,
            prepared,
        };
        probe.shell = Shell {
            vertices: probe.read("shell_vertices", world.skin.positions.len())?,
            prisms: probe.read("prisms", world.skin.triangles.len())?,
            corner_uv: corner_uv(&world.skin),
            light_reach: fur.light_reach,
        };
        probe.source = probe.read("source", (fur.columns * (fur.levels + 1)) as usize)?;
        if fur.storage == 1 {
            probe.cells = probe.read("cells", probe.prepared.subelements as usize)?;
        }
        let p = &probe.prepared;
        probe.run(|recorder, scope, targets| {
            p.passes.base_raster.record(recorder, scope, targets, p.triangles)
        })?;
        if groom::has_undercoat(scene) {
            probe.run(|recorder, scope, targets| {
                p.passes.shell_entry.record(recorder, scope, targets, p.triangles, p.walls)
            })?;
        }
        Ok(probe)
    }

    fn run(
        &self,
        record: impl FnOnce(&mut Recorder<'_>, &Scope<'_>, &RasterTargets<'_>) -> Result<()>,
    ) -> Result<()> {
        let mut recorder = Recorder::new(self.prepared.gpu);
        let scope = self.prepared.scope().with(&self.buffers.iter().collect::<Vec<_>>());
        let scope = scope.and("triangle_ids", Resource::Texture(&self.ids));
        let targets = RasterTargets { ids: &self.ids, depth: &self.depth, size: self.frame.tile_size };
        record(&mut recorder, &scope, &targets)?;
        recorder.submit(&mut Timings::default())
    }

    /// The first `count` elements of a buffer of the prepared world, of its strands or of the tile.
    pub(super) fn read<T: Pod>(&self, name: &str, count: usize) -> Result<Vec<T>> {
        let p = &self.prepared;
        let buffer = p
            .buffer(name)
            .or_else(|| p.resident.as_ref().and_then(|strands| strands.buffer(name)))
            .or_else(|| self.buffers.iter().find(|b| b.name == name))
            .ok_or_else(|| Error::Unsupported(format!("the renderer kept no buffer {name:?}")))?;
        p.gpu.read(buffer, (count * size_of::<T>()) as u64)
    }

    /// Pixels of the tile.
    pub(super) fn samples(&self) -> usize {
        let [w, h] = self.frame.tile_size;
        w as usize * h as usize
    }

    /// Place of the `i`-th pixel in the tile.
    pub(super) fn xy(&self, i: usize) -> [u32; 2] {
        let width = self.frame.tile_size[0] as usize;
        [(i % width) as u32, (i / width) as u32]
    }

    /// What the march reads.
    pub(super) fn inputs(&self) -> MarchInputs<'_> {
        let undercoat = Undercoat {
            fur: &self.fur,
            noise: Field::new(self.world.scene.render.seed),
            shell: &self.shell,
            cells: &self.cells,
        };
        MarchInputs {
            undercoat,
            source: &self.source,
            frame: &self.frame,
            coat: &self.packed.undercoat_fibre,
        }
    }

    /// Step 5's march, which adds shell or virtual fragments.
    pub(super) fn march(&self) -> Result<()> {
        let samples = self.samples() as u64;
        self.run(|recorder, scope, _| self.prepared.passes.undercoat_march.record(recorder, scope, samples))
    }

    /// Step 6, all strands.
    pub(super) fn draw_strands(&self) -> Result<()> {
        let p = &self.prepared;
        if p.strands == 0 {
            return Ok(());
        }
        let Some(strands) = &p.resident else {
            return Err(Error::Unsupported("the guard hairs do not fit the scene's memory at once".into()));
        };
        let all: Vec<u32> = (0..strands.count).collect();
        let list = p.gpu.upload("bins", 6, &all)?;
        let bin = p.gpu.uniform("bin", &[0, strands.count, 0, 0])?;
        self.run(|recorder, scope, _| {
            let scope = strands.scope(scope).with(&[&list, &bin]);
            p.passes.guard_raster.record(recorder, &scope, strands.count, p.segments)
        })
    }

    /// Step 7; `exact` marches the undercoat between the fragments.
    pub(super) fn resolve(&self, exact: bool) -> Result<Vec<Sample>> {
        let count = self.samples();
        self.run(|recorder, scope, _| {
            self.prepared.passes.resolve.record(recorder, scope, count as u64, exact)
        })?;
        Ok(self.read::<[u32; 8]>("samples", count)?.into_iter().map(unpack).collect())
    }

    /// The fragments of each pixel, nearest first.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if there were more than the lists hold.
    pub(super) fn lists(&self) -> Result<Vec<Vec<Node>>> {
        let count = self.samples();
        let used = u64::from(self.read::<u32>("fragment_lists", 1)?[0]);
        if used > self.capacity {
            return Err(Error::Unsupported(format!(
                "{used} fragments, and room for {}: make the tile smaller",
                self.capacity
            )));
        }
        let words: Vec<u32> = self.read("fragment_lists", 1 + count + 5 * used as usize)?;
        let list = |head: u32| {
            let mut nodes = Vec::new();
            let mut next = head;
            while next != 0 {
                let at = &words[1 + count + 5 * (next as usize - 1)..][..5];
                let ([r, g], [b, a]) = (halves(at[3]), halves(at[4]));
                let color = Vec4::new(r, g, b, a);
                nodes.push(Node { z: f32::from_bits(at[1]), source: at[2], color });
                next = at[0];
            }
            sort(&mut nodes);
            nodes
        };
        Ok(words[1..=count].iter().map(|head| list(*head)).collect())
    }

    /// The skin under each pixel.
    pub(super) fn bases(&self) -> Result<Vec<Option<Base>>> {
        let records: Vec<[u32; 4]> = self.read("base_records", self.samples())?;
        let seen = records.into_iter().map(base_raster::unpack);
        Ok(seen
            .map(|b| (b.z < base_raster::NO_BASE).then_some(Base { z: b.z, radiance: b.radiance }))
            .collect())
    }
}
