//! Step 5: where view rays enter the prism shell, through the top faces and through walls over the
//! border of an open skin.
// Source: [Andersen2016] sec. 3.2; the walls are ours.

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
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            top: RasterKernel::new(gpu, "shell_entry", "top", "fragment", Target::Records)?,
            wall: RasterKernel::new(gpu, "shell_entry", "wall", "fragment", Target::Records)?,
        })
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
