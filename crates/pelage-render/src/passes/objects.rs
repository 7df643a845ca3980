//! Step 4: the light on objects, sample by sample, after `base_raster` has found where they are seen.
// Sources: [GLTF2] for the material, [MollerTrumbore1997] for shadow rays; the grid of the fur is ours.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernel of `objects`.
pub struct Objects {
    shade: Kernel,
}

impl Objects {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { shade: Kernel::new(gpu, "objects", "shade")? })
    }

    /// Writes `base_records` of those of the `samples` samples of the tile that see an object.
    ///
    /// In scope: `frame`, `fur`, `lights`, `shell_vertices`, `prisms`, `bvh_nodes`,
    /// `bvh_triangles`, `object_materials`, `maps_and_tables`, `fur_grid`, `fur_cells`,
    /// `triangle_ids`, `base_records`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, samples: u64) -> Result<()> {
        recorder.dispatch(&self.shade, scope, samples)
    }
}
