//! Step 1: neighbours of the triangles over their edges, by a hash table over 64-bit keys of
//! directed edges.
// Source: [Andersen2016] sec. 3.2.

use pelage_core::Result;
use pelage_fur::layout::EdgeCounts;
use pelage_gpu::{Buffer, Gpu, Kernel, Recorder, Scope};

/// The kernels of `edge_table`.
pub struct EdgeTable {
    insert: Kernel,
    lookup: Kernel,
}

impl EdgeTable {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of an error in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            insert: Kernel::new(gpu, "edge_table", "insert")?,
            lookup: Kernel::new(gpu, "edge_table", "lookup")?,
        })
    }

    /// Fills `neighbours` for `edges` directed edges, three per triangle. Returns the buffers that
    /// must live until the recording is submitted.
    ///
    /// In scope: `triangles`, `neighbours`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a name is not in scope, [`pelage_core::Error::OutOfMemory`]
    /// if the table does not fit.
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        edges: u32,
    ) -> Result<[Buffer; 3]> {
        // At most half full, so that probes stay short.
        let slots_len = (2 * u64::from(edges)).next_power_of_two().max(16);
        let counts = gpu.uniform("edge_counts", &EdgeCounts { edges, mask: slots_len as u32 - 1 })?;
        let slots = gpu.storage("slots", 1, slots_len * 4)?;
        let owners = gpu.storage("owners", 1, slots_len * 4)?;
        let scope = scope.with(&[&counts, &slots, &owners]);
        recorder.dispatch(&self.insert, &scope, u64::from(edges))?;
        recorder.dispatch(&self.lookup, &scope, u64::from(edges))?;
        Ok([counts, slots, owners])
    }
}
