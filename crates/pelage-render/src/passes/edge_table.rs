//! Step 1: neighbours over the edges.

use pelage_core::Result;
use pelage_fur::layout::EdgeCounts;
use pelage_gpu::{Buffer, Gpu, Kernel, Recorder, Scope};

/// Step 1: neighbours over the edges.
pub struct EdgeTable {
    insert: Kernel,
    lookup: Kernel,
}

impl EdgeTable {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            insert: Kernel::new(gpu, "edge_table", "insert")?,
            lookup: Kernel::new(gpu, "edge_table", "lookup")?,
        })
    }

    /// Fills `neighbours` for `edges` directed edges (three a triangle). In scope: `triangles`, `neighbours`.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing, [`pelage_core::Error::OutOfMemory`] without room for the table.
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
