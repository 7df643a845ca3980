//! Step 2: optical depths from the lattice to the lights.

use pelage_core::Result;
use pelage_fur::layout::Sweep;
use pelage_gpu::{Buffer, Gpu, Kernel, Recorder, Scope};

/// Step 2: optical depths from the lattice to the lights.
pub struct UndercoatLight {
    main: Kernel,
}

impl UndercoatLight {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { main: Kernel::new(gpu, "undercoat_light", "main")? })
    }

    /// Fills `tau`, level by level from the top: `pairs` pairs of lights at each node of `columns` columns.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        columns: u32,
        levels: u32,
        pairs: u32,
    ) -> Result<Vec<Buffer>> {
        (0..=levels)
            .rev()
            .map(|level| {
                let sweep = gpu.uniform("sweep", &Sweep { level })?;
                recorder.dispatch(
                    &self.main,
                    &scope.with(&[&sweep]),
                    u64::from(columns) * u64::from(pairs),
                )?;
                Ok(sweep)
            })
            .collect()
    }
}
