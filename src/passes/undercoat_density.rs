//! Step 2: densities and tangents of the subelements.

use crate::Result;
use crate::gpu::{Buffer, Gpu, Kernel, Recorder, Scope};

/// Step 2: densities and tangents of the subelements.
pub struct UndercoatDensity {
    main: Kernel,
}

impl UndercoatDensity {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { main: Kernel::new(gpu, "undercoat_density", "main")? })
    }

    /// Fills `cells`. In scope: the shell, `fur`, `noise`, `corner_uv`, `cells`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if a binding is missing.
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        triangles: u32,
        layers: u32,
    ) -> Result<Buffer> {
        let counts = gpu.uniform("counts", &[triangles, 0, 0, 0])?;
        recorder.dispatch(&self.main, &scope.with(&[&counts]), u64::from(triangles) * u64::from(layers))?;
        Ok(counts)
    }
}
