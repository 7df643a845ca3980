//! Step 6: strands by tile.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 6: strands by tile.
pub struct GuardBins {
    count: Kernel,
    fill: Kernel,
    gather: Kernel,
}

impl GuardBins {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            count: Kernel::new(gpu, "guard_bins", "count")?,
            fill: Kernel::new(gpu, "guard_bins", "fill")?,
            gather: Kernel::new(gpu, "guard_bins", "gather")?,
        })
    }

    /// Counts into `bin_counts`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record_count(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, strands: u32) -> Result<()> {
        recorder.dispatch(&self.count, scope, u64::from(strands))
    }

    /// Fills `bins` behind `bin_starts`; `bin_counts` must be zero again.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record_fill(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, strands: u32) -> Result<()> {
        recorder.dispatch(&self.fill, scope, u64::from(strands))
    }

    /// Picks of `roots` roots those whose strands may touch the tile of `frame`, into `tile_roots` and `bins`; counts in `bin_counts`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record_gather(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, roots: u32) -> Result<()> {
        recorder.dispatch(&self.gather, scope, u64::from(roots))
    }
}
