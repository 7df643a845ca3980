//! Counts, times and bytes of a rendering, in the rows of Andersen et al. 2016, Table 1.

use serde::Serialize;

/// Statistics of a rendering.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Stats {
    /// Adapter name.
    pub adapter: String,
    /// Driver and its version.
    pub driver: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Samples a pixel.
    pub spp: u32,
    /// `base`, `explicit`, `implicit` or `hybrid`.
    pub fur: String,
    /// `simplified`, `virtual` or `exact`.
    pub blend: String,
    /// Triangles of the skin.
    pub triangles: u64,
    /// Guard hairs.
    pub strands: u64,
    /// Prism subelements.
    pub subelements: u64,
    /// Whether the undercoat's densities were `stored` or `evaluated`.
    pub storage: String,
    /// Tiles rendered.
    pub tiles: u64,
    /// Tiles that overflowed, were split and rendered again.
    pub tiles_retried: u64,
    /// Fragments in linked lists, all tiles together.
    pub fragments: u64,
    /// Longest list of a sample.
    pub fragments_max: u64,
    /// Fragments that found no place in the end: always 0, or the rendering fails.
    pub fragments_dropped: u64,
    /// Rays that lost their place in the shell at some step (the hop limit was reached where it folds).
    pub rays_lost: u64,
    /// The budget.
    pub memory_budget_bytes: u64,
    /// Largest sum of GPU allocations alive at once.
    pub gpu_peak_bytes: u64,
    /// Wall time.
    pub total_ms: f64,
    /// The rows of the table.
    pub steps: Vec<Step>,
    /// Passes in order, finer than the steps.
    pub passes: Vec<PassTime>,
}

/// A row of Table 1.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Step {
    /// 1..=7 as in the paper's table; 0 for what the paper has not.
    pub step: u32,
    /// Row name.
    pub name: String,
    /// GPU time; `None` where the adapter has no timestamps.
    pub ms: Option<f64>,
    /// Bytes of its buffers.
    pub bytes: u64,
}

/// Time of one pass.
#[derive(Debug, Clone, Default, Serialize)]
pub struct PassTime {
    /// Stem of the pass.
    pub pass: String,
    /// GPU time; `None` where the adapter has no timestamps.
    pub ms: Option<f64>,
    /// How often it was dispatched.
    pub dispatches: u64,
}
