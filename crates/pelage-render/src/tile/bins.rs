//! Step 6: the strands of a tile, resident ones from bins, others grown for the tile.

use crate::plan::SamplePlan;
use crate::prepare::{Prepared, Strands};
use pelage_core::scene::Guard;
use pelage_core::{Result, World};
use pelage_fur::layout::{Bin, StrandBatch, TileGrid};
use pelage_gpu::recorder::Timings;
use pelage_gpu::{Buffer, Recorder, Scope};

/// The resident strands by tile: `counts[i]` entries of `list` from `starts[i]`.
pub(super) struct Bins {
    starts: Vec<u32>,
    counts: Vec<u32>,
    list: Buffer,
}

impl Bins {
    /// Sorts the resident strands into tiles of `edge` pixels; `None` if there are none.
    pub fn sort(
        prepared: &Prepared<'_>,
        world: &World,
        plan: &SamplePlan,
        edge: u32,
        timings: &mut Timings,
    ) -> Result<Option<Self>> {
        let Some(strands) = prepared.resident.as_ref().filter(|s| s.count > 0) else { return Ok(None) };
        let gpu = prepared.gpu;
        let film = &world.scene.film;
        let grid = [film.width.div_ceil(edge), film.height.div_ceil(edge)];
        let bins = u64::from(grid[0]) * u64::from(grid[1]);
        // Tiles extend by the filter's reach; displaced grids move strands by less than two
        // samples, lens points by the circle of confusion.
        let margin = plan.reach as f32 + 2.0 + plan.blur_margin(world);
        let size = [edge * plan.grid; 2];
        let tiles = TileGrid { origin: [0; 2], size, grid, margin, length: 0.0 };
        let tiles = gpu.uniform("tile_grid", &tiles)?;
        let frame = gpu.uniform("frame", &plan.frame(&world.scene, 0))?;
        let counts = gpu.storage("bin_counts", 6, bins * 4)?;
        let starts = gpu.storage("bin_starts", 6, bins * 4)?;
        let scope = strands.scope(&prepared.scope()).with(&[&tiles, &frame, &counts, &starts]);
        let mut recorder = Recorder::new(gpu);
        prepared.passes.guard_bins.record_count(&mut recorder, &scope, strands.count)?;
        recorder.submit(timings)?;
        let found: Vec<u32> = gpu.read(&counts, bins * 4)?;
        let first: Vec<u32> = found
            .iter()
            .scan(0u32, |sum, c| {
                let first = *sum;
                *sum += c;
                Some(first)
            })
            .collect();
        let total: u64 = found.iter().map(|c| u64::from(*c)).sum();
        gpu.queue.write_buffer(&starts.raw, 0, bytemuck::cast_slice(&first));
        let list = gpu.storage("bins", 6, total * 4)?;
        let mut recorder = Recorder::new(gpu);
        recorder.clear(&counts, bins * 4);
        prepared.passes.guard_bins.record_fill(&mut recorder, &scope.with(&[&list]), strands.count)?;
        recorder.submit(timings)?;
        Ok(Some(Self { starts: first, counts: found, list }))
    }
}

/// Source of the strands of step 6.
pub(super) struct StrandRaster<'a> {
    pub prepared: &'a Prepared<'a>,
    pub world: &'a World,
    /// `None` if strands are grown for each tile.
    pub bins: Option<&'a Bins>,
}

impl StrandRaster<'_> {
    /// Adds the fragments of the strands of bin `bin` to the lists of the tile of `frame` in
    /// `scope`.
    pub fn draw(&self, bin: u32, scope: &Scope<'_>, timings: &mut Timings) -> Result<()> {
        match (&self.prepared.resident, self.bins) {
            (Some(strands), Some(bins)) => {
                let range = Bin { start: bins.starts[bin as usize], strands: bins.counts[bin as usize] };
                self.draw_range(strands, &bins.list, range, scope, timings)
            }
            _ => self.grow_and_draw(scope, timings),
        }
    }

    /// Grows the strands that may touch the tile, batch by batch, and draws them.
    fn grow_and_draw(&self, scope: &Scope<'_>, timings: &mut Timings) -> Result<()> {
        let gpu = self.prepared.gpu;
        let length = self.longest();
        for batch in &self.prepared.batches {
            let roots = self.prepared.roots(batch, timings)?;
            let count = batch.strands as u32;
            let range = gpu.uniform("strand_batch", &StrandBatch { strands: count })?;
            let tile = TileGrid { origin: [0; 2], size: [1; 2], grid: [1; 2], margin: 4.0, length };
            let tile = gpu.uniform("tile_grid", &tile)?;
            let counts = gpu.storage("bin_counts", 6, 16)?;
            let list = gpu.storage("bins", 6, u64::from(count) * 4)?;
            let picked = gpu.storage("tile_roots", 3, u64::from(count) * 16)?;
            let mut recorder = Recorder::new(gpu);
            let gather = scope.with(&[&roots, &range, &tile, &counts, &list, &picked]);
            self.prepared.passes.guard_bins.record_gather(&mut recorder, &gather, count)?;
            recorder.submit(timings)?;
            drop(roots);
            let found = gpu.read::<u32>(&counts, 4)?.first().copied().unwrap_or(0);
            if found > 0 {
                let strands = self.prepared.grow_from(picked.renamed("roots"), found, timings)?;
                self.prepared.shade(&strands, timings)?;
                self.draw_range(&strands, &list, Bin { start: 0, strands: found }, scope, timings)?;
            }
        }
        Ok(())
    }

    /// Length of the longest strand including all displacements, cm.
    fn longest(&self) -> f32 {
        // Displacements go over from coat to coat, each at most the largest of its kind.
        let largest = |of: fn(&Guard) -> f32| self.world.scene.largest(|coat| of(coat.guard));
        1.3 * largest(|guard| guard.length.max())
            + 2.0 * (largest(|guard| guard.curl.max()) + largest(|guard| guard.frizz.max()))
            + largest(|guard| guard.clump.max() / guard.clump_density.max(1e-6).sqrt())
    }

    fn draw_range(
        &self,
        strands: &Strands,
        list: &Buffer,
        range: Bin,
        scope: &Scope<'_>,
        timings: &mut Timings,
    ) -> Result<()> {
        let uniform = self.prepared.gpu.uniform("bin", &range)?;
        let scope = strands.scope(scope).with(&[&uniform, list]);
        let mut recorder = Recorder::new(self.prepared.gpu);
        let pass = &self.prepared.passes.guard_raster;
        pass.record(&mut recorder, &scope, range.strands, self.prepared.segments)?;
        recorder.submit(timings)
    }
}
