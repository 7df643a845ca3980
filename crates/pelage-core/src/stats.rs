//! Counts, times and memory of a rendering, by the rows of Andersen et al. 2016, Table 1.

use serde::Serialize;

/// Statistics of a rendering.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Stats {
    /// Adapter name.
    pub adapter: String,
    /// Driver and its version.
    pub driver: String,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Samples per pixel.
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
    /// Tiles that overflowed and were split and rendered again.
    pub tiles_retried: u64,
    /// Fragments in linked lists, all tiles together.
    pub fragments: u64,
    /// Longest list of a sample.
    pub fragments_max: u64,
    /// Fragments that were dropped: always 0, otherwise the rendering fails.
    pub fragments_dropped: u64,
    /// Fragments that were stored but not read: the adapter ended the loops before the lists did.
    /// They are missing in the picture; more samples per pixel make the lists shorter.
    pub fragments_unread: u64,
    /// Rays whose loops the adapter ended before the march or the list did.
    pub rays_cut: u64,
    /// Marches towards a light that ended at their last step, with the optical depth so far.
    pub light_paths_cut: u64,
    /// Rays that at some step lost their place in the prism shell: the limit of hops was reached
    /// where it folds.
    pub rays_lost: u64,
    /// GPU memory budget, bytes.
    pub memory_budget_bytes: u64,
    /// Largest sum of GPU allocations alive at once, bytes.
    pub gpu_peak_bytes: u64,
    /// Wall time, ms.
    pub total_ms: f64,
    /// The rows of the table.
    pub steps: Vec<Step>,
    /// The passes in order; a step consists of one or more.
    pub passes: Vec<PassTime>,
}

/// A row of Table 1.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Step {
    /// 1..=7 as in the paper's table; 0 for what is not in the paper.
    pub step: u32,
    /// Row name.
    pub name: String,
    /// GPU time, ms; `None` where the adapter has no timestamps.
    pub ms: Option<f64>,
    /// Size of its buffers, bytes.
    pub bytes: u64,
}

/// Time of one pass.
#[derive(Debug, Clone, Default, Serialize)]
pub struct PassTime {
    /// Name of the pass.
    pub pass: String,
    /// GPU time, ms; `None` where the adapter has no timestamps.
    pub ms: Option<f64>,
    /// Number of dispatches.
    pub dispatches: u64,
}
