//! Step 6: the strands that may touch each tile; out of core, the roots whose strands may touch one
//! tile.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernels of `guard_bins`.
pub struct GuardBins {
    count: Kernel,
    fill: Kernel,
    gather: Kernel,
}

impl GuardBins {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            count: Kernel::new(gpu, "guard_bins", "count")?,
            fill: Kernel::new(gpu, "guard_bins", "fill")?,
            gather: Kernel::new(gpu, "guard_bins", "gather")?,
        })
    }

    /// Adds the number of strands in each tile to `bin_counts`.
    ///
    /// In scope: `frame`, `strand_batch`, `tile_grid`, `groom`, `strand_vertices`, `bin_counts`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record_count(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, strands: u32) -> Result<()> {
        recorder.dispatch(&self.count, scope, u64::from(strands))
    }

    /// Writes the strands of each tile to `bins` from its entry of `bin_starts`; `bin_counts` must
    /// be zero before.
    ///
    /// In scope: those of [`GuardBins::record_count`], `bin_starts`, `bins`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record_fill(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, strands: u32) -> Result<()> {
        recorder.dispatch(&self.fill, scope, u64::from(strands))
    }

    /// Copies the roots whose strands may touch the tile of `frame`, out of `roots` roots, to
    /// `tile_roots`, writes their numbers there to `bins`, and their count to the first entry of
    /// `bin_counts`, which must be zero before.
    ///
    /// In scope: `frame`, `strand_batch`, `tile_grid`, `shell_vertices`, `prisms`, `roots`,
    /// `bin_counts`, `bins`, `tile_roots`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record_gather(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, roots: u32) -> Result<()> {
        recorder.dispatch(&self.gather, scope, u64::from(roots))
    }
}
