//! Step 2: lights that the skin blocks.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 2: lights that the skin blocks.
pub struct LightOcclusion {
    main: Kernel,
}

impl LightOcclusion {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { main: Kernel::new(gpu, "light_occlusion", "main")? })
    }

    /// Sets the `blocked` bits of `columns`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, columns: u32) -> Result<()> {
        recorder.dispatch(&self.main, scope, u64::from(columns))
    }
}
