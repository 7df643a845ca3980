//! Shells and fins: rows of vertices above the skin, and their light.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};
use pelage_render::passes::Variant;

/// Shells and fins: rows of vertices above the skin, and their light.
pub struct ShellfinRows {
    main: Kernel,
}

impl ShellfinRows {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self {
            main: Kernel::specialised(gpu, "shellfin_rows", "main", &[variant.guard(), variant.undercoat()])?,
        })
    }

    /// Writes `row_positions` and `row_lights`, `rows` times the skin's `vertices`.
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
