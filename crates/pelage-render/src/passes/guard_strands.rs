//! Step 3: guard hairs as tessellated cubic Bézier curves.
// Source: [Andersen2016] sec. 2, which names Bézier shaping, gravity and grooming by textures; the
// formulas are ours.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernel of `guard_strands`.
pub struct GuardStrands {
    main: Kernel,
}

impl GuardStrands {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self { main: Kernel::specialised(gpu, "guard_strands", "main", &[variant.coats()])? })
    }

    /// Writes `strand_vertices` of the first `strands` roots.
    ///
    /// In scope: `strand_batch`, `groom`, `maps_and_tables`, `shell_vertices`, `prisms`,
    /// `corner_uv`, `roots`, `strand_vertices`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, strands: u32) -> Result<()> {
        recorder.dispatch(&self.main, scope, u64::from(strands))
    }
}
