//! Step 5: shell and virtual fragments.

use crate::Result;
use crate::gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 5: shell and virtual fragments.
pub struct UndercoatMarch {
    main: Kernel,
}

impl UndercoatMarch {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            main: Kernel::new(gpu, "undercoat_march", "main")?,
        })
    }

    /// Marches from the entries in `fragment_lists` and adds fragments to them.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if a binding is missing.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, samples: u64) -> Result<()> {
        recorder.dispatch(&self.main, scope, samples)
    }
}
