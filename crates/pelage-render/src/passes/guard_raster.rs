//! Step 6: coverage of the guard hairs.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 6: coverage of the guard hairs.
pub struct GuardRaster {
    main: Kernel,
}

impl GuardRaster {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { main: Kernel::new(gpu, "guard_raster", "main")? })
    }

    /// Adds the fragments of `strands` strands of a bin to `fragment_lists`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        strands: u32,
        segments: u32,
    ) -> Result<()> {
        recorder.dispatch(&self.main, scope, u64::from(strands) * u64::from(segments))
    }
}
