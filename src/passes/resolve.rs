//! Step 7: fragments to film samples.

use crate::Result;
use crate::gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 7: fragments to film samples.
pub struct Resolve {
    exact: Kernel,
    stored: Kernel,
}

impl Resolve {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            exact: Kernel::new(gpu, "resolve", "exact")?,
            stored: Kernel::new(gpu, "resolve", "stored")?,
        })
    }

    /// Resolves `samples` lists into `samples`; `exact` marches the undercoat between the fragments.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if a binding is missing.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, samples: u64, exact: bool) -> Result<()> {
        recorder.dispatch(if exact { &self.exact } else { &self.stored }, scope, samples)
    }
}
