//! Step 2: optical depths from the lattice to the lights.

use crate::Result;
use crate::gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 2: optical depths from the lattice to the lights.
pub struct UndercoatLight {
    main: Kernel,
}

impl UndercoatLight {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            main: Kernel::new(gpu, "undercoat_light", "main")?,
        })
    }

    /// Fills `tau`: `pairs` pairs of lights at each of `nodes` nodes.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if a binding is missing.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, nodes: u64, pairs: u32) -> Result<()> {
        recorder.dispatch(&self.main, scope, nodes * u64::from(pairs))
    }
}
