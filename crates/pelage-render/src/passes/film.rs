//! Step 7: film samples to pixels, by a separable reconstruction filter summed in a fixed order.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernel of `film`.
pub struct Film {
    main: Kernel,
}

impl Film {
    /// Compiles the kernel of a variant.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self { main: Kernel::specialised(gpu, "film", "main", &[variant.features()])? })
    }

    /// Filters the samples of a tile into its `pixels` pixels; from the second pass over the image
    /// on, adds to them.
    ///
    /// In scope: `frame`, `reconstruction`, `samples`, `pixels`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, pixels: u64) -> Result<()> {
        recorder.dispatch(&self.main, scope, pixels)
    }
}
