//! Choice of the tile size within the memory budget and the limits of the adapter.

use super::SMALLEST;
use crate::options::RenderOptions;
use crate::plan::SamplePlan;
use crate::prepare::{Prepared, strand_bytes};
use crate::tile_buffers::{fragment_bytes, sample_bytes};
use pelage_core::{Error, Result, World};
use pelage_gpu::recorder::RASTER_MARGIN;

/// Fragments per sample for which a tile is sized.
const EXPECTED_FRAGMENTS: u64 = 8;

/// Fragments per sample beyond which lists get no more room.
const MOST_FRAGMENTS: u64 = 400;

/// Bytes of lists below which nothing is saved: a tile of a few samples may show the whole fur, and
/// cannot be split further.
const SMALL_LISTS: u64 = 64 << 20;

/// Size of the tiles of a rendering.
pub(super) struct TileSize {
    /// Edge, pixels.
    pub edge: u32,
    /// Size of the largest tile in samples, including those that the filter reaches beyond its
    /// edge.
    pub extent: [u32; 2],
    /// Size of its `fragment_lists`, bytes.
    pub list_bytes: u64,
}

impl TileSize {
    /// The largest tiles that fit the memory left by `prepared`.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if not even the smallest tile fits.
    pub fn choose(
        prepared: &Prepared<'_>,
        world: &World,
        plan: &SamplePlan,
        planes: u32,
        options: &RenderOptions<'_>,
    ) -> Result<Self> {
        let gpu = prepared.gpu;
        let scene = &world.scene;
        let used = gpu.ledger.current();
        // Pixels exist twice while they are read back.
        let features = prepared.variant.features;
        let fragment_bytes = fragment_bytes(features);
        let sample_bytes =
            sample_bytes(features) + (u64::from(planes) * 8).div_ceil(u64::from(plan.grid * plan.grid));
        let per_sample = sample_bytes + EXPECTED_FRAGMENTS * fragment_bytes;
        // Reserve for bins or for strands grown per tile, and for staging.
        let strands = match &prepared.resident {
            Some(_) => prepared.strands * 6,
            None => prepared
                .strand_budget
                .min(prepared.strands * strand_bytes(prepared.segments, features) + prepared.strands * 20),
        };
        let reserve = strands + (8 << 20);
        let room = scene.render.memory.saturating_sub(used + reserve);
        let smallest = u64::from(SMALLEST * plan.grid + 2 * plan.reach).pow(2) * per_sample;
        if room < smallest {
            return Err(Error::OutOfMemory { pass: "resolve".into(), needed: used + reserve + smallest });
        }
        let list_limit = gpu.binding_limit();
        let most = (room / per_sample)
            .min(list_limit / (4 + EXPECTED_FRAGMENTS * fragment_bytes))
            .min(list_limit / if features { 64 } else { 32 });
        let most_edge = (most as f64).sqrt() as u32;
        let wanted = scene.render.tile.unwrap_or(options.usual_tile(plan.reach)).max(SMALLEST * plan.grid);
        let samples_edge = most_edge
            .min(wanted + 2 * plan.reach)
            .min(4096)
            .min(gpu.limits.max_texture_dimension_2d.saturating_sub(2 * RASTER_MARGIN as u32));
        let edge = (samples_edge.saturating_sub(2 * plan.reach) / plan.grid).max(SMALLEST);
        // No tile is larger than the film.
        let edge = edge.min(scene.film.width.max(scene.film.height));
        let extent =
            [edge.min(scene.film.width), edge.min(scene.film.height)].map(|e| e * plan.grid + 2 * plan.reach);
        let samples = u64::from(extent[0]) * u64::from(extent[1]);
        let list_bytes = room
            .saturating_sub(samples * (sample_bytes - 4))
            .min(list_limit)
            .max(samples * 4 + 64)
            .min((samples * (4 + MOST_FRAGMENTS * fragment_bytes)).max(SMALL_LISTS));
        Ok(Self { edge, extent, list_bytes })
    }
}
