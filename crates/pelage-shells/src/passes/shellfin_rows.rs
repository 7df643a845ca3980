//! Places and lights the rows of vertices above the skin for shells and fins.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};
use pelage_render::passes::Variant;

/// The kernel that places and lights rows of vertices.
pub struct ShellfinRows {
    main: Kernel,
}

impl ShellfinRows {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with the file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self {
            main: Kernel::specialised(
                gpu,
                "shellfin_rows",
                "main",
                &[variant.guard(), variant.undercoat(), variant.coats()],
            )?,
        })
    }

    /// Writes `row_positions` and `row_lights`, `[row][vertex of the skin]`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        rows: u32,
        vertices: u32,
    ) -> Result<()> {
        recorder.dispatch(&self.main, scope, u64::from(rows) * u64::from(vertices))
    }
}
