//! Step 2: the light at the nodes that the march looks up: optical depths of the two key lights and
//! one radiance for all others; and the light on the skin.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernel of `undercoat_source`.
pub struct UndercoatSource {
    main: Kernel,
}

impl UndercoatSource {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self {
            main: Kernel::specialised(
                gpu,
                "undercoat_source",
                "main",
                &[variant.undercoat(), variant.multiple()],
            )?,
        })
    }

    /// Fills `node_light` at `nodes` nodes and `base_light` at the columns; with multiple
    /// scattering by transport also the scattered radiance in `tau`.
    ///
    /// In scope: `frame`, `fur`, `lights`, `undercoat_fibre`, `shell_vertices`, `prisms`,
    /// `columns`, `tau`, `field_table`, `sent_table`, `response_table`, `table_sampler`,
    /// `node_light`, `base_light`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, nodes: u64) -> Result<()> {
        recorder.dispatch(&self.main, scope, nodes)
    }
}
