//! Step 1: number and positions of the guard hairs' roots, drawn from the triangle's id and thinned
//! by the density map.
// Sources: [VanGelderWilhelms1997], [Andersen2016] sec. 3.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernels of `hair_roots`.
pub struct HairRoots {
    count: Kernel,
    emit: Kernel,
}

impl HairRoots {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self {
            count: Kernel::specialised(gpu, "hair_roots", "count", &[variant.coats()])?,
            emit: Kernel::specialised(gpu, "hair_roots", "emit", &[variant.coats()])?,
        })
    }

    /// Writes the number of roots of each of the `parts` parts of triangles of `root_range` to
    /// `root_counts`.
    ///
    /// In scope: `root_range`, `groom`, `maps_and_tables`, `shell_vertices`, `prisms`, `corner_uv`,
    /// `root_counts`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record_count(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, parts: u32) -> Result<()> {
        recorder.dispatch(&self.count, scope, u64::from(parts))
    }

    /// Writes the roots of the `parts` parts of triangles of `root_range` to `roots`, each part's
    /// from its entry of `first_roots`.
    ///
    /// In scope: `root_range`, `groom`, `maps_and_tables`, `shell_vertices`, `prisms`, `corner_uv`,
    /// `first_roots`, `roots`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record_emit(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, parts: u32) -> Result<()> {
        recorder.dispatch(&self.emit, scope, u64::from(parts))
    }
}
