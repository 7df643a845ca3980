//! Step 3: shading of the guard hairs, once at each vertex for all lights, with optical depths from
//! the lattice.
// Source of the fibre models: shaders/shared/fibre.wgsl; of root darkening: [Andersen2016] sec.
// 3.1.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernel of `guard_shade`.
pub struct GuardShade {
    main: Kernel,
}

impl GuardShade {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self {
            main: Kernel::specialised(
                gpu,
                "guard_shade",
                "main",
                &[variant.guard(), variant.multiple(), variant.coats(), variant.features()],
            )?,
        })
    }

    /// Fills `shades` for `strands` strands.
    ///
    /// In scope: `frame`, `strand_batch`, `fur`, `groom`, `lights`, `guard_fibre`,
    /// `maps_and_tables`, `shell_vertices`, `prisms`, `corner_uv`, `roots`, `strand_vertices`,
    /// `tau`, `response_table`, `table_sampler`, `shades`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, strands: u32) -> Result<()> {
        recorder.dispatch(&self.main, scope, u64::from(strands))
    }
}
