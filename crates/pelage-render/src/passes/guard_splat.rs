//! Step 2: extinction at the nodes of the optical-depth lattice, of guard hairs (deposited in fixed
//! point) and undercoat.

use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernels of `guard_splat`.
pub struct GuardSplat {
    deposit: Kernel,
    normalise: Kernel,
}

impl GuardSplat {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            deposit: Kernel::new(gpu, "guard_splat", "deposit")?,
            normalise: Kernel::new(gpu, "guard_splat", "normalise")?,
        })
    }

    /// Adds length times diameter of `strands` strands to `deposits`.
    ///
    /// In scope: `strand_batch`, `fur`, `groom`, `shell_vertices`, `prisms`, `roots`,
    /// `strand_vertices`, `deposits`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record_deposit(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, strands: u32) -> Result<()> {
        recorder.dispatch(&self.deposit, scope, u64::from(strands))
    }

    /// Divides `deposits` by the volumes of `nodes` nodes, adds the undercoat, and writes
    /// `lattice_extinction`.
    ///
    /// In scope: `fur`, `noise`, `shell_vertices`, `prisms`, `corner_uv`, `columns`, `deposits`,
    /// `lattice_extinction`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record_normalise(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, nodes: u64) -> Result<()> {
        recorder.dispatch(&self.normalise, scope, nodes)
    }
}
