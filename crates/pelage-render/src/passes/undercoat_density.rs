//! Step 2: densities and tangents of the subelements.

use pelage_core::Result;
use pelage_fur::layout::DensityCounts;
use pelage_gpu::{Buffer, Gpu, Kernel, Recorder, Scope};

/// Step 2: densities and tangents of the subelements.
pub struct UndercoatDensity {
    main: Kernel,
}

impl UndercoatDensity {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { main: Kernel::new(gpu, "undercoat_density", "main")? })
    }

    /// Fills `media_or_uv`. In scope: the shell, `fur`, `noise`, `corner_uv`, `media_or_uv`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        triangles: u32,
        layers: u32,
    ) -> Result<Buffer> {
        let counts = gpu.uniform("density_counts", &DensityCounts { triangles })?;
        recorder.dispatch(&self.main, &scope.with(&[&counts]), u64::from(triangles) * u64::from(layers))?;
        Ok(counts)
    }
}
