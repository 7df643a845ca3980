//! Rendering a [`World`] to a [`Film`]: tiles of samples within a memory budget.

mod plan;
mod tile;

pub use tile::FRAGMENT_BYTES;

use crate::gpu::recorder::Timings;
use crate::gpu::Gpu;
use crate::prepare::Prepared;
use crate::scene::Blend;
use crate::stats::{PassTime, Stats, Step};
use crate::{Result, World, camera, film::Film, passes};
use glam::Vec2;
use plan::SamplePlan;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a rendering needs beside the world.
#[derive(Default)]
pub struct RenderOptions<'a> {
    /// Part of the film that is rendered, x0 x1 y0 y1 in 0..1; the rest stays empty.
    pub crop: Option<[f32; 4]>,
    /// Keep all planes, not only `R G B A`.
    pub aovs: bool,
    /// Called after each chunk of work.
    pub progress: Option<&'a (dyn Fn(Progress) + Sync)>,
    /// When it becomes true, rendering stops after the current chunk and returns what there is.
    pub cancel: Option<&'a AtomicBool>,
}

/// How far a rendering is.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Part of the work that is done, 0..1.
    pub done: f32,
    /// What is going on, a pass stem.
    pub stage: &'static str,
}

/// A finished (or interrupted) rendering.
#[derive(Debug, Clone)]
pub struct Frame {
    /// The image: fur and skin over nothing, premultiplied.
    pub film: Film,
    /// Counts, times, bytes.
    pub stats: Stats,
    /// False if `cancel` ended it early.
    pub complete: bool,
}

impl RenderOptions<'_> {
    fn report(&self, done: f32, stage: &'static str) {
        if let Some(progress) = self.progress {
            progress(Progress { done, stage });
        }
    }

    fn cancelled(&self) -> bool {
        self.cancel.is_some_and(|c| c.load(Ordering::Relaxed))
    }
}

/// Renders `world` on the adapter chosen by the environment (WGPU_BACKEND, WGPU_ADAPTER_NAME, WGPU_POWER_PREF).
///
/// # Errors
/// [`crate::Error::Adapter`] without a sufficient adapter, [`crate::Error::OutOfMemory`] if even the smallest tile does not fit,
/// [`crate::Error::DeviceLost`], [`crate::Error::Gpu`].
pub fn render(world: &World, options: &RenderOptions<'_>) -> Result<Frame> {
    render_on(&Gpu::open()?, world, options)
}

/// Renders `world` on an open device.
///
/// # Errors
/// As [`render`].
pub fn render_on(gpu: &Gpu, world: &World, options: &RenderOptions<'_>) -> Result<Frame> {
    let started = std::time::Instant::now();
    let scene = &world.scene;
    let mut timings = Timings::default();
    let plan = SamplePlan::new(scene);
    options.report(0.0, "shell_prisms");
    let view = camera::frame(&scene.camera, plan.film, Vec2::ZERO, Vec2::ZERO, scene.render.seed);
    let prepared = Prepared::new(gpu, world, &view, &mut timings)?;
    let mut film = tile::blank_film(scene.film.width, scene.film.height, options.aovs);
    let mut tiles = tile::Tiles::new(&prepared, world, &plan, options.aovs)?;
    let jobs = tiles.jobs(options.crop);
    tiles.bin(&jobs, &mut timings)?;
    let total = jobs.len();
    let mut complete = true;
    for (done, job) in jobs.iter().enumerate() {
        if options.cancelled() {
            complete = false;
            break;
        }
        options.report(done as f32 / total as f32, "resolve");
        tiles.render(job, &mut film, &mut timings)?;
    }
    options.report(1.0, "film");
    let mut stats = tiles.stats;
    fill_stats(&mut stats, gpu, world, &prepared, &timings);
    stats.total_ms = started.elapsed().as_secs_f64() * 1e3;
    Ok(Frame { film, stats, complete })
}

fn fill_stats(stats: &mut Stats, gpu: &Gpu, world: &World, prepared: &Prepared<'_>, timings: &Timings) {
    let scene = &world.scene;
    stats.adapter = gpu.info.name.clone();
    stats.driver = format!("{} {}", gpu.info.driver, gpu.info.driver_info).trim().to_owned();
    stats.width = scene.film.width;
    stats.height = scene.film.height;
    stats.spp = scene.film.spp;
    stats.fur = format!("{:?}", scene.render.fur).to_lowercase();
    stats.blend = format!("{:?}", scene.render.blend).to_lowercase();
    stats.triangles = u64::from(prepared.triangles);
    stats.strands = prepared.strands;
    stats.subelements = prepared.subelements;
    stats.storage = if prepared.fur.storage == 1 { "stored".into() } else { "evaluated".into() };
    stats.memory_budget_bytes = scene.render.memory;
    stats.gpu_peak_bytes = gpu.ledger.peak();
    let mut steps: Vec<Step> = passes::STEP_NAMES
        .iter()
        .enumerate()
        .map(|(i, name)| Step {
            step: i as u32 + 1,
            name: (*name).into(),
            ms: gpu.timestamps.then_some(0.0),
            bytes: gpu.ledger.peak_of_step(i as u32 + 1),
        })
        .collect();
    for label in &timings.order {
        let (ms, dispatches) = timings.passes[label];
        let stem = label.split('.').next().unwrap_or(label);
        let step = &mut steps[passes::step_of(stem) as usize - 1];
        step.ms = step.ms.zip(ms).map(|(a, b)| a + b);
        stats.passes.push(PassTime { pass: label.clone(), ms, dispatches });
    }
    stats.steps = steps;
}

/// Whether the undercoat is marched while resolving.
pub(crate) fn marches_in_resolve(blend: Blend) -> bool {
    blend == Blend::Exact
}
