//! Step 1: hair roots.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// Step 1: hair roots.
pub struct HairRoots {
    count: Kernel,
    emit: Kernel,
}

impl HairRoots {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            count: Kernel::new(gpu, "hair_roots", "count")?,
            emit: Kernel::new(gpu, "hair_roots", "emit")?,
        })
    }

    /// Counts the roots of `triangles` triangles from `first` into `root_counts`. In scope: the skin and the groom.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record_count(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, triangles: u32) -> Result<()> {
        recorder.dispatch(&self.count, scope, u64::from(triangles))
    }

    /// Writes the roots behind `first_roots`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record_emit(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, triangles: u32) -> Result<()> {
        recorder.dispatch(&self.emit, scope, u64::from(triangles))
    }
}
