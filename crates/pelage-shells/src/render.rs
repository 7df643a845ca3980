//! Renders any scene: hybrid fur, or shells and fins if `render.fur` asks for them.

use crate::shellfin;
use pelage_core::scene::FurLayers;
use pelage_core::{Result, World};
use pelage_gpu::Gpu;
use pelage_render::driver::Run;
use pelage_render::{Frame, RenderOptions, drive, drive_on};

/// Renders `world` on the adapter chosen by the environment (WGPU_BACKEND, WGPU_ADAPTER_NAME,
/// WGPU_POWER_PREF).
///
/// A lost device is reopened once, and rendering continues with the tile that was lost. If it is
/// lost again, the frame holds the finished tiles and the error.
///
/// # Errors
/// [`Error::Adapter`](pelage_core::Error::Adapter) without a sufficient adapter,
/// [`Error::OutOfMemory`](pelage_core::Error::OutOfMemory) if even the smallest tile does not fit,
/// [`Error::DeviceLost`](pelage_core::Error::DeviceLost) before the first tile is done,
/// [`Error::Gpu`](pelage_core::Error::Gpu).
pub fn render(world: &World, options: &RenderOptions<'_>) -> Result<Frame> {
    render_with(&pelage_render::open, world, options)
}

/// Renders `world` on a device that `open` opens; `open` is called again if the device is lost.
///
/// # Errors
/// As [`render`].
pub fn render_with(
    open: &dyn Fn() -> Result<Gpu>,
    world: &World,
    options: &RenderOptions<'_>,
) -> Result<Frame> {
    drive(open, world, options, run_of(world))
}

/// Renders `world` on an open device. If the device is lost, the frame holds the finished tiles and
/// the error.
///
/// # Errors
/// As [`render`].
pub fn render_on(gpu: &Gpu, world: &World, options: &RenderOptions<'_>) -> Result<Frame> {
    drive_on(gpu, world, options, run_of(world))
}

fn run_of(world: &World) -> &'static Run {
    match world.scene.render.fur {
        FurLayers::Shells => &shellfin::run,
        FurLayers::Base | FurLayers::Explicit | FurLayers::Implicit | FurLayers::Hybrid => {
            &pelage_render::run
        }
    }
}
