//! Step 5: the march that stores fragments of the undercoat, for the blending modes that need them:
//! one shell fragment per entry, or virtual fragments.
// Source: [Andersen2016] sec. 3.2 and 3.3.

use super::Variant;
use pelage_core::Result;
use pelage_gpu::{Gpu, Kernel, Recorder, Scope};

/// The kernel of `undercoat_march`.
pub struct UndercoatMarch {
    main: Kernel,
}

impl UndercoatMarch {
    /// Compiles the kernels of a variant of the march.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        let constants = variant.constants();
        Ok(Self { main: Kernel::specialised(gpu, "undercoat_march", "main", &constants)? })
    }

    /// Marches from the entries in the lists of `samples` samples and adds fragments to the lists.
    ///
    /// In scope: `frame`, `fur`, `noise`, `shell_vertices`, `prisms`, `media_or_uv`, `node_light`,
    /// `undercoat_fibre`, `base_records`, `fragment_lists`, `march_counters`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, samples: u64) -> Result<()> {
        recorder.dispatch(&self.main, scope, samples)
    }
}
