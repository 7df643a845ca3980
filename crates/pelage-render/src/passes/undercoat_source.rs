//! Step 2: what the march looks up of the lights.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 2: what the march looks up of the lights.
pub struct UndercoatSource {
    main: Kernel,
}

impl UndercoatSource {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self {
            main: Kernel::specialised(
                gpu,
                "undercoat_source",
                "main",
                &[variant.undercoat(), variant.multiple()],
            )?,
        })
    }

    /// Fills `source` and `base_light`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, nodes: u64) -> Result<()> {
        recorder.dispatch(&self.main, scope, nodes)
    }
}
