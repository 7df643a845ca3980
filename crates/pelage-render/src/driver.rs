//! Renders a [`World`] to a [`Film`]; keeps the finished tiles when the device is lost, and
//! continues on a new one.

use crate::options::RenderOptions;
use crate::passes;
use crate::plan::SamplePlan;
use crate::prepare::Prepared;
use crate::{planes, tile};
use glam::Vec2;
use pelage_core::film::Film;
use pelage_core::stats::{PassTime, Stats, Step};
use pelage_core::{Error, Result, Scene, World};
use pelage_fur::camera;
use pelage_gpu::Gpu;
use pelage_gpu::recorder::Timings;
use std::time::Instant;

/// A finished (or interrupted) rendering.
#[derive(Debug, Clone)]
pub struct Frame {
    /// The image without background, premultiplied.
    pub film: Film,
    /// Counts, times and bytes.
    pub stats: Stats,
    /// False if `cancel` or a `fault` ended it early; unfinished tiles are empty.
    pub complete: bool,
    /// The loss of the device that ended the rendering; the film holds the tiles finished before
    /// it.
    pub fault: Option<Error>,
}

/// A rendering in progress: what survives the loss of a device.
pub struct Rendering {
    started: Instant,
    /// The film with the tiles finished so far.
    pub film: Film,
    /// Times of the passes so far.
    pub timings: Timings,
    /// Counts so far.
    pub stats: Stats,
    /// Number of tiles finished.
    pub done: usize,
    /// Number of tiles; 0 before the first device has chosen it. A second device with the same
    /// limits chooses the same.
    total: usize,
}

/// Renders the tiles that are not finished yet; returns false if it was cancelled.
pub type Run = dyn Fn(&mut Rendering, &Gpu, &World, &RenderOptions<'_>) -> Result<bool>;

/// Renders `world` by `run` on a device that `open` opens.
///
/// If the device is lost, it is opened once more and rendering continues with the tile that was
/// lost. If that fails too, the frame holds the finished tiles and the fault.
///
/// # Errors
/// [`Error::DeviceLost`] before the first tile is finished, and those of `open` and `run`.
pub fn drive(
    open: &dyn Fn() -> Result<Gpu>,
    world: &World,
    options: &RenderOptions<'_>,
    run: &Run,
) -> Result<Frame> {
    let mut rendering = Rendering::new(world, options);
    let gpu = open()?;
    let mut outcome = run(&mut rendering, &gpu, world, options);
    close(gpu, options);
    if let Err(Error::DeviceLost { during, reason }) = &outcome {
        tracing::warn!("the GPU device was lost during {during} ({reason}); opening it again");
        // If it does not open, the first loss is reported.
        if let Ok(gpu) = open() {
            outcome = run(&mut rendering, &gpu, world, options);
            close(gpu, options);
        }
    }
    rendering.end(outcome)
}

/// Closes a device, which waits for its work. After an interrupt that would take as long as the
/// work: the device is then left open until the process ends.
fn close(gpu: Gpu, options: &RenderOptions<'_>) {
    if options.cancelled() {
        std::mem::forget(gpu);
    }
}

/// Renders `world` by `run` on an open device; if that is lost, the frame holds the finished tiles
/// and the fault.
///
/// # Errors
/// As [`drive`].
pub fn drive_on(gpu: &Gpu, world: &World, options: &RenderOptions<'_>, run: &Run) -> Result<Frame> {
    let mut rendering = Rendering::new(world, options);
    let outcome = run(&mut rendering, gpu, world, options);
    rendering.end(outcome)
}

/// Renders hybrid fur: the [`Run`] for every `render.fur` except `shells`.
///
/// # Errors
/// [`Error::OutOfMemory`] if even the smallest tile does not fit, [`Error::DeviceLost`],
/// [`Error::Gpu`].
pub fn run(rendering: &mut Rendering, gpu: &Gpu, world: &World, options: &RenderOptions<'_>) -> Result<bool> {
    rendering.run_hybrid(gpu, world, options)
}

impl Rendering {
    fn new(world: &World, options: &RenderOptions<'_>) -> Self {
        Self {
            started: Instant::now(),
            film: planes::blank_film(options, world),
            timings: Timings::default(),
            stats: Stats::default(),
            done: 0,
            total: 0,
        }
    }

    fn run_hybrid(&mut self, gpu: &Gpu, world: &World, options: &RenderOptions<'_>) -> Result<bool> {
        let scene = &world.scene;
        let plan = SamplePlan::new(scene);
        options.report(0.0, "shell_prisms");
        let view = camera::frame(&scene.camera, plan.film, Vec2::ZERO, Vec2::ZERO, scene.render.seed);
        let prepared = Prepared::with_features(gpu, world, &view, options.features, &mut self.timings)?;
        let mut tiles = tile::Tiles::new(&prepared, world, &plan, options)?;
        let jobs = tiles.jobs(options.crop);
        tiles.bin(&jobs, &mut self.timings)?;
        if self.total != jobs.len() {
            // The first device, or one with other limits: start over.
            (self.done, self.total, self.stats) = (0, jobs.len(), first_stats(gpu, scene, &prepared));
        }
        tiles.stats = self.stats.clone();
        let mut complete = true;
        while let Some(job) = jobs.get(self.done) {
            if options.cancelled() {
                complete = false;
                break;
            }
            options.report(self.done as f32 / self.total as f32, "resolve");
            match tiles.render(job, &mut self.film, &mut self.timings) {
                // A tile interrupted between its passes over the image is left out.
                Err(Error::Interrupted) => {
                    complete = false;
                    break;
                }
                outcome => outcome?,
            }
            self.done += 1;
            self.stats = tiles.stats.clone();
            options.show(&self.film);
        }
        options.report(1.0, "film");
        self.finish_stats(gpu);
        Ok(complete)
    }

    /// Adds the times and bytes measured on the device to the statistics.
    pub fn finish_stats(&mut self, gpu: &Gpu) {
        fill_stats(&mut self.stats, gpu, &self.timings);
    }

    /// The frame of a finished, cancelled or failed rendering. A lost device is an error only if no
    /// tile was finished.
    fn end(mut self, outcome: Result<bool>) -> Result<Frame> {
        let (complete, fault) = match outcome {
            Ok(complete) => (complete, None),
            Err(fault @ Error::DeviceLost { .. }) if self.done > 0 => (false, Some(fault)),
            Err(other) => return Err(other),
        };
        self.stats.total_ms = self.started.elapsed().as_secs_f64() * 1e3;
        Ok(Frame { film: self.film, stats: self.stats, complete, fault })
    }
}

/// Statistics known before the first tile.
fn first_stats(gpu: &Gpu, scene: &Scene, prepared: &Prepared<'_>) -> Stats {
    Stats {
        triangles: u64::from(prepared.triangles) + u64::from(prepared.object_triangles()),
        strands: prepared.strands,
        subelements: prepared.subelements,
        light_paths_cut: prepared.light_paths_cut,
        storage: if prepared.variant.stored { "stored".into() } else { "evaluated".into() },
        ..known_stats(gpu, scene)
    }
}

/// Statistics that follow from the device and the scene alone.
pub fn known_stats(gpu: &Gpu, scene: &Scene) -> Stats {
    Stats {
        adapter: gpu.info.name.clone(),
        driver: format!("{} {}", gpu.info.driver, gpu.info.driver_info).trim().to_owned(),
        width: scene.film.width,
        height: scene.film.height,
        spp: scene.film.spp,
        fur: format!("{:?}", scene.render.fur).to_lowercase(),
        blend: format!("{:?}", scene.render.blend).to_lowercase(),
        memory_budget_bytes: scene.render.memory,
        ..Stats::default()
    }
}

/// Adds times and peak bytes, by pass and by row of the paper's Table 1.
fn fill_stats(stats: &mut Stats, gpu: &Gpu, timings: &Timings) {
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
