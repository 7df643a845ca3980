//! What experiments work with: scenes, the renderer, the path tracer, the report's folder.

use super::{Level, Options, Picture};
use crate::provenance::repository_path;
use pelage_core::assets::Assets;
use pelage_core::film::{Film, Metadata, io};
use pelage_core::scene::{FilmSpec, Tonemap};
use pelage_core::{Error, Result, Scene, World};
use pelage_gpu::Gpu;
use pelage_pathtrace as pathtrace;
use pelage_pathtrace::LightModel;
use pelage_render::{Frame, RenderOptions};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Scenes of the experiments.
const FOLDER: &str = "scenes/validate";

/// The place of an experiment.
pub struct Lab<'a> {
    /// How much is measured.
    pub level: Level,
    gpu: &'a Gpu,
    out: &'a Path,
    cases: &'a [String],
    show: &'a (dyn Fn(f32) + Sync),
    cancel: &'a AtomicBool,
}

impl<'a> Lab<'a> {
    /// On an open device. `show` is told what part of the experiment is done.
    pub fn new(
        gpu: &'a Gpu,
        options: &'a Options,
        show: &'a (dyn Fn(f32) + Sync),
        cancel: &'a AtomicBool,
    ) -> Self {
        Self { level: options.level, gpu, out: &options.out, cases: &options.cases, show, cancel }
    }

    /// One of three values by the level.
    pub fn choose<T>(&self, quick: T, usual: T, full: T) -> T {
        match self.level {
            Level::Quick => quick,
            Level::Usual => usual,
            Level::Full => full,
        }
    }

    /// Whether a case is asked for.
    pub fn wants(&self, case: &str) -> bool {
        self.cases.is_empty() || self.cases.iter().any(|part| case.contains(part))
    }

    /// Says that `done` of `all` steps are done.
    ///
    /// # Errors
    /// [`Error::Interrupted`] if the user wants an end.
    pub fn step(&self, done: usize, all: usize) -> Result<()> {
        self.part(done as f32 / all.max(1) as f32)
    }

    fn part(&self, part: f32) -> Result<()> {
        (self.show)(part);
        if self.cancel.load(Ordering::Relaxed) { Err(Error::Interrupted) } else { Ok(()) }
    }

    /// A scene of the experiments with overrides.
    ///
    /// # Errors
    /// [`Error::Usage`] where the repository is not found, those of [`Scene::load`] and [`World::load`].
    pub fn world(&self, name: &str, overrides: &[String]) -> Result<(World, Assets)> {
        let path = repository_path(&format!("{FOLDER}/{name}.toml"))?;
        let (scene, assets) = Scene::load(&path, overrides)?;
        Ok((World::load(scene, &assets)?, assets))
    }

    /// The renderer's image.
    ///
    /// # Errors
    /// Those of [`render::render_on`]; [`Error::Interrupted`].
    pub fn render(&self, world: &World) -> Result<Frame> {
        let options = RenderOptions { aovs: true, cancel: Some(self.cancel), ..RenderOptions::default() };
        let frame = pelage_shells::render_on(self.gpu, world, &options)?;
        match frame.fault {
            Some(fault) => Err(fault),
            None if frame.complete => Ok(frame),
            None => Err(Error::Interrupted),
        }
    }

    /// The path tracer's image with the renderer's lights, unless `options` says otherwise. `steps` says which of how many steps of
    /// the experiment this is.
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

    /// Writes a picture of linear light at `exposure` stops, without a tone curve: what the metrics of displayed images see.
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
