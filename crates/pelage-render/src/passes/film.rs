//! Step 7: film samples to pixels, by a separable reconstruction filter summed in a fixed order.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernel of `film`.
pub struct Film {
    main: Kernel,
    objects: Option<Kernel>,
}

impl Film {
    /// Compiles the kernel of a variant.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        let kernel = |entry| Kernel::specialised(gpu, "film", entry, &[variant.features()]);
        let objects = variant.features.then(|| kernel("objects")).transpose()?;
        Ok(Self { main: kernel("main")?, objects })
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

    /// Writes the coverages of the skin and of `objects` objects behind the planes of
    /// [`Film::record`]; nothing without features.
    ///
    /// In scope: as there.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record_objects(
        &self,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        pixels: u64,
        objects: u32,
    ) -> Result<()> {
        match &self.objects {
            Some(kernel) if objects > 0 => {
                recorder.dispatch(kernel, scope, pixels * (1 + u64::from(objects)))
            }
            _ => Ok(()),
        }
    }
}
