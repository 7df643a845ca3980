//! Film samples to pixels.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// Film samples to pixels.
pub struct Film {
    main: Kernel,
}

impl Film {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { main: Kernel::new(gpu, "film", "main")? })
    }

    /// Adds the samples of a tile to its `pixels`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, pixels: u64) -> Result<()> {
        recorder.dispatch(&self.main, scope, pixels)
    }
}
