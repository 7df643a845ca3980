//! Step 2: attributes of the skin below the columns of the optical-depth lattice, read from the
//! maps.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernel of `shell_lattice`.
pub struct ShellLattice {
    main: Kernel,
}

impl ShellLattice {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self { main: Kernel::specialised(gpu, "shell_lattice", "main", &[variant.coats()])? })
    }

    /// Sets density factor and colours of `columns` columns.
    ///
    /// In scope: `fur`, `groom`, `maps_and_tables`, `shell_vertices`, `prisms`, `corner_uv`,
    /// `columns`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, columns: u32) -> Result<()> {
        recorder.dispatch(&self.main, scope, u64::from(columns))
    }
}
