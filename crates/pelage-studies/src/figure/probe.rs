//! A tile of a world through the renderer's passes, for pictures of what each leaves.

use pelage_core::{Result, World};
use pelage_fur::groom;
use pelage_gpu::Gpu;
use pelage_render::probe::PreparedWorld;
pub(super) use pelage_render::probe::Probe;
use pelage_render::tile_buffers::list_bytes;
use std::sync::Arc;

/// Fragments a sample for which there is room, if a binding holds them.
const FRAGMENTS: u64 = 256;

/// The tile of `size` pixels at `origin` of a film of `film` pixels of one sample each, after steps
/// 1 to 4 and with the entries into the shell.
pub(super) fn probe<'g>(
    gpu: &'g Gpu,
    world: &World,
    film: [u32; 2],
    origin: [u32; 2],
    size: [u32; 2],
) -> Result<Probe<'g>> {
    let of = Arc::new(PreparedWorld::new(gpu, world.clone(), film)?);
    let samples = u64::from(size[0]) * u64::from(size[1]);
    let room = gpu.binding_limit().saturating_sub(list_bytes(samples, 0));
    let capacity = (FRAGMENTS * samples).min(room / pelage_render::FRAGMENT_BYTES);
    let probe = Probe::new(&of, film, origin.map(|x| x as i32), size, capacity)?;
    probe.draw_base()?;
    if groom::has_undercoat(&world.scene) {
        probe.draw_entries()?;
    }
    Ok(probe)
}
