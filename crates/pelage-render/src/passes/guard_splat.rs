//! Step 2: what the guard hairs take from the light.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 2: what the guard hairs take from the light.
pub struct GuardSplat {
    deposit: Kernel,
    normalise: Kernel,
}

impl GuardSplat {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            deposit: Kernel::new(gpu, "guard_splat", "deposit")?,
            normalise: Kernel::new(gpu, "guard_splat", "normalise")?,
        })
    }

    /// Adds `strands` strands to `deposits`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record_deposit(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, strands: u32) -> Result<()> {
        recorder.dispatch(&self.deposit, scope, u64::from(strands))
    }

    /// Turns `deposits` into `lattice_extinction` at `nodes` nodes.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record_normalise(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, nodes: u64) -> Result<()> {
        recorder.dispatch(&self.normalise, scope, nodes)
    }
}
