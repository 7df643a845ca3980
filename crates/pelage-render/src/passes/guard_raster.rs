//! Step 6: analytic coverage of the guard hairs' camera-facing ribbons, one invocation per segment.
// [Andersen2016] draws quads; analytic coverage in compute is ours.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernel of `guard_raster`.
pub struct GuardRaster {
    main: Kernel,
}

impl GuardRaster {
    /// Compiles the kernel of a variant.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self { main: Kernel::specialised(gpu, "guard_raster", "main", &[variant.features()])? })
    }

    /// Adds the fragments of the `strands` strands of a bin, of `segments` segments each, to
    /// `fragment_lists`.
    ///
    /// In scope: `frame`, `bin`, `groom`, `bins`, `roots`, `strand_vertices`, `shades`,
    /// `base_records`, `fragment_lists`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        strands: u32,
        segments: u32,
    ) -> Result<()> {
        recorder.dispatch(&self.main, scope, u64::from(strands) * u64::from(segments))
    }
}
