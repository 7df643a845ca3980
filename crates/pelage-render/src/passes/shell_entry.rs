//! Step 5: where view rays enter the prism shell, through the top faces and through walls over the
//! border of an open skin.
// Source: [Andersen2016] sec. 3.2; the walls are ours.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::kernel::Target;
use pelage_gpu::recorder::RasterTargets;
use pelage_gpu::{Gpu, RasterKernel, Recorder, Scope};

/// The kernels of `shell_entry`.
pub struct ShellEntry {
    top: RasterKernel,
    wall: RasterKernel,
}

impl ShellEntry {
    /// Compiles the kernels of a variant.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        let kernel = |vertex| {
            let (stages, constants) = ([vertex, "fragment"], [variant.features()]);
            RasterKernel::specialised(gpu, "shell_entry", stages, Target::Records, &constants)
        };
        Ok(Self { top: kernel("top")?, wall: kernel("wall")? })
    }

    /// Adds the entries through the tops of `triangles` prisms and through `walls` border walls to
    /// `fragment_lists`.
    ///
    /// In scope: `frame`, `shell_vertices`, `prisms`, `border`, `base_records`, `fragment_lists`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        targets: &RasterTargets<'_>,
        triangles: u32,
        walls: u32,
    ) -> Result<()> {
        recorder.draw(&self.top, scope, targets, 3 * triangles)?;
        if walls > 0 {
            recorder.draw(&self.wall, scope, targets, 6 * walls)?;
        }
        Ok(())
    }
}
