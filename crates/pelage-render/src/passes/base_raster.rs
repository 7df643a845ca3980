//! Step 4: the skin: nearest triangle by raster, shading in compute.

use pelage_core::Result;
use pelage_gpu::kernel::Target;
use pelage_gpu::recorder::RasterTargets;
use pelage_gpu::{Gpu, Kernel, RasterKernel, Recorder, Scope};

/// Step 4: the skin.
pub struct BaseRaster {
    raster: RasterKernel,
    shade: Kernel,
}

impl BaseRaster {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            raster: RasterKernel::new(gpu, "base_raster", "vertex", "fragment", Target::TriangleIds)?,
            shade: Kernel::new(gpu, "base_raster", "shade")?,
        })
    }

    /// Draws `triangles` triangles and writes `base_records`. In scope: the shell, `base_light`, `triangle_ids`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        targets: &RasterTargets<'_>,
        triangles: u32,
    ) -> Result<()> {
        recorder.draw(&self.raster, scope, targets, 3 * triangles)?;
        recorder.dispatch(&self.shade, scope, u64::from(targets.size[0]) * u64::from(targets.size[1]))
    }
}
