//! Step 2: densities and tangents of the undercoat's subelements from simplex noise, 4 bytes each.
// Source: [Andersen2016] sec. 3.2.

use pelage_core::Result;
use pelage_fur::layout::DensityCounts;
use pelage_gpu::{Buffer, Gpu, Kernel, Recorder, Scope};

/// The kernel of `undercoat_density`.
pub struct UndercoatDensity {
    main: Kernel,
}

impl UndercoatDensity {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { main: Kernel::new(gpu, "undercoat_density", "main")? })
    }

    /// Fills `media_or_uv` with the media of `triangles` prisms of `layers` layers. Returns the
    /// buffer that must live until the recording is submitted.
    ///
    /// In scope: `fur`, `noise`, `shell_vertices`, `prisms`, `corner_uv`, `media_or_uv`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
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
