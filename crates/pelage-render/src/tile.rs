//! Steps 4 to 7, tile by tile. A tile whose fragments do not fit the lists is split into four and
//! rendered again; nothing is dropped.

mod bins;
mod size;

use crate::job::Job;
use crate::options::RenderOptions;
use crate::plan::SamplePlan;
use crate::planes::{self, write_tile};
use crate::prepare::Prepared;
use crate::tile_buffers::{COUNTER_BYTES, MarchCounts, TileBuffers, fragment_bytes};
use bins::{Bins, StrandRaster};
use pelage_core::film::Film;
use pelage_core::scene::Blend;
use pelage_core::stats::Stats;
use pelage_core::{Error, Result, World};
use pelage_fur::camera::FLAG_SORTED_LISTS;
use pelage_fur::groom;
use pelage_fur::layout::{Frame, Reconstruction};
use pelage_gpu::recorder::Timings;
use pelage_gpu::{Recorder, Resource};
use size::TileSize;
use std::sync::atomic::{AtomicBool, Ordering};

/// Smallest edge of a tile, pixels. If the fragments of such a tile do not fit, rendering fails.
const SMALLEST: u32 = 4;

/// The tiles of an image and the buffers that they share.
pub struct Tiles<'a> {
    prepared: &'a Prepared<'a>,
    world: &'a World,
    plan: &'a SamplePlan,
    planes: u32,
    /// Objects whose coverage is kept in further planes, with that of the skin.
    objects: u32,
    edge: u32,
    buffers: TileBuffers,
    bins: Option<Bins>,
    cancel: Option<&'a AtomicBool>,
    /// Counts so far.
    pub stats: Stats,
}

/// Result of rendering a tile. Fragments beyond the capacity were not stored, and the pixels are
/// then missing.
struct Outcome {
    fragments: u64,
    capacity: u64,
    pixels: Vec<f32>,
    counts: MarchCounts,
}

impl<'a> Tiles<'a> {
    /// Chooses the tile size from the remaining memory and allocates the buffers.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if not even the smallest tile fits the budget.
    pub fn new(
        prepared: &'a Prepared<'a>,
        world: &'a World,
        plan: &'a SamplePlan,
        options: &RenderOptions<'a>,
    ) -> Result<Self> {
        let planes = planes::written(options, world.scene.render.fur);
        let objects = planes::objects(options, world);
        let size = TileSize::choose(prepared, world, plan, planes + planes::of_objects(objects), options)?;
        let buffers =
            TileBuffers::new(prepared.gpu, size.extent, size.list_bytes, prepared.variant.features)?;
        Ok(Self {
            prepared,
            world,
            plan,
            planes,
            objects,
            edge: size.edge,
            buffers,
            bins: None,
            cancel: options.cancel,
            stats: Stats::default(),
        })
    }

    /// The tiles, row by row, cut to `crop` (x0 x1 y0 y1 in 0..1).
    pub fn jobs(&self, crop: Option<[f32; 4]>) -> Vec<Job> {
        let film = &self.world.scene.film;
        Job::grid([film.width, film.height], self.edge, crop)
    }

    /// Sorts the resident strands into bins, one per tile.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Gpu`].
    pub fn bin(&mut self, jobs: &[Job], timings: &mut Timings) -> Result<()> {
        if !jobs.is_empty() {
            self.bins = Bins::sort(self.prepared, self.world, self.plan, self.edge, timings)?;
        }
        Ok(())
    }

    fn frame(&self, pass: usize, origin: [i32; 2], size: [u32; 2]) -> Frame {
        let mut frame = self.plan.frame(&self.world.scene, pass);
        frame.seed ^= pass as u32;
        frame.tile_origin = origin;
        frame.tile_size = size;
        frame
    }

    /// Renders a tile into `film`, in smaller parts if its fragments do not fit the lists.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if the smallest part does not fit, [`Error::Interrupted`] if
    /// cancelled, [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn render(&mut self, job: &Job, film: &mut Film, timings: &mut Timings) -> Result<()> {
        let outcome = self.attempt(job, timings)?;
        self.stats.tiles += 1;
        if outcome.fragments <= outcome.capacity {
            self.stats.fragments += outcome.fragments;
            let counts = outcome.counts;
            self.stats.rays_lost += counts.rays_lost;
            self.stats.rays_cut += counts.rays_cut + counts.marches_cut;
            self.stats.light_paths_cut += counts.light_paths_cut;
            self.stats.fragments_unread += counts.unread + outcome.fragments.saturating_sub(counts.listed);
            self.stats.fragments_max = self.stats.fragments_max.max(counts.longest);
            write_tile(job, &outcome.pixels, film);
            return Ok(());
        }
        self.stats.tiles_retried += 1;
        if job.size[0] <= SMALLEST && job.size[1] <= SMALLEST {
            return Err(Error::OutOfMemory {
                pass: "resolve".into(),
                needed: outcome.fragments * fragment_bytes(self.prepared.variant.features),
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

    /// Renders a tile once, all passes over the image.
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
        let lists = self.buffers.buffer("fragment_lists")?;
        let counters = self.buffers.buffer("march_counters")?;
        let capacity = self.buffers.capacity(samples)?;
        let bytes = count * u64::from(self.planes + planes::of_objects(self.objects)) * 4;
        let pixels = gpu.storage("pixels", 7, bytes)?;
        let targets = self.buffers.targets(size);
        let exact = scene.render.blend == Blend::Exact;
        let (mut fragments, mut counts) = (0, MarchCounts::default());
        for pass in 0..self.plan.passes.len() {
            if self.cancel.is_some_and(|c| c.load(Ordering::Relaxed)) {
                return Err(Error::Interrupted);
            }
            let mut frame = self.frame(pass, origin, size);
            frame.node_capacity = capacity.min(u64::from(u32::MAX >> 2)) as u32;
            let sorted = Frame { flags: frame.flags | FLAG_SORTED_LISTS, ..frame };
            let frame = gpu.uniform("frame", &frame)?;
            let reconstruction = Reconstruction {
                objects: self.objects,
                ..self.plan.reconstruction(scene, pass, job.size, self.planes)
            };
            let reconstruction = gpu.uniform("reconstruction", &reconstruction)?;
            let scope = self.buffers.add_to(&self.prepared.scope()).with(&[&frame, &pixels, &reconstruction]);
            let mut recorder = Recorder::new(gpu);
            recorder.clear(lists, (1 + samples) * 4);
            recorder.clear(counters, COUNTER_BYTES);
            self.prepared.record_base(&mut recorder, &scope, &targets)?;
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
            let strands =
                StrandRaster { prepared: self.prepared, world: self.world, bins: self.bins.as_ref() };
            strands.draw(job.bin, &scope, timings)?;
            let mut recorder = Recorder::new(gpu);
            passes.resolve.record(&mut recorder, &scope, samples, exact)?;
            recorder.submit(timings)?;
            let written = u64::from(gpu.read::<u32>(lists, 4)?.first().copied().unwrap_or(0));
            fragments += written;
            if written > capacity {
                return Ok(Outcome { fragments: written, capacity, pixels: Vec::new(), counts });
            }
            let mut counted = self.buffers.counts(gpu)?;
            if counted.unread > 0 || counted.listed < written {
                // The adapter ended the loops that read long lists: read them sorted.
                let sorted = gpu.uniform("frame", &sorted)?;
                let scope = scope.with(&[&sorted]).and("lists_to_sort", Resource::Buffer(&lists.raw));
                let mut recorder = Recorder::new(gpu);
                let _runs =
                    passes.resolve.record_sort(gpu, &mut recorder, &scope, samples, counted.longest)?;
                recorder.clear(counters, COUNTER_BYTES);
                if self.prepared.variant.features {
                    // `resolve` has overwritten the albedo of skin and objects in `samples`.
                    self.prepared.record_base(&mut recorder, &scope, &targets)?;
                }
                passes.resolve.record(&mut recorder, &scope, samples, exact)?;
                recorder.submit(timings)?;
                counted = counted.resolved_again(self.buffers.counts(gpu)?);
            }
            counts = counts.plus(counted);
            let mut recorder = Recorder::new(gpu);
            passes.film.record(&mut recorder, &scope, count)?;
            passes.film.record_objects(&mut recorder, &scope, count, self.objects)?;
            recorder.submit(timings)?;
        }
        let data = gpu.read(&pixels, bytes)?;
        Ok(Outcome { fragments, capacity: u64::MAX, pixels: data, counts })
    }
}
