//! Steps 1 and 3: roots in batches that fit the budget, and the strands that grow from them.

use super::Prepared;
use pelage_core::{Error, Result, World};
use pelage_fur::groom;
use pelage_fur::layout::{Root, RootRange, StrandBatch};
use pelage_gpu::recorder::Timings;
use pelage_gpu::{Buffer, Buffers, Recorder, Scope};

/// Strands on the GPU.
pub struct Strands {
    /// Number of strands.
    pub count: u32,
    buffers: Buffers,
}

impl Strands {
    /// A buffer by its name: `roots`, `strand_vertices`, `shades`.
    ///
    /// # Errors
    /// [`Error::Gpu`] if there is none of that name; it lists the names that exist.
    pub fn buffer(&self, name: &str) -> Result<&Buffer> {
        self.buffers.get(name)
    }

    /// `scope` with `strand_batch`, `roots`, `strand_vertices` and `shades` added.
    pub fn scope<'a>(&'a self, scope: &Scope<'a>) -> Scope<'a> {
        self.buffers.add_to(scope)
    }
}

/// Bytes per strand on the GPU: root, vertices and shades.
pub fn strand_bytes(segments: u32) -> u64 {
    16 + (u64::from(segments) + 1) * 24
}

/// A range of triangles and the number of roots of each.
pub struct RootBatch {
    /// First triangle.
    pub first: u32,
    /// Roots of each triangle.
    pub counts: Vec<u32>,
    /// Their sum.
    pub strands: u64,
    density: f32,
    seed: u32,
}

impl Prepared<'_> {
    /// Counts the roots of all triangles and divides the triangles into ranges whose strands fit
    /// the budget.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if the strands of one triangle exceed it.
    pub(super) fn root_batches(&mut self, world: &World, timings: &mut Timings) -> Result<Vec<RootBatch>> {
        let gpu = self.gpu;
        let density = groom::guard_density(&world.scene);
        let seed = world.scene.render.seed;
        let counts = gpu.storage("root_counts", 1, u64::from(self.triangles) * 4)?;
        let range = RootRange { first: 0, count: self.triangles, density, seed };
        let range = gpu.uniform("root_range", &range)?;
        let mut recorder = Recorder::new(gpu);
        self.passes.hair_roots.record_count(
            &mut recorder,
            &self.scope().with(&[&counts, &range]),
            self.triangles,
        )?;
        recorder.submit(timings)?;
        let counts: Vec<u32> = gpu.read(&counts, u64::from(self.triangles) * 4)?;
        self.strands = counts.iter().map(|c| u64::from(*c)).sum();
        let vertex_limit = gpu.binding_limit() / (16 * (u64::from(self.segments) + 1));
        let most = (self.strand_budget / strand_bytes(self.segments)).min(vertex_limit).max(1);
        let mut batches: Vec<RootBatch> = Vec::new();
        for (triangle, count) in counts.iter().enumerate() {
            let fits = batches.last().is_some_and(|b| b.strands + u64::from(*count) <= most);
            if !fits {
                batches.push(RootBatch {
                    first: triangle as u32,
                    counts: Vec::new(),
                    strands: 0,
                    density,
                    seed,
                });
            }
            if let Some(last) = batches.last_mut() {
                last.counts.push(*count);
                last.strands += u64::from(*count);
            }
        }
        if let Some(big) = batches.iter().find(|b| b.strands > most) {
            return Err(Error::OutOfMemory {
                pass: "guard_strands".into(),
                needed: big.strands * strand_bytes(self.segments),
            });
        }
        Ok(batches)
    }

    /// Grows the strands of a range of triangles.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Gpu`].
    pub fn grow(&self, batch: &RootBatch, timings: &mut Timings) -> Result<Strands> {
        let roots = self.roots(batch, timings)?;
        self.grow_from(roots, batch.strands as u32, timings)
    }

    /// Draws the roots of a range of triangles.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Gpu`].
    pub fn roots(&self, batch: &RootBatch, timings: &mut Timings) -> Result<Buffer> {
        let gpu = self.gpu;
        let triangles = batch.counts.len() as u32;
        let first_roots: Vec<u32> = batch
            .counts
            .iter()
            .scan(0, |sum, c| {
                let first = *sum;
                *sum += c;
                Some(first)
            })
            .collect();
        let roots = gpu.storage("roots", 3, batch.strands * std::mem::size_of::<Root>() as u64)?;
        let (first, count) = (batch.first, triangles);
        let range = RootRange { first, count, density: batch.density, seed: batch.seed };
        let range = gpu.uniform("root_range", &range)?;
        let firsts = gpu.upload("first_roots", 1, &first_roots)?;
        let mut recorder = Recorder::new(gpu);
        let scope = self.scope().with(&[&range, &firsts, &roots]);
        self.passes.hair_roots.record_emit(&mut recorder, &scope, triangles)?;
        recorder.submit(timings)?;
        Ok(roots)
    }

    /// Grows strands from the first `count` of `roots`.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Gpu`].
    pub fn grow_from(&self, roots: Buffer, count: u32, timings: &mut Timings) -> Result<Strands> {
        let gpu = self.gpu;
        let vertices = u64::from(count) * (u64::from(self.segments) + 1);
        let batch = gpu.uniform("strand_batch", &StrandBatch { strands: count })?;
        let strand_vertices = gpu.storage("strand_vertices", 3, vertices * 16)?;
        let shades = gpu.storage("shades", 3, vertices * 8)?;
        let strands = Strands { count, buffers: vec![batch, roots, strand_vertices, shades].into() };
        let mut recorder = Recorder::new(gpu);
        self.passes.guard_strands.record(&mut recorder, &strands.scope(&self.scope()), count)?;
        recorder.submit(timings)?;
        Ok(strands)
    }

    /// Fills `shades` of strands; the light of step 2 must be finished.
    ///
    /// # Errors
    /// [`Error::Gpu`].
    pub fn shade(&self, strands: &Strands, timings: &mut Timings) -> Result<()> {
        let mut recorder = Recorder::new(self.gpu);
        self.passes.guard_shade.record(&mut recorder, &strands.scope(&self.scope()), strands.count)?;
        recorder.submit(timings)
    }
}
