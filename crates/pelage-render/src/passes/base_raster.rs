//! Step 4: the skin. The raster stage finds the nearest triangle at each sample; a compute kernel
//! adds depth, normal and radiance.
// Source: [Andersen2016] table 1, which rasterises the base mesh.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::kernel::Target;
use pelage_gpu::recorder::RasterTargets;
use pelage_gpu::{Gpu, Kernel, RasterKernel, Recorder, Scope};

/// The kernels of `base_raster`.
pub struct BaseRaster {
    raster: RasterKernel,
    shade: Kernel,
}

impl BaseRaster {
    /// Compiles the kernels of a variant.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self {
            raster: RasterKernel::new(gpu, "base_raster", "vertex", "fragment", Target::TriangleIds)?,
            shade: Kernel::specialised(gpu, "base_raster", "shade", &[variant.features()])?,
        })
    }

    /// Draws `triangles` triangles to `targets` and writes `base_records` for all samples of the
    /// tile.
    ///
    /// In scope: `frame`, `shell_vertices`, `prisms`, `fur`, `base_light`, `triangle_ids` (the
    /// colour target), `base_records`, `columns`, `samples`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
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
