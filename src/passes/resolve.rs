//! Step 7: fragments to film samples.

use crate::Result;
use crate::gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 7: fragments to film samples.
pub struct Resolve {
    exact: Kernel,
    stored: Kernel,
}

impl Resolve {
    /// Compiles the kernels for a volume that is `stored` or evaluated.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu, stored: bool) -> Result<Self> {
        let constants = [("STORED", f64::from(u8::from(stored)))];
        Ok(Self {
            exact: Kernel::specialised(gpu, "resolve", "exact", &constants)?,
            stored: Kernel::specialised(gpu, "resolve", "stored", &constants)?,
        })
    }

    /// Resolves `samples` lists into `samples`; `exact` marches the undercoat between the fragments.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if a binding is missing.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        samples: u64,
        exact: bool,
    ) -> Result<()> {
        recorder.dispatch(if exact { &self.exact } else { &self.stored }, scope, samples)
    }
}
