//! Steps 4 to 7, tile by tile. A tile whose fragments do not fit is cut into four and rendered again: nothing is dropped.

use crate::driver::{RenderOptions, marches_in_resolve};
use crate::plan::SamplePlan;
use crate::prepare::{Prepared, Strands};
use pelage_core::film::Film;
use pelage_core::stats::Stats;
use pelage_core::{Error, Result, World};
use pelage_fur::camera;
use pelage_fur::groom;
use pelage_fur::layout::Frame;
use pelage_gpu::kernel::{DEPTH_FORMAT, ID_FORMAT};
use pelage_gpu::recorder::{RASTER_MARGIN, RasterTargets, Timings};
use pelage_gpu::{Buffer, Gpu, Recorder, Resource, Scope};
use std::sync::atomic::{AtomicBool, Ordering};

/// Bytes a sample takes besides its fragments: base record, list head, film sample, triangle number, depth.
const SAMPLE_BYTES: u64 = 16 + 4 + 32 + 4 + 4;
/// Bytes of a fragment in the lists.
pub const FRAGMENT_BYTES: u64 = 20;
/// Fragments a sample that a tile is sized for.
const EXPECTED_FRAGMENTS: u64 = 8;
/// Smallest edge of a tile in pixels; a tile that small that still does not fit is an error.
const SMALLEST: u32 = 4;

/// A rectangle of pixels, and the bin of strands that may touch it.
#[derive(Debug, Clone, Copy)]
pub struct Job {
    /// First pixel.
    pub origin: [u32; 2],
    /// Pixels.
    pub size: [u32; 2],
    bin: u32,
}

impl Job {
    /// Tiles of `edge` pixels that cover a film of `size` pixels, row by row; only the parts within `crop` (x0 x1 y0 y1 in 0..1).
    pub fn grid(size: [u32; 2], edge: u32, crop: Option<[f32; 4]>) -> Vec<Self> {
        let [x0, x1, y0, y1] = crop.unwrap_or([0.0, 1.0, 0.0, 1.0]);
        let pixel = |x: f32, n: u32| (x.clamp(0.0, 1.0) * n as f32).round() as u32;
        let low = [pixel(x0, size[0]), pixel(y0, size[1])];
        let high = [pixel(x1, size[0]), pixel(y1, size[1])];
        let grid = size.map(|s| s.div_ceil(edge));
        let mut jobs = Vec::new();
        for y in 0..grid[1] {
            for x in 0..grid[0] {
                let origin = [(x * edge).max(low[0]), (y * edge).max(low[1])];
                let end = [((x + 1) * edge).min(high[0]), ((y + 1) * edge).min(high[1])];
                if origin[0] < end[0] && origin[1] < end[1] {
                    let size = [end[0] - origin[0], end[1] - origin[1]];
                    jobs.push(Self { origin, size, bin: y * grid[0] + x });
                }
            }
        }
        jobs
    }
}

/// The tiles of an image and the buffers that they share.
pub struct Tiles<'a> {
    prepared: &'a Prepared<'a>,
    world: &'a World,
    plan: &'a SamplePlan,
    planes: u32,
    edge: u32,
    buffers: Vec<Buffer>,
    ids: wgpu::TextureView,
    depth: wgpu::TextureView,
    bins: Option<Bins>,
    cancel: Option<&'a AtomicBool>,
    /// Counts so far.
    pub stats: Stats,
}

/// Strands by tile.
struct Bins {
    starts: Vec<u32>,
    counts: Vec<u32>,
    list: Buffer,
}

/// What a tile came to.
struct Outcome {
    fragments: u64,
    capacity: u64,
    pixels: Vec<f32>,
    rays_lost: u64,
    longest: u64,
}

impl<'a> Tiles<'a> {
    /// Chooses the tile size from the memory that is left and allocates what tiles need.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if not even the smallest tile fits the budget.
    pub fn new(
        prepared: &'a Prepared<'a>,
        world: &'a World,
        plan: &'a SamplePlan,
        options: &RenderOptions<'a>,
    ) -> Result<Self> {
        let gpu = prepared.gpu;
        let scene = &world.scene;
        let planes = options.planes();
        let budget = scene.render.memory;
        let used = gpu.ledger.current();
        // A pixel is held twice while it is read back.
        let sample_bytes = SAMPLE_BYTES + (u64::from(planes) * 8).div_ceil(u64::from(plan.grid * plan.grid));
        let per_sample = sample_bytes + EXPECTED_FRAGMENTS * FRAGMENT_BYTES;
        // Bins, staging and pixels need some room too.
        let strands = match &prepared.resident {
            Some(_) => prepared.strands * 6,
            None => prepared.strand_budget.min(
                prepared.strands * crate::prepare::strand_bytes(prepared.segments) + prepared.strands * 20,
            ),
        };
        let reserve = strands + (8 << 20);
        let room = budget.saturating_sub(used + reserve);
        let smallest = u64::from(SMALLEST * plan.grid + 2 * plan.reach).pow(2) * per_sample;
        if room < smallest {
            return Err(Error::OutOfMemory { pass: "resolve".into(), needed: used + reserve + smallest });
        }
        let list_limit = gpu.binding_limit();
        let most = (room / per_sample)
            .min(list_limit / (4 + EXPECTED_FRAGMENTS * FRAGMENT_BYTES))
            .min(list_limit / 32);
        let most_edge = (most as f64).sqrt() as u32;
        let wanted = scene.render.tile.unwrap_or(2048).max(SMALLEST * plan.grid);
        let samples_edge = most_edge
            .min(wanted + 2 * plan.reach)
            .min(4096)
            .min(gpu.limits.max_texture_dimension_2d.saturating_sub(2 * RASTER_MARGIN as u32));
        let edge = (samples_edge.saturating_sub(2 * plan.reach) / plan.grid).max(SMALLEST);
        // No larger than the film.
        let edge = edge.min(scene.film.width.max(scene.film.height));
        let extent =
            [edge.min(scene.film.width), edge.min(scene.film.height)].map(|e| e * plan.grid + 2 * plan.reach);
        let samples = u64::from(extent[0]) * u64::from(extent[1]);
        let list_bytes =
            (room.saturating_sub(samples * (sample_bytes - 4))).min(list_limit).max(samples * 4 + 64);
        // More than a few hundred fragments a sample are never needed.
        let list_bytes = list_bytes.min(samples * (4 + 400 * FRAGMENT_BYTES));
        let buffers = vec![
            gpu.storage("base_records", 5, samples * 16)?,
            gpu.storage("fragment_lists", 6, list_bytes)?,
            gpu.storage("samples", 7, samples * 32)?,
            gpu.storage("lost_rays", 7, 16)?,
        ];
        let texture = |format, usage| {
            gpu.device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some("raster"),
                    size: wgpu::Extent3d { width: extent[0], height: extent[1], depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage,
                    view_formats: &[],
                })
                .create_view(&Default::default())
        };
        use wgpu::TextureUsages as U;
        let ids = texture(ID_FORMAT, U::RENDER_ATTACHMENT | U::TEXTURE_BINDING);
        let depth = texture(DEPTH_FORMAT, U::RENDER_ATTACHMENT);
        gpu.check("base_raster")?;
        Ok(Self {
            prepared,
            world,
            plan,
            planes,
            edge,
            buffers,
            ids,
            depth,
            bins: None,
            cancel: options.cancel,
            stats: Stats::default(),
        })
    }

    /// The tiles, row by row; only those that touch `crop` (x0 x1 y0 y1 in 0..1).
    pub fn jobs(&self, crop: Option<[f32; 4]>) -> Vec<Job> {
        let film = &self.world.scene.film;
        Job::grid([film.width, film.height], self.edge, crop)
    }

    fn grid(&self) -> [u32; 2] {
        let film = &self.world.scene.film;
        [film.width.div_ceil(self.edge), film.height.div_ceil(self.edge)]
    }

    fn frame(&self, pass: usize, origin: [i32; 2], size: [u32; 2]) -> Frame {
        let scene = &self.world.scene;
        let (jitter, lens) = self.plan.passes[pass];
        let mut frame =
            camera::frame(&scene.camera, self.plan.film, lens, jitter, scene.render.seed ^ pass as u32);
        frame.tile_origin = origin;
        frame.tile_size = size;
        frame
    }

    /// Sorts the resident strands into the tiles.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Gpu`].
    pub fn bin(&mut self, jobs: &[Job], timings: &mut Timings) -> Result<()> {
        let Some(strands) = self.prepared.resident.as_ref().filter(|s| s.count > 0 && !jobs.is_empty())
        else {
            return Ok(());
        };
        let gpu = self.prepared.gpu;
        let grid = self.grid();
        let bins = u64::from(grid[0]) * u64::from(grid[1]);
        // Displaced grids and lens points move strands by a little; the lens by its circle of confusion.
        let margin = self.plan.reach as f32 + 2.0 + self.blur_margin();
        let tile = self.edge * self.plan.grid;
        let tiles = gpu.uniform("tiles", &[0, 0, tile, tile, grid[0], grid[1], margin.to_bits(), 0])?;
        let frame = gpu.uniform("frame", &self.frame(0, [0, 0], self.plan.film))?;
        let counts = gpu.storage("bin_counts", 6, bins * 4)?;
        let starts = gpu.storage("bin_starts", 6, bins * 4)?;
        let scope = strands.scope(&self.prepared.scope()).with(&[&tiles, &frame, &counts, &starts]);
        let mut recorder = Recorder::new(gpu);
        self.prepared.passes.guard_bins.record_count(&mut recorder, &scope, strands.count)?;
        recorder.submit(timings)?;
        let found: Vec<u32> = gpu.read(&counts, bins * 4)?;
        let first: Vec<u32> = found
            .iter()
            .scan(0u32, |sum, c| {
                let first = *sum;
                *sum += c;
                Some(first)
            })
            .collect();
        let total: u64 = found.iter().map(|c| u64::from(*c)).sum();
        gpu.queue.write_buffer(&starts.raw, 0, bytemuck::cast_slice(&first));
        let list = gpu.storage("bins", 6, total * 4)?;
        let mut recorder = Recorder::new(gpu);
        recorder.clear(&counts, bins * 4);
        self.prepared.passes.guard_bins.record_fill(&mut recorder, &scope.with(&[&list]), strands.count)?;
        recorder.submit(timings)?;
        self.bins = Some(Bins { starts: first, counts: found, list });
        Ok(())
    }

    /// Samples by which the lens can displace what is nearest or farthest of the fur.
    fn blur_margin(&self) -> f32 {
        let camera = &self.world.scene.camera;
        let Some(lens) =
            camera.lens.as_ref().filter(|_| self.plan.passes.iter().any(|(_, l)| l.length() > 0.0))
        else {
            return 0.0;
        };
        let frame = self.frame(0, [0, 0], self.plan.film);
        let (low, high) = self.world.skin.bounds();
        let forward = glam::Vec3::from(frame.forward);
        let focus = lens
            .focus
            .unwrap_or((glam::Vec3::from(camera.target) - glam::Vec3::from(camera.eye)).length())
            .max(1e-3);
        let fur = self.world.scene.guard.length.max() + self.world.scene.undercoat.height.max();
        (0..8)
            .flat_map(|i| {
                let corner = glam::Vec3::new(
                    if i & 1 == 0 { low.x } else { high.x },
                    if i & 2 == 0 { low.y } else { high.y },
                    if i & 4 == 0 { low.z } else { high.z },
                );
                let z = (corner - glam::Vec3::from(camera.eye)).dot(forward);
                [z - fur, z + fur].map(|z| {
                    let z = z.max(frame.near);
                    (1.0 / z - 1.0 / focus).abs() * lens.aperture * 0.5 * frame.film_size[1] / frame.tan_y
                })
            })
            .fold(0.0, f32::max)
    }

    /// Renders a tile into `film`, in smaller parts where its fragments do not fit.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if the smallest part does not fit, [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn render(&mut self, job: &Job, film: &mut Film, timings: &mut Timings) -> Result<()> {
        let outcome = self.attempt(job, timings)?;
        self.stats.tiles += 1;
        if outcome.fragments <= outcome.capacity {
            self.stats.fragments += outcome.fragments;
            self.stats.rays_lost += outcome.rays_lost;
            self.stats.fragments_max = self.stats.fragments_max.max(outcome.longest);
            write_tile(job, &outcome.pixels, film);
            return Ok(());
        }
        self.stats.tiles_retried += 1;
        if job.size[0] <= SMALLEST && job.size[1] <= SMALLEST {
            return Err(Error::OutOfMemory {
                pass: "resolve".into(),
                needed: outcome.fragments * FRAGMENT_BYTES,
            });
        }
        let half = job.size.map(|s| s.div_ceil(2).max(1));
        for y in [0, half[1]] {
            for x in [0, half[0]] {
                if x < job.size[0] && y < job.size[1] {
                    let part = Job {
                        origin: [job.origin[0] + x, job.origin[1] + y],
                        size: [half[0].min(job.size[0] - x), half[1].min(job.size[1] - y)],
                        bin: job.bin,
                    };
                    self.render(&part, film, timings)?;
                }
            }
        }
        Ok(())
    }

    fn attempt(&self, job: &Job, timings: &mut Timings) -> Result<Outcome> {
        let gpu = self.prepared.gpu;
        let passes = &self.prepared.passes;
        let scene = &self.world.scene;
        let grid = self.plan.grid;
        let reach = self.plan.reach;
        let origin = [0, 1].map(|k| (job.origin[k] * grid) as i32 - reach as i32);
        let size = job.size.map(|s| s * grid + 2 * reach);
        let samples = u64::from(size[0]) * u64::from(size[1]);
        let count = u64::from(job.size[0]) * u64::from(job.size[1]);
        let lists = self.buffer("fragment_lists");
        let capacity = (lists.size / 4 - 1 - samples) / (FRAGMENT_BYTES / 4);
        let pixels = gpu.storage("pixels", 7, count * u64::from(self.planes) * 4)?;
        let targets = RasterTargets { ids: &self.ids, depth: &self.depth, size };
        let exact = marches_in_resolve(scene.render.blend);
        let (mut fragments, mut rays_lost, mut longest) = (0, 0, 0);
        for pass in 0..self.plan.passes.len() {
            if self.cancel.is_some_and(|c| c.load(Ordering::Relaxed)) {
                return Err(Error::Interrupted);
            }
            let mut frame = self.frame(pass, origin, size);
            frame.node_capacity = capacity.min(u64::from(u32::MAX >> 2)) as u32;
            let frame = gpu.uniform("frame", &frame)?;
            let reconstruction =
                gpu.uniform("reconstruction", &self.plan.reconstruction(scene, pass, job.size, self.planes))?;
            let scope = self
                .prepared
                .scope()
                .with(&self.buffers.iter().collect::<Vec<_>>())
                .with(&[&frame, &pixels, &reconstruction])
                .and("triangle_ids", Resource::Texture(&self.ids));
            let mut recorder = Recorder::new(gpu);
            recorder.clear(lists, (1 + samples) * 4);
            recorder.clear(self.buffer("lost_rays"), 16);
            passes.base_raster.record(&mut recorder, &scope, &targets, self.prepared.triangles)?;
            if groom::has_undercoat(scene) {
                passes.shell_entry.record(
                    &mut recorder,
                    &scope,
                    &targets,
                    self.prepared.triangles,
                    self.prepared.walls,
                )?;
                if !exact {
                    passes.undercoat_march.record(&mut recorder, &scope, samples)?;
                }
            }
            recorder.submit(timings)?;
            self.rasterise(job, &scope, timings)?;
            let mut recorder = Recorder::new(gpu);
            passes.resolve.record(&mut recorder, &scope, samples, exact)?;
            passes.film.record(&mut recorder, &scope, count)?;
            recorder.submit(timings)?;
            let written = u64::from(gpu.read::<u32>(lists, 4)?.first().copied().unwrap_or(0));
            fragments += written;
            if written > capacity {
                return Ok(Outcome { fragments: written, capacity, pixels: Vec::new(), rays_lost, longest });
            }
            let counts: Vec<u32> = gpu.read(self.buffer("lost_rays"), 8)?;
            rays_lost += u64::from(counts[0]);
            longest = longest.max(u64::from(counts[1]));
        }
        let data = gpu.read(&pixels, count * u64::from(self.planes) * 4)?;
        Ok(Outcome { fragments, capacity: u64::MAX, pixels: data, rays_lost, longest })
    }

    /// Step 6 for a tile: from the bins of the resident strands, or from strands grown for it.
    fn rasterise(&self, job: &Job, scope: &Scope<'_>, timings: &mut Timings) -> Result<()> {
        if let (Some(strands), Some(bins)) = (&self.prepared.resident, &self.bins) {
            let range = (bins.starts[job.bin as usize], bins.counts[job.bin as usize]);
            return self.rasterise_bin(strands, &bins.list, range, scope, timings);
        }
        let gpu = self.prepared.gpu;
        let guard = &self.world.scene.guard;
        let longest = 1.3 * guard.length.max()
            + 2.0 * (guard.curl.max() + guard.frizz.max())
            + guard.clump.max() / guard.clump_density.max(1e-6).sqrt();
        for batch in &self.prepared.batches {
            let roots = self.prepared.roots(batch, timings)?;
            let count = batch.strands as u32;
            let range = gpu.uniform("batch", &[count, 0, 0, 0])?;
            let tiles = gpu.uniform("tiles", &[0, 0, 1, 1, 1, 1, 4f32.to_bits(), longest.to_bits()])?;
            let counts = gpu.storage("bin_counts", 6, 16)?;
            let list = gpu.storage("bins", 6, u64::from(count) * 4)?;
            let mut picked = gpu.storage("tile_roots", 3, u64::from(count) * 16)?;
            let mut recorder = Recorder::new(gpu);
            let gather = scope.with(&[&roots, &range, &tiles, &counts, &list, &picked]);
            self.prepared.passes.guard_bins.record_gather(&mut recorder, &gather, count)?;
            recorder.submit(timings)?;
            drop(roots);
            let found = gpu.read::<u32>(&counts, 4)?.first().copied().unwrap_or(0);
            if found > 0 {
                picked.name = "roots";
                let strands = self.prepared.grow_from(picked, found, timings)?;
                self.prepared.shade(&strands, timings)?;
                self.rasterise_bin(&strands, &list, (0, found), scope, timings)?;
            }
        }
        Ok(())
    }

    fn rasterise_bin(
        &self,
        strands: &Strands,
        list: &Buffer,
        (start, count): (u32, u32),
        scope: &Scope<'_>,
        timings: &mut Timings,
    ) -> Result<()> {
        let gpu: &Gpu = self.prepared.gpu;
        let bin = gpu.uniform("bin", &[start, count, 0, 0])?;
        let scope = strands.scope(scope).with(&[&bin, list]);
        let mut recorder = Recorder::new(gpu);
        self.prepared.passes.guard_raster.record(&mut recorder, &scope, count, self.prepared.segments)?;
        recorder.submit(timings)
    }

    fn buffer(&self, name: &str) -> &Buffer {
        self.buffers.iter().find(|b| b.name == name).unwrap_or(&self.buffers[0])
    }
}

/// Copies a tile's planes into the film.
pub fn write_tile(job: &Job, pixels: &[f32], film: &mut Film) {
    let width = film.width as usize;
    let [w, h] = job.size.map(|s| s as usize);
    let [x0, y0] = job.origin.map(|s| s as usize);
    let plane = |p: usize| &pixels[p * w * h..(p + 1) * w * h];
    for (p, target) in film.planes.iter_mut().enumerate() {
        for y in 0..h {
            for x in 0..w {
                let i = y * w + x;
                target.data[(y0 + y) * width + x0 + x] = match target.name.as_str() {
                    "depth.Z" if plane(19)[i] > 1e-4 => plane(18)[i] / plane(19)[i],
                    "depth.Z" => f32::INFINITY,
                    _ => plane(p)[i],
                };
            }
        }
    }
}

/// Planes in the order in which the film pass writes them.
pub const PLANES: [(&str, bool); 19] = [
    ("R", false),
    ("G", false),
    ("B", false),
    ("A", false),
    ("guard.R", false),
    ("guard.G", false),
    ("guard.B", false),
    ("undercoat.R", false),
    ("undercoat.G", false),
    ("undercoat.B", false),
    ("base.R", false),
    ("base.G", false),
    ("base.B", false),
    ("N.X", true),
    ("N.Y", true),
    ("N.Z", true),
    ("transmittance.Y", true),
    ("fragments.Y", true),
    ("depth.Z", true),
];

/// A film with room for the planes that are kept.
pub fn blank_film(width: u32, height: u32, aovs: bool) -> Film {
    let mut film = Film { width, height, planes: Vec::new() };
    let kept = if aovs { PLANES.len() } else { 4 };
    for (name, full_precision) in &PLANES[..kept] {
        let data = vec![0.0; width as usize * height as usize];
        film.planes.push(pelage_core::film::Plane {
            name: (*name).into(),
            full_precision: *full_precision,
            data,
        });
    }
    film
}
