//! The call of the renderer that figures and experiments share.

use pelage_core::{Error, Result, World};
use pelage_gpu::Gpu;
use pelage_render::{Frame, RenderOptions};
use std::sync::atomic::AtomicBool;

/// Renders a world with all planes, `time` s after its first frame. A partial image is an error.
///
/// # Errors
/// Those of [`pelage_shells::render_on`]; [`Error::Interrupted`].
pub(crate) fn render_whole(gpu: &Gpu, world: &World, time: f64, cancel: &AtomicBool) -> Result<Frame> {
    let options = RenderOptions { aovs: true, cancel: Some(cancel), time, ..RenderOptions::default() };
    let frame = pelage_shells::render_on(gpu, world, &options)?;
    match frame.fault {
        Some(fault) => Err(fault),
        None if frame.complete => Ok(frame),
        None => Err(Error::Interrupted),
    }
}
