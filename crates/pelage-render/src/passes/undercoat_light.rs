//! Step 2: optical depths from every node of the lattice towards every light and towards the
//! camera, one dispatch per level from the top down.
// Cf. [YukselKeyser2008]

use pelage_core::Result;
use pelage_fur::layout::Sweep;
use pelage_gpu::{Buffer, Gpu, Kernel, Recorder, Scope};

/// The kernel of `undercoat_light`.
pub struct UndercoatLight {
    main: Kernel,
}

impl UndercoatLight {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { main: Kernel::new(gpu, "undercoat_light", "main")? })
    }

    /// Fills `tau` at all levels of `columns` columns, `pairs` pairs of lights at each node (the
    /// camera counts as a light). Returns the buffers that must live until the recording is
    /// submitted.
    ///
    /// In scope: `frame`, `fur`, `lights`, `shell_vertices`, `prisms`, `columns`,
    /// `lattice_extinction`, `tau`, `light_counters`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
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
