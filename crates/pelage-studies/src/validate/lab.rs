//! The surroundings of an experiment: scenes, the renderer, the path tracer, and the report's
//! folder.

use super::{Level, Options, Picture};
use crate::compare::{self, Comparison};
use crate::provenance::repository_path;
use crate::rendering::render_whole;
use pelage_core::assets::Assets;
use pelage_core::film::{Film, Metadata, io};
use pelage_core::scene::{FilmSpec, Tonemap};
use pelage_core::{Error, Result, Scene, World};
use pelage_gpu::Gpu;
use pelage_pathtrace::{self as pathtrace, LightModel};
use pelage_render::Frame;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Folder of the experiments' scenes.
const FOLDER: &str = "scenes/validate";

/// The surroundings of an experiment.
pub struct Lab<'a> {
    /// Extent of the validation.
    pub level: Level,
    gpu: &'a Gpu,
    out: &'a Path,
    cases: &'a [String],
    show: &'a (dyn Fn(f32) + Sync),
    cancel: &'a AtomicBool,
}

impl<'a> Lab<'a> {
    /// A lab on an open device. `show` is called with the part of the experiment that is done,
    /// 0..1.
    pub fn new(
        gpu: &'a Gpu,
        options: &'a Options,
        show: &'a (dyn Fn(f32) + Sync),
        cancel: &'a AtomicBool,
    ) -> Self {
        Self { level: options.level, gpu, out: &options.out, cases: &options.cases, show, cancel }
    }

    /// One of three values, by the level.
    pub fn choose<T>(&self, quick: T, usual: T, full: T) -> T {
        match self.level {
            Level::Quick => quick,
            Level::Usual => usual,
            Level::Full => full,
        }
    }

    /// Whether a case is selected.
    pub fn wants(&self, case: &str) -> bool {
        self.cases.is_empty() || self.cases.iter().any(|part| case.contains(part))
    }

    /// Reports that `done` of `all` steps are done.
    ///
    /// # Errors
    /// [`Error::Interrupted`] if the user has interrupted.
    pub fn step(&self, done: usize, all: usize) -> Result<()> {
        self.part(done as f32 / all.max(1) as f32)
    }

    fn part(&self, part: f32) -> Result<()> {
        (self.show)(part);
        if self.cancel.load(Ordering::Relaxed) { Err(Error::Interrupted) } else { Ok(()) }
    }

    /// Loads a scene of the experiments, with overrides.
    ///
    /// # Errors
    /// [`Error::Usage`] if the repository is not found; those of [`Scene::load`] and
    /// [`World::load`].
    pub fn world(&self, name: &str, overrides: &[String]) -> Result<(World, Assets)> {
        let path = repository_path(&format!("{FOLDER}/{name}.toml"))?;
        let (scene, assets) = Scene::load(&path, overrides)?;
        Ok((World::load(scene, &assets)?, assets))
    }

    /// Renders a world with all planes.
    ///
    /// # Errors
    /// Those of [`pelage_shells::render_on`]; [`Error::Interrupted`].
    pub fn render(&self, world: &World) -> Result<Frame> {
        render_whole(self.gpu, world, 0.0, self.cancel)
    }

    /// Path traces a world, with the renderer's lights unless `options` sets others. `[step, all]`
    /// is the number of this step of the experiment, and that of all steps.
    ///
    /// # Errors
    /// Those of [`pathtrace::render`]; [`Error::Interrupted`].
    pub fn trace(
        &self,
        world: &World,
        options: pathtrace::Options<'_>,
        [step, all]: [usize; 2],
    ) -> Result<pathtrace::Outcome> {
        let options = pathtrace::Options {
            lights: options.lights.or(Some(LightModel::Scene)),
            cancel: Some(self.cancel),
            ..options
        };
        let outcome = pathtrace::render(world, &options, &mut |progress| {
            self.part((step as f32 + progress.done as f32) / all.max(1) as f32)
        })?;
        if outcome.complete { Ok(outcome) } else { Err(Error::Interrupted) }
    }

    /// Writes an image at `exposure` stops without a tone curve, as the metrics of displayed images
    /// compare it.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn picture(&self, film: &Film, exposure: f32, name: &str, caption: &str) -> Result<Picture> {
        let file = format!("{}.png", crate::report::file_name(name));
        let spec = FilmSpec { tonemap: Tonemap::None, exposure, ..FilmSpec::default() };
        io::write(film, self.out.join(&file), &Metadata::of_program(), &spec)?;
        Ok(Picture { file, caption: caption.to_owned() })
    }
}

/// An approximation's image, and its differences from the ground truth.
pub(super) struct Approximation {
    pub(super) film: Film,
    /// Time taken, s.
    pub(super) seconds: f64,
    /// Number of guard hairs.
    pub(super) strands: u64,
    pub(super) compared: Comparison,
}

impl Approximation {
    /// Compares a frame with the ground truth, both at `exposure` stops.
    pub(super) fn new(frame: Frame, truth: &Film, exposure: f32) -> Result<Self> {
        let options = compare::Options { exposure: f64::from(exposure), ..compare::Options::default() };
        Ok(Self {
            compared: compare::compare_with(&frame.film, truth, &options)?,
            seconds: frame.stats.total_ms / 1e3,
            strands: frame.stats.strands,
            film: frame.film,
        })
    }
}
