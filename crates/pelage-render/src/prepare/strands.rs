//! Steps 1 and 3: roots in batches that fit the budget, and the strands that grow from them.

use super::Prepared;
use pelage_core::{Error, Result, Skin, World};
use pelage_fur::groom;
use pelage_fur::hair_roots::PART;
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

/// Bytes of a shaded vertex.
fn shade_bytes(features: bool) -> u64 {
    if features { 16 } else { 8 }
}

/// Bytes per strand on the GPU: root, vertices and shades.
pub fn strand_bytes(segments: u32, features: bool) -> u64 {
    16 + (u64::from(segments) + 1) * (16 + shade_bytes(features))
}

/// A range of parts of triangles and the number of roots of each. Most triangles have one part;
/// those with many candidates have more.
pub struct RootBatch {
    /// First part.
    pub first: u32,
    /// Roots of each part.
    pub counts: Vec<u32>,
    /// Their sum.
    pub strands: u64,
    /// Parts of each triangle.
    parts: u32,
    density: f32,
    seed: u32,
}

/// Area of the largest triangle, cm².
fn largest_triangle(skin: &Skin) -> f32 {
    (0..skin.triangles.len()).map(|t| skin.triangle_area(t)).fold(0.0, f32::max)
}

/// The parts `[first, count]`.
fn root_range([first, count]: [u32; 2], density: f32, seed: u32, parts: u32) -> RootRange {
    RootRange { first, count, density, seed, parts, padding: 0, more_padding: [0; 2] }
}

impl Prepared<'_> {
    /// Counts the roots of all triangles and divides them into ranges whose strands fit the budget.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if the strands of one part of a triangle exceed it, or the parts one
    /// binding.
    pub(super) fn root_batches(&mut self, world: &World, timings: &mut Timings) -> Result<Vec<RootBatch>> {
        let gpu = self.gpu;
        let density = groom::guard_density(&world.scene);
        let seed = world.scene.render.seed;
        // The number of candidates may be one more.
        let parts = ((largest_triangle(&world.skin) * density) as u32 / PART).saturating_add(1);
        let all = u64::from(self.triangles) * u64::from(parts);
        let total = u32::try_from(all)
            .map_err(|_| Error::OutOfMemory { pass: "hair_roots".into(), needed: all * 4 })?;
        let counts = gpu.storage("root_counts", 1, all * 4)?;
        let range = root_range([0, total], density, seed, parts);
        let range = gpu.uniform("root_range", &range)?;
        let mut recorder = Recorder::new(gpu);
        self.passes.hair_roots.record_count(&mut recorder, &self.scope().with(&[&counts, &range]), total)?;
        recorder.submit(timings)?;
        let counts: Vec<u32> = gpu.read(&counts, all * 4)?;
        self.strands = counts.iter().map(|c| u64::from(*c)).sum();
        let vertex_limit = gpu.binding_limit() / (16 * (u64::from(self.segments) + 1));
        let bytes = strand_bytes(self.segments, self.variant.features);
        let most = (self.strand_budget / bytes).min(vertex_limit).max(1);
        let mut batches: Vec<RootBatch> = Vec::new();
        for (part, count) in counts.iter().enumerate() {
            let fits = batches.last().is_some_and(|b| b.strands + u64::from(*count) <= most);
            if !fits {
                batches.push(RootBatch {
                    first: part as u32,
                    counts: Vec::new(),
                    strands: 0,
                    parts,
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
            return Err(Error::OutOfMemory { pass: "guard_strands".into(), needed: big.strands * bytes });
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
        let parts = batch.counts.len() as u32;
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
        let range = root_range([batch.first, parts], batch.density, batch.seed, batch.parts);
        let range = gpu.uniform("root_range", &range)?;
        let firsts = gpu.upload("first_roots", 1, &first_roots)?;
        let mut recorder = Recorder::new(gpu);
        let scope = self.scope().with(&[&range, &firsts, &roots]);
        self.passes.hair_roots.record_emit(&mut recorder, &scope, parts)?;
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
        let shades = gpu.storage("shades", 3, vertices * shade_bytes(self.variant.features))?;
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
