//! Step 7: fragments to film samples.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 7: fragments to film samples.
pub struct Resolve {
    exact: Kernel,
    blend_fragments: Kernel,
}

impl Resolve {
    /// Compiles the kernels of a variant of the march.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        let constants = variant.constants();
        Ok(Self {
            exact: Kernel::specialised(gpu, "resolve", "exact", &constants)?,
            blend_fragments: Kernel::specialised(gpu, "resolve", "blend_fragments", &constants)?,
        })
    }

    /// Resolves `samples` lists into `samples`; `exact` marches the undercoat between the fragments.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        samples: u64,
        exact: bool,
    ) -> Result<()> {
        recorder.dispatch(if exact { &self.exact } else { &self.blend_fragments }, scope, samples)
    }
}
