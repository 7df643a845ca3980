//! Options of a rendering, and the reports of its progress.

use pelage_core::film::Film;
use std::sync::atomic::{AtomicBool, Ordering};

/// Options of a rendering that are not part of the scene.
#[derive(Default)]
pub struct RenderOptions<'a> {
    /// Part of the film to render, x0 x1 y0 y1 in 0..1; the rest stays empty. `None`: all of it.
    pub crop: Option<[f32; 4]>,
    /// Whether the film keeps the parts of the colour, transmittance, fragments and depth, not only
    /// `R G B A`.
    pub aovs: bool,
    /// Whether the film keeps all of [`crate::planes::PLANES`], those for denoising and for mattes
    /// included; implies `aovs`. Takes more memory per fragment, so that tiles are smaller.
    pub features: bool,
    /// Called at the start, before each tile, and at the end.
    pub progress: Option<&'a (dyn Fn(Progress) + Sync)>,
    /// Called after each tile with the film so far, whose unfinished tiles are empty. Tiles are
    /// then smaller, but not so small that their borders take more than a hundredth of the work.
    pub partial: Option<&'a (dyn Fn(&Film) + Sync)>,
    /// Seconds since the first frame of the animation, for the forces that bend shells and fins. 0:
    /// at rest.
    pub time: f64,
    /// When it becomes true, rendering stops after the current pass over a tile and returns the
    /// finished tiles.
    pub cancel: Option<&'a AtomicBool>,
}

/// How far a rendering is.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Finished part of the work, 0..1.
    pub done: f32,
    /// Stem of a pass of the current step.
    pub stage: &'static str,
}

impl RenderOptions<'_> {
    /// Reports progress: the finished part, 0..1, and the stem of a pass.
    pub fn report(&self, done: f32, stage: &'static str) {
        if let Some(progress) = self.progress {
            progress(Progress { done, stage });
        }
    }

    /// Hands the film so far to the caller.
    pub fn show(&self, film: &Film) {
        if let Some(partial) = self.partial {
            partial(film);
        }
    }

    /// Edge of the tiles, samples, where the scene does not choose it. `reach`: samples that the
    /// filter reaches beyond a tile.
    pub fn usual_tile(&self, reach: u32) -> u32 {
        if self.partial.is_some() { (400 * reach).clamp(512, 2048) } else { 2048 }
    }

    /// Whether the caller wants the rendering to stop.
    pub fn cancelled(&self) -> bool {
        self.cancel.is_some_and(|c| c.load(Ordering::Relaxed))
    }
}
