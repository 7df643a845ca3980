//! Step 2: lights that the skin itself blocks outside the shell, once per column of the lattice, by
//! a BVH over the skin.
// Sources: [KayKajiya1986] for boxes, [MollerTrumbore1997] for triangles.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernel of `light_occlusion`.
pub struct LightOcclusion {
    main: Kernel,
}

impl LightOcclusion {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { main: Kernel::new(gpu, "light_occlusion", "main")? })
    }

    /// Sets `blocked` of `columns` columns.
    ///
    /// In scope: `fur`, `lights`, `shell_vertices`, `prisms`, `bvh_nodes`, `bvh_triangles`,
    /// `columns`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, columns: u32) -> Result<()> {
        recorder.dispatch(&self.main, scope, u64::from(columns))
    }
}
