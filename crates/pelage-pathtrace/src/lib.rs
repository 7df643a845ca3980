//! The ground truth: the same fur with every hair a strand, path traced on the CPU.
//!
//! A world becomes [`Strands`], guard hairs and undercoat alike ([`grow`]); nothing of the prism
//! shell or the optical-depth lattice is used. [`geometry`] holds hairs and [`surfaces`]: each
//! segment of a hair is a truncated cone ([`curve`]), found through a hierarchy of boxes ([`bvh`]);
//! surfaces are the triangles of skin and objects, whose scattering is in [`surface`]. [`camera`]
//! makes rays, [`integrator`] follows them, [`light`] samples lights and sky, [`film`] keeps the
//! means, and [`resume`] reads them back.
//!
//! # Hairs
//!
//! Light meets a hair on its surface and leaves it from its axis, in the direction that its
//! [`pelage_fur::fibre::Fibre`] chooses for the offset across the hair at which it came. It cannot
//! meet the same hair before it has left it. The scattering is that of the whole cross section:
//! from where on the hair's girth light leaves is not followed, which matters only at distances of
//! a hair's width.
//!
//! # Surfaces
//!
//! The skin is opaque, and Lambertian on its outside. A path that meets it from the inside ends
//! there, black. Objects are opaque and have the material of [`pelage_fur::material`] on both
//! sides. Of a shadow catcher, only camera rays see anything: it blocks no light.
//!
//! # Randomness
//!
//! Every random number belongs to a pixel, a sample and a dimension. A pixel's samples are added in
//! order of their number. So an image depends neither on threads nor on passes, and a rendering
//! that was stopped can go on as if it had not been.

pub mod bvh;
pub mod camera;
mod catcher;
pub mod curve;
pub mod film;
pub mod geometry;
pub mod grow;
mod guard;
pub mod integrator;
pub mod light;
mod memory;
mod patch;
pub mod random;
pub mod resume;
mod segments;
pub mod strands;
pub mod surface;
pub mod surfaces;
mod undercoat;

pub use film::Accumulator;
pub use geometry::Geometry;
pub use integrator::{Integrator, Strategy, Tracer};
pub use light::{LightModel, Lights};
pub use resume::Identity;
pub use strands::Strands;

use pelage_core::assets::Assets;
use pelage_core::film::Film;
use pelage_core::{Error, Result, World};
use pelage_fur::Layer;
use pelage_fur::fibre::Fibre;
use rayon::prelude::*;
use std::{
    sync::atomic::{AtomicBool, AtomicU64, Ordering},
    time::Instant,
};

/// What a rendering needs besides the world.
#[derive(Debug, Clone)]
pub struct Options<'a> {
    /// How light is gathered.
    pub integrator: Integrator,
    /// Which lights there are. By default those of the renderer for [`Integrator::Single`], the map
    /// for [`Integrator::Path`].
    pub lights: Option<LightModel>,
    /// Which hairs grow.
    pub grow: grow::GrowOptions,
    /// Whether guard hairs, and whether undercoat, are traced.
    pub layers: [bool; 2],
    /// Largest number of scatterings of a path.
    pub depth: u32,
    /// Seed of the samples; the fur has the scene's seed.
    pub seed: u32,
    /// Stop at this many samples a pixel, rounded up to an even number.
    pub samples: Option<u32>,
    /// Stop after this time, s.
    pub time: Option<f64>,
    /// Stop where [`Accumulator::error`] is at most this.
    pub error: Option<f64>,
    /// Samples per pixel between two checks of the limits, rounded up to an even number; the image
    /// does not depend on it.
    pub pass: u32,
    /// Limit of the main memory, bytes.
    pub memory: u64,
    /// Where the environment's map is searched for.
    pub assets: Assets,
    /// Means to resume from.
    pub start: Option<Accumulator>,
    /// When it becomes true, the rendering stops and returns what is done.
    pub cancel: Option<&'a AtomicBool>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            integrator: Integrator::Path,
            lights: None,
            grow: grow::GrowOptions::default(),
            layers: [true; 2],
            depth: 256,
            seed: 0,
            samples: Some(64),
            time: None,
            error: None,
            pass: 4,
            memory: 8 << 30,
            assets: Assets::default(),
            start: None,
            cancel: None,
        }
    }
}

impl Options<'_> {
    /// The lights that are used.
    pub fn light_model(&self) -> LightModel {
        self.lights.unwrap_or(match self.integrator {
            Integrator::Single => LightModel::Scene,
            Integrator::Path => LightModel::Map,
        })
    }

    fn cancelled(&self) -> bool {
        self.cancel.is_some_and(|c| c.load(Ordering::Relaxed))
    }
}

/// Progress of a rendering.
#[derive(Debug, Clone, Copy)]
pub struct Progress<'a> {
    /// Share of the work that is done, 0..1, by the limit that will be reached first.
    pub done: f64,
    /// The means so far.
    pub means: &'a Accumulator,
    /// [`Accumulator::error`] of the means.
    pub error: f64,
    /// Since the start, s.
    pub seconds: f64,
}

/// A finished (or interrupted) rendering.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Fur, skin and objects without a background, premultiplied; see [`Accumulator::film`].
    pub film: Film,
    /// Samples per pixel.
    pub samples: u32,
    /// [`Accumulator::error`].
    pub error: f64,
    /// Duration of the tracing, s, without growing hairs and building hierarchies.
    pub seconds: f64,
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// False if `cancel` ended it.
    pub complete: bool,
}

/// Peak memory of tracing `layers` at the scene's size, bytes.
pub fn estimate(world: &World, layers: &[(Strands, Fibre)]) -> u64 {
    let hair: u64 = layers.iter().map(|(s, _)| memory::of_strands(s)).sum();
    let pixels = u64::from(world.scene.film.width) * u64::from(world.scene.film.height);
    // The means, their film, and the copy of it that is written.
    hair + surfaces::bytes_of(world) + pixels * (film::STATE.len() as u64 * 4 * 3 + 24)
}

impl Tracer {
    /// Prepares the tracing of `layers` of hairs, each with its scattering model, on the skin of
    /// `world`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if hairs and surfaces take more than `options.memory`, or as
    /// [`Geometry::new`]; [`Error::Scene`] if the environment's map is missing.
    pub fn new(world: &World, layers: Vec<(Strands, Fibre)>, options: &Options<'_>) -> Result<Self> {
        let needed = estimate(world, &layers);
        if needed > options.memory {
            let hairs: usize = layers.iter().map(|(s, _)| s.hairs.len()).sum();
            return Err(Error::Unsupported(format!(
                "found {hairs} hairs and {} triangles, which take about {:.1} GiB of main memory, expected at most {:.1} GiB: \
                 raise --memory, or trace a part of the fur with --patch",
                world.triangles(),
                memory::gib(needed),
                memory::gib(options.memory)
            )));
        }
        let geometry = Geometry::new(world, layers)?;
        let lights = Lights::of(world, &options.assets, options.light_model())?;
        Ok(Self {
            view: camera::View::new(&world.scene, geometry.bounds()),
            geometry,
            lights,
            integrator: options.integrator,
            strategy: Strategy::Both,
            depth: options.depth.max(1),
            seed: options.seed,
            width: world.scene.film.width,
        })
    }

    /// Adds samples to `means` until each pixel has `samples` of them. Returns the number of rays,
    /// or `None` if `cancel` stopped it: pixels then have different numbers of samples, and `means`
    /// is of no use.
    pub fn add(&self, means: &mut Accumulator, samples: u32, cancel: Option<&AtomicBool>) -> Option<u64> {
        /// Pixels that a thread takes at a time.
        const RUN: usize = 32;
        let rays = AtomicU64::new(0);
        let (width, from) = (means.width as usize, means.samples);
        let stopped = AtomicBool::new(false);
        means.pixels.par_chunks_mut(RUN).enumerate().for_each_init(
            || bvh::Stack::with_capacity(256),
            |stack, (run, pixels)| {
                if cancel.is_some_and(|c| c.load(Ordering::Relaxed)) {
                    stopped.store(true, Ordering::Relaxed);
                    return;
                }
                let mut traced = 0;
                for (i, pixel) in pixels.iter_mut().enumerate() {
                    let at = run * RUN + i;
                    for index in from..samples {
                        let sample = self.sample([(at % width) as u32, (at / width) as u32], index, stack);
                        traced += u64::from(sample.rays);
                        film::add(pixel, index, &sample);
                    }
                }
                rays.fetch_add(traced, Ordering::Relaxed);
            },
        );
        if stopped.into_inner() {
            return None;
        }
        means.samples = samples;
        Some(rays.into_inner())
    }
}

/// Traces `layers` of hairs on the skin of `world` until the samples, the time or the error of
/// `options` is reached. `on_progress` is called after each pass; an error that it returns ends the
/// rendering.
///
/// # Errors
/// As [`Tracer::new`]; [`Error::Usage`] if nothing limits the rendering or the means to resume from
/// have another size; [`Error::Interrupted`] if `cancel` stops it before the first pass is done;
/// those of `on_progress`.
pub fn render_layers(
    world: &World,
    layers: Vec<(Strands, Fibre)>,
    options: &Options<'_>,
    on_progress: &mut dyn FnMut(&Progress<'_>) -> Result<()>,
) -> Result<Outcome> {
    if options.samples.is_none() && options.time.is_none() && options.error.is_none() {
        return Err(Error::Usage(
            "found no limit of the rendering, expected one or more: give samples, a time or an error".into(),
        ));
    }
    let (width, height) = (world.scene.film.width, world.scene.film.height);
    let mut means = options.start.clone().unwrap_or_else(|| Accumulator::new(width, height));
    if (means.width, means.height) != (width, height) {
        return Err(Error::Usage(format!(
            "the image to resume from has {} x {} pixels, expected {width} x {height}: resume at the size of that image",
            means.width, means.height
        )));
    }
    let tracer = Tracer::new(world, layers, options)?;
    let even = |n: u32| n.max(1).saturating_add(n & 1).max(2);
    let most = options.samples.map_or(u32::MAX - 1, even);
    let (start, begin) = (Instant::now(), means.samples);
    let mut rays = 0;
    let mut complete = true;
    loop {
        let (seconds, error) = (start.elapsed().as_secs_f64(), means.error());
        let share = |limit: Option<f64>, now: f64| limit.map_or(0.0, |l| if l > 0.0 { now / l } else { 0.0 });
        let done = [
            options.samples.map_or(0.0, |_| f64::from(means.samples) / f64::from(most)),
            share(options.time, seconds),
            // The error falls as one over the number of samples; that of a few samples is
            // uncertain.
            options.error.map_or(0.0, |limit| (limit / error).min(f64::from(means.samples) / 8.0)),
        ]
        .into_iter()
        .fold(0.0, f64::max);
        if means.samples > begin {
            on_progress(&Progress { done: done.min(1.0), means: &means, error, seconds })?;
        }
        if means.samples > 0 && done >= 1.0 || means.samples >= most {
            break;
        }
        if options.cancelled() {
            complete = false;
            break;
        }
        // The first pass shows how long a sample takes, so that later ones do not end long after
        // the time.
        let done_here = means.samples - begin;
        let within = options.time.map_or(u32::MAX - 1, |time| {
            let each = seconds / f64::from(done_here.max(1));
            ((time - seconds) / each.max(1e-9)).clamp(1.0, 1e9) as u32
        });
        let wanted = if done_here == 0 { 2 } else { options.pass.max(means.samples / 128) };
        let pass = even(wanted.min(within));
        let target = means.samples.saturating_add(pass).min(most);
        let mut next = means.clone();
        match tracer.add(&mut next, target, options.cancel) {
            Some(traced) => {
                rays += traced;
                means = next;
            }
            None => {
                complete = false;
                break;
            }
        }
    }
    if means.samples == 0 {
        return Err(Error::Interrupted);
    }
    Ok(Outcome {
        film: means.film(),
        samples: means.samples,
        error: means.error(),
        seconds: start.elapsed().as_secs_f64(),
        rays,
        complete,
    })
}

/// The layers of hairs of `world` that are traced, with their scattering models. Their memory is
/// estimated before they grow.
///
/// # Errors
/// [`Error::Usage`] where they would take more than `options.memory`; as [`grow::grow`].
pub fn layers(world: &World, options: &Options<'_>) -> Result<Vec<(Strands, Fibre)>> {
    let mut estimated = grow::estimate(world, &options.grow)?;
    let hairs = estimated.guard_hairs + estimated.undercoat_hairs;
    estimated.bytes =
        memory::of_counts(hairs, estimated.segments, memory::EXPECTED_PARTS * estimated.segments);
    estimated.check(options.memory)?;
    let traced = |layer: Layer| options.layers[usize::from(layer == Layer::Undercoat)];
    let grown = grow::grow(world, &options.grow)?;
    let fibre = |layer: Layer| match layer {
        Layer::Guard => Fibre::guard(&world.scene),
        Layer::Undercoat => Fibre::undercoat(&world.scene),
    };
    Ok(grown
        .into_iter()
        .filter(|s| traced(s.layer))
        .map(|s| {
            let fibre = fibre(s.layer);
            (s, fibre)
        })
        .collect())
}

/// Grows the hairs of `world` and traces them: [`layers`] and [`render_layers`].
///
/// # Errors
/// As those two.
pub fn render(
    world: &World,
    options: &Options<'_>,
    on_progress: &mut dyn FnMut(&Progress<'_>) -> Result<()>,
) -> Result<Outcome> {
    render_layers(world, layers(world, options)?, options, on_progress)
}
