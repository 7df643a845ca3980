//! Step 3: shading of the guard hairs at their vertices.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 3: shading of the guard hairs at their vertices.
pub struct GuardShade {
    main: Kernel,
}

impl GuardShade {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self {
            main: Kernel::specialised(gpu, "guard_shade", "main", &[variant.guard(), variant.multiple()])?,
        })
    }

    /// Fills `shades` for `strands` strands.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, strands: u32) -> Result<()> {
        recorder.dispatch(&self.main, scope, u64::from(strands))
    }
}
