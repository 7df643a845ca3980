//! How large a tile may be within the memory budget and the limits of the adapter.

use super::SMALLEST;
use crate::plan::SamplePlan;
use crate::prepare::{Prepared, strand_bytes};
use crate::tile_buffers::{FRAGMENT_BYTES, SAMPLE_BYTES};
use pelage_core::{Error, Result, World};
use pelage_gpu::recorder::RASTER_MARGIN;

/// Fragments a sample that a tile is sized for.
const EXPECTED_FRAGMENTS: u64 = 8;

/// Fragments a sample past which lists get no more room.
const MOST_FRAGMENTS: u64 = 400;

/// The size of a rendering's tiles.
pub(super) struct TileSize {
    /// Edge, pixels.
    pub edge: u32,
    /// Samples of the largest tile, those that the filter reaches over its edge included.
    pub extent: [u32; 2],
    /// Bytes of its fragment lists.
    pub list_bytes: u64,
}

impl TileSize {
    /// The largest that the memory left over by `prepared` allows.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if not even the smallest tile fits.
    pub fn choose(prepared: &Prepared<'_>, world: &World, plan: &SamplePlan, planes: u32) -> Result<Self> {
        let gpu = prepared.gpu;
        let scene = &world.scene;
        let used = gpu.ledger.current();
        // A pixel is held twice while it is read back.
        let sample_bytes = SAMPLE_BYTES + (u64::from(planes) * 8).div_ceil(u64::from(plan.grid * plan.grid));
        let per_sample = sample_bytes + EXPECTED_FRAGMENTS * FRAGMENT_BYTES;
        // Bins, staging and pixels need some room too.
        let strands = match &prepared.resident {
            Some(_) => prepared.strands * 6,
            None => prepared
                .strand_budget
                .min(prepared.strands * strand_bytes(prepared.segments) + prepared.strands * 20),
        };
        let reserve = strands + (8 << 20);
        let room = scene.render.memory.saturating_sub(used + reserve);
        let smallest = u64::from(SMALLEST * plan.grid + 2 * plan.reach).pow(2) * per_sample;
        if room < smallest {
            return Err(Error::OutOfMemory { pass: "resolve".into(), needed: used + reserve + smallest });
        }
        let list_limit = gpu.binding_limit();
        let most = (room / per_sample)
            .min(list_limit / (4 + EXPECTED_FRAGMENTS * FRAGMENT_BYTES))
            .min(list_limit / 32);
        let most_edge = (most as f64).sqrt() as u32;
        let wanted = scene.render.tile.unwrap_or(2048).max(SMALLEST * plan.grid);
        let samples_edge = most_edge
            .min(wanted + 2 * plan.reach)
            .min(4096)
            .min(gpu.limits.max_texture_dimension_2d.saturating_sub(2 * RASTER_MARGIN as u32));
        let edge = (samples_edge.saturating_sub(2 * plan.reach) / plan.grid).max(SMALLEST);
        // No larger than the film.
        let edge = edge.min(scene.film.width.max(scene.film.height));
        let extent =
            [edge.min(scene.film.width), edge.min(scene.film.height)].map(|e| e * plan.grid + 2 * plan.reach);
        let samples = u64::from(extent[0]) * u64::from(extent[1]);
        let list_bytes = room
            .saturating_sub(samples * (sample_bytes - 4))
            .min(list_limit)
            .max(samples * 4 + 64)
            .min(samples * (4 + MOST_FRAGMENTS * FRAGMENT_BYTES));
        Ok(Self { edge, extent, list_bytes })
    }
}
