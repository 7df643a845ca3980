//! Pictures of shells and fins: converts the rasterised image to samples of the film, tile by tile.

use super::{Pose, Rows, Shellfins};
use glam::Vec2;
use pelage_core::film::Film;
use pelage_core::stats::Stats;
use pelage_core::{Error, Result, World};
use pelage_fur::camera;
use pelage_fur::layout::Frame;
use pelage_gpu::kernel::{COLOR_FORMAT, DEPTH_FORMAT};
use pelage_gpu::recorder::{RASTER_MARGIN, RasterTargets, Timings};
use pelage_gpu::{Buffer, Gpu, Recorder, Resource};
use pelage_render::planes::written;
use pelage_render::{Job, RenderOptions, Rendering, SamplePlan, known_stats, write_tile};

/// Bytes of a sample: colour, depth, film sample.
const SAMPLE_BYTES: u64 = 8 + 4 + 32;

/// Colour and depth targets of a fixed size.
pub struct Pictures {
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
    size: [u32; 2],
}

impl Pictures {
    /// Creates targets for `size` samples.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Gpu`].
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self> {
        use wgpu::TextureUsages as U;
        let texture = |format| {
            gpu.device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some("picture"),
                    size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: U::RENDER_ATTACHMENT | U::TEXTURE_BINDING,
                    view_formats: &[],
                })
                .create_view(&Default::default())
        };
        let pictures = Self { color: texture(COLOR_FORMAT), depth: texture(DEPTH_FORMAT), size };
        gpu.check("shellfin_raster")?;
        Ok(pictures)
    }

    /// The views of colour and depth.
    pub fn views(&self) -> [&wgpu::TextureView; 2] {
        [&self.color, &self.depth]
    }

    /// The targets of raster passes, limited to the first `size` samples.
    pub fn targets(&self, size: [u32; 2]) -> RasterTargets<'_> {
        let size = [size[0].min(self.size[0]), size[1].min(self.size[1])];
        RasterTargets { ids: &self.color, depth: &self.depth, size }
    }
}

/// Renders shells and fins: the [`Run`](pelage_render::driver::Run) of `render.fur = "shells"`.
///
/// # Errors
/// As [`crate::render::render`], and those of [`super::textures`] and [`Shellfins::new`].
pub fn run(rendering: &mut Rendering, gpu: &Gpu, world: &World, options: &RenderOptions<'_>) -> Result<bool> {
    let Rendering { film, done, timings, .. } = &mut *rendering;
    let complete = render_tiles(gpu, world, options, film, done, timings)?;
    rendering.stats = Stats {
        triangles: world.skin.triangles.len() as u64,
        tiles: rendering.done as u64,
        ..known_stats(gpu, &world.scene)
    };
    options.report(1.0, "film");
    rendering.finish_stats(gpu);
    Ok(complete)
}

/// Renders the remaining tiles of a film, starting with `*done`, which it increments. Returns false
/// if cancelled.
fn render_tiles(
    gpu: &Gpu,
    world: &World,
    options: &RenderOptions<'_>,
    film: &mut Film,
    done: &mut usize,
    timings: &mut Timings,
) -> Result<bool> {
    let scene = &world.scene;
    let plan = SamplePlan::new(scene);
    options.report(0.0, "bake");
    let textures = super::textures(world)?;
    options.report(0.1, "shellfin_rows");
    let view = camera::frame(&scene.camera, plan.film, Vec2::ZERO, Vec2::ZERO, scene.render.seed);
    let fur = Shellfins::new(gpu, world, &textures, &view, timings)?;
    let planes = written(options, scene.render.fur);
    let jobs = jobs(gpu, world, &plan, planes, options)?;
    let largest = jobs.iter().fold([1, 1], |most, j| [0, 1].map(|k| j.size[k].max(most[k])));
    let pictures = Pictures::new(gpu, largest.map(|s| s * plan.grid + 2 * plan.reach))?;
    let pose = Pose::at(world, options.time, fur.height());
    let lens = plan.passes.iter().any(|(_, lens)| *lens != Vec2::ZERO);
    let mut rows = fur.rows(&view, &pose, timings)?;
    let count = jobs.len();
    while let Some(job) = jobs.get(*done) {
        if options.cancelled() {
            return Ok(false);
        }
        options.report(0.2 + 0.8 * *done as f32 / count as f32, "shellfin_raster");
        let tile = Tile { gpu, world, plan: &plan, planes, job };
        let mut render = || -> Result<Vec<f32>> {
            let pixels = gpu.storage("pixels", 7, tile.pixels() * u64::from(planes) * 4)?;
            for pass in 0..plan.passes.len() {
                let frame = tile.frame(pass);
                if lens {
                    rows = fur.rows(&frame, &pose, timings)?;
                }
                tile.render(pass, &frame, &fur, &rows, &pictures, &pixels, timings)?;
            }
            gpu.read(&pixels, tile.pixels() * u64::from(planes) * 4)
        };
        let data = match render() {
            // An interrupted tile is left out.
            Err(Error::Interrupted) => return Ok(false),
            outcome => outcome?,
        };
        write_tile(job, &data, film);
        *done += 1;
        options.show(film);
    }
    Ok(true)
}

/// Tiles that fit the memory budget and the adapter's texture size.
fn jobs(
    gpu: &Gpu,
    world: &World,
    plan: &SamplePlan,
    planes: u32,
    options: &RenderOptions<'_>,
) -> Result<Vec<Job>> {
    let film = &world.scene.film;
    let per_sample = SAMPLE_BYTES + u64::from(planes) * 8;
    let used = gpu.ledger.current();
    let room = world.scene.render.memory.saturating_sub(used + (4 << 20)).min(gpu.binding_limit());
    let side = ((room / per_sample) as f64).sqrt() as u32;
    let widest = gpu.limits.max_texture_dimension_2d.saturating_sub(2 * RASTER_MARGIN as u32);
    let edge = side.min(widest).saturating_sub(2 * plan.reach) / plan.grid;
    let usual = if options.partial.is_some() { options.usual_tile(plan.reach) / plan.grid } else { 2048 };
    let wanted = world.scene.render.tile.map_or(usual, |t| (t / plan.grid).max(4));
    if edge < 4 {
        let needed = used + per_sample * u64::from(4 * plan.grid + 2 * plan.reach).pow(2);
        return Err(Error::OutOfMemory { pass: "shellfin_raster".into(), needed });
    }
    Ok(Job::grid([film.width, film.height], edge.min(wanted), options.crop))
}

/// The tile that is being rendered.
struct Tile<'a> {
    gpu: &'a Gpu,
    world: &'a World,
    plan: &'a SamplePlan,
    planes: u32,
    job: &'a Job,
}

impl Tile<'_> {
    fn pixels(&self) -> u64 {
        u64::from(self.job.size[0]) * u64::from(self.job.size[1])
    }

    fn frame(&self, pass: usize) -> Frame {
        let scene = &self.world.scene;
        let (jitter, lens) = self.plan.passes[pass];
        let (grid, reach) = (self.plan.grid, self.plan.reach);
        let mut frame = camera::frame(&scene.camera, self.plan.film, lens, jitter, scene.render.seed);
        frame.tile_origin = [0, 1].map(|k| (self.job.origin[k] * grid) as i32 - reach as i32);
        frame.tile_size = self.job.size.map(|s| s * grid + 2 * reach);
        frame
    }

    #[allow(clippy::too_many_arguments)] // Each is a different input of the pass.
    fn render(
        &self,
        pass: usize,
        frame: &Frame,
        fur: &Shellfins<'_>,
        rows: &Rows,
        pictures: &Pictures,
        pixels: &Buffer,
        timings: &mut Timings,
    ) -> Result<()> {
        let gpu = self.gpu;
        let size = frame.tile_size;
        let samples = u64::from(size[0]) * u64::from(size[1]);
        let reconstruction = gpu.uniform(
            "reconstruction",
            &self.plan.reconstruction(&self.world.scene, pass, self.job.size, self.planes),
        )?;
        let frame = gpu.uniform("frame", frame)?;
        let buffer = gpu.storage("samples", 7, samples * 32)?;
        fur.draw(&frame, rows, &pictures.targets(size), timings)?;
        let scope = fur
            .scope()
            .with(&[&frame, &buffer, pixels, &reconstruction])
            .and("color_target", Resource::Texture(&pictures.color))
            .and("depth_target", Resource::Texture(&pictures.depth));
        let mut recorder = Recorder::new(gpu);
        fur.pass_raster.record_samples(&mut recorder, &scope, samples)?;
        fur.prepared.passes.film.record(&mut recorder, &scope, self.pixels())?;
        recorder.submit(timings)
    }
}
