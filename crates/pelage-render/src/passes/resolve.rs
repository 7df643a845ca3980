//! Step 7: resolves the list of fragments of each sample to a film sample, in order of depth.
// Sources: [Andersen2016] eq. 4 for shell fragments; the exact mode is ours.

use super::Variant;
use pelage_core::Result;
use pelage_fur::layout::SortRun;
use pelage_gpu::{Buffer, Gpu, Kernel, Recorder, Scope};

/// The kernels of `resolve`.
pub struct Resolve {
    exact: Kernel,
    blend_fragments: Kernel,
    merge_runs: Kernel,
}

impl Resolve {
    /// Compiles the kernels of a variant of the march.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        let constants = variant.constants();
        Ok(Self {
            exact: Kernel::specialised(gpu, "resolve", "exact", &constants)?,
            blend_fragments: Kernel::specialised(gpu, "resolve", "blend_fragments", &constants)?,
            merge_runs: Kernel::specialised(gpu, "resolve", "merge_runs", &constants)?,
        })
    }

    /// Resolves the lists of `samples` samples. `exact`: marches the undercoat between the
    /// fragments; otherwise blends stored fragments.
    ///
    /// In scope: `frame`, `fur`, `base_records`, `fragment_lists`, `samples`, `march_counters`; for
    /// `exact` also `noise`, `shell_vertices`, `prisms`, `media_or_uv`, `node_light`,
    /// `undercoat_fibre`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        samples: u64,
        exact: bool,
    ) -> Result<()> {
        recorder.dispatch(if exact { &self.exact } else { &self.blend_fragments }, scope, samples)
    }

    /// Sorts the lists of `samples` samples, of which the longest has `longest` fragments, in order
    /// of depth. A frame of which [`FLAG_SORTED_LISTS`](pelage_fur::camera::FLAG_SORTED_LISTS) is
    /// set then lets [`Resolve::record`] read them in fewer rounds. Returns the buffers that must
    /// live until the recording is submitted.
    ///
    /// In scope: `frame`, `lists_to_sort`, which are `fragment_lists`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope.
    pub fn record_sort(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        samples: u64,
        longest: u64,
    ) -> Result<Vec<Buffer>> {
        (0..32)
            .map(|digit| 1u32 << digit)
            .take_while(|length| u64::from(*length) < longest)
            .map(|length| {
                let run = gpu.uniform("sort_run", &SortRun { length })?;
                recorder.dispatch(&self.merge_runs, &scope.with(&[&run]), samples)?;
                Ok(run)
            })
            .collect()
    }
}
