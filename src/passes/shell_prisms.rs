//! Step 1: the prism shell.

use crate::Result;
use crate::gpu::{Buffer, Gpu, Kernel, Recorder, Scope};

/// Step 1: the prism shell.
pub struct ShellPrisms {
    fold: Kernel,
    vertices: Kernel,
    prisms: Kernel,
}

impl ShellPrisms {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            fold: Kernel::new(gpu, "shell_prisms", "fold")?,
            vertices: Kernel::new(gpu, "shell_prisms", "vertices")?,
            prisms: Kernel::new(gpu, "shell_prisms", "prisms_of_triangles")?,
        })
    }

    /// Extrudes the shell and joins the tables. In scope: `skin_vertices`, `triangles`, `vertex_uv`, `neighbours`, `subdivisions`, `groom`,
    /// `map_texels`, `shell_vertices`, `prisms`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if a binding is missing, [`crate::Error::OutOfMemory`] without room.
    pub fn record(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, scope: &Scope<'_>, vertices: u32, triangles: u32) -> Result<[Buffer; 2]> {
        let counts = gpu.uniform("counts", &[vertices, triangles, 0, 0])?;
        let reach = gpu.upload("reach", 1, &vec![f32::MAX; vertices as usize])?;
        let scope = scope.with(&[&counts, &reach]);
        recorder.dispatch(&self.fold, &scope, u64::from(triangles))?;
        recorder.dispatch(&self.vertices, &scope, u64::from(vertices))?;
        recorder.dispatch(&self.prisms, &scope, u64::from(triangles))?;
        Ok([counts, reach])
    }
}
