//! What a caller chooses for a rendering beside the scene, and what it is told on the way.

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
    /// Seconds since the animation's first frame: forces bend shells and fins as they do then. 0: at rest.
    pub time: f64,
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

impl RenderOptions<'_> {
    /// Planes that the film pass writes.
    pub fn planes(&self) -> u32 {
        if self.aovs { 20 } else { 4 }
    }

    /// Reports how far the rendering is, 0..1, and what it does.
    pub fn report(&self, done: f32, stage: &'static str) {
        if let Some(progress) = self.progress {
            progress(Progress { done, stage });
        }
    }

    /// Whether the caller wants the rendering to stop.
    pub fn cancelled(&self) -> bool {
        self.cancel.is_some_and(|c| c.load(Ordering::Relaxed))
    }
}
