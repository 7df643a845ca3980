//! Step 5: shell and virtual fragments.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 5: shell and virtual fragments.
pub struct UndercoatMarch {
    main: Kernel,
}

impl UndercoatMarch {
    /// Compiles the kernels of a variant of the march.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        let constants = variant.constants();
        Ok(Self { main: Kernel::specialised(gpu, "undercoat_march", "main", &constants)? })
    }

    /// Marches from the entries in `fragment_lists` and adds fragments to them.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, samples: u64) -> Result<()> {
        recorder.dispatch(&self.main, scope, samples)
    }
}
