//! Step 1: the prism shell, extruded along smoothed normals; vertices are lowered where it would
//! fold over or climb too steeply.
// Source: [Andersen2016] sec. 3.

use super::Variant;
use pelage_core::Result;
use pelage_fur::layout::ShellCounts;
use pelage_fur::shell_prisms::SPREAD_ROUNDS;
use pelage_gpu::{Buffer, Gpu, Kernel, Recorder, Resource, Scope};

/// The kernels of `shell_prisms`.
pub struct ShellPrisms {
    fold: Kernel,
    spread: Kernel,
    vertices: Kernel,
    prisms: Kernel,
}

impl ShellPrisms {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self {
            fold: Kernel::specialised(gpu, "shell_prisms", "fold", &[variant.coats()])?,
            spread: Kernel::new(gpu, "shell_prisms", "spread")?,
            vertices: Kernel::specialised(gpu, "shell_prisms", "vertices", &[variant.coats()])?,
            prisms: Kernel::new(gpu, "shell_prisms", "prisms_of_triangles")?,
        })
    }

    /// Extrudes `vertices` vertices and writes the prisms of `triangles` triangles. Returns the
    /// buffers that must live until the recording is submitted.
    ///
    /// In scope: `groom`, `maps_and_tables`, `skin_vertices`, `vertex_uv`, `triangles`,
    /// `neighbours`, `edge_numbers`, `subdivisions`, `shell_vertices`, `prisms`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope, [`pelage_core::Error::OutOfMemory`]
    /// if the tables of heights do not fit.
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        vertices: u32,
        triangles: u32,
    ) -> Result<[Buffer; 3]> {
        let counts = gpu.uniform("shell_counts", &ShellCounts { vertices, triangles })?;
        let high = vec![f32::MAX; vertices as usize];
        let tables = [gpu.upload("reach", 1, &high)?, gpu.upload("reach", 1, &high)?];
        let scope = scope.with(&[&counts]);
        recorder.dispatch(&self.fold, &scope.with(&[&tables[0]]), u64::from(triangles))?;
        for round in 0..SPREAD_ROUNDS {
            let [before, after] = if round % 2 == 0 { [0, 1] } else { [1, 0] };
            let scope =
                scope.with(&[&tables[after]]).and("reach_before", Resource::Buffer(&tables[before].raw));
            recorder.dispatch(&self.spread, &scope, u64::from(triangles))?;
        }
        let scope = scope.with(&[&tables[SPREAD_ROUNDS % 2]]);
        recorder.dispatch(&self.vertices, &scope, u64::from(vertices))?;
        recorder.dispatch(&self.prisms, &scope, u64::from(triangles))?;
        let [first, second] = tables;
        Ok([counts, first, second])
    }
}
