//! Step 3: guard hairs as tessellated curves.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 3: guard hairs as tessellated curves.
pub struct GuardStrands {
    main: Kernel,
}

impl GuardStrands {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { main: Kernel::new(gpu, "guard_strands", "main")? })
    }

    /// Writes `strand_vertices` for `strands` of `roots`. In scope: the skin, `groom`, `maps_and_tables`, `batch`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, strands: u32) -> Result<()> {
        recorder.dispatch(&self.main, scope, u64::from(strands))
    }
}
