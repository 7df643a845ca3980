//! Step 4: the light on objects, sample by sample, after `base_raster` has found where they are
//! seen.
// Sources: [GLTF2] for the material, [MollerTrumbore1997] and [Hanika2021] for shadow rays; the
// grid of the fur is ours.

use super::Variant;
use pelage_core::Result;
use pelage_fur::layout::LightBatch;
use pelage_gpu::{Buffer, Gpu, Kernel, Recorder, Scope};

/// Lights of a dispatch: their shadow rays must take fewer rounds of loops than Mesa's software
/// adapter allows an invocation, 65,535 together.
const LIGHTS: u32 = 4;

/// The kernel of `objects`.
pub struct Objects {
    shade: Kernel,
    batches: Vec<Buffer>,
}

impl Objects {
    /// Compiles the kernel of a variant, for `lights` lights.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant, lights: u32) -> Result<Self> {
        let firsts = (0..lights.max(1)).step_by(LIGHTS as usize);
        let batches = firsts
            .map(|first| LightBatch { first, end: lights.min(first + LIGHTS) })
            .map(|batch| gpu.uniform("light_batch", &batch));
        Ok(Self {
            shade: Kernel::specialised(gpu, "objects", "shade", &[variant.features()])?,
            batches: batches.collect::<Result<_>>()?,
        })
    }

    /// Writes `base_records` of those of the `samples` samples of the tile that see an object, with
    /// features also what resolve reads in the buffer `samples`.
    ///
    /// In scope: `frame`, `fur`, `lights`, `shell_vertices`, `prisms`, `bvh_nodes`,
    /// `bvh_triangles`, `object_materials`, `maps_and_tables`, `fur_grid`, `fur_cells`,
    /// `triangle_ids`, `base_records`, `samples`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, samples: u64) -> Result<()> {
        self.batches
            .iter()
            .try_for_each(|batch| recorder.dispatch(&self.shade, &scope.with(&[batch]), samples))
    }
}
