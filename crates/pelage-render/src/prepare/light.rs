//! Step 2: the optical depths towards the lights, and the light that march and strands look up.

use super::Prepared;
use super::objects::hierarchy;
use pelage_core::scene::FurLayers;
use pelage_core::{Result, World};
use pelage_fur::groom;
use pelage_fur::layout::Light;
use pelage_gpu::recorder::Timings;
use pelage_gpu::{Buffer, Gpu, Recorder};

impl Prepared<'_> {
    /// Computes the light in the fur: extinction at the nodes of the lattice, optical depths
    /// towards every light, and the light at each node, in which all lights but the key lights are
    /// folded into one radiance. Then shades the resident strands. `fibre_table`: the undercoat's
    /// scattering table, stored behind the nodes in `node_light`.
    pub(super) fn light(
        &mut self,
        world: &World,
        fibre_table: &[[u32; 2]],
        timings: &mut Timings,
    ) -> Result<()> {
        let nodes = self.nodes();
        let deposits = self.gpu.storage("deposits", 2, nodes * 4)?;
        let extinction = self.gpu.storage("lattice_extinction", 2, nodes * 4)?;
        if groom::has_guard(&world.scene) {
            self.deposit_guard_hairs(world, &deposits, &extinction, timings)?;
        }
        let mut recorder = Recorder::new(self.gpu);
        let scope = self.scope().with(&[&deposits, &extinction]);
        self.passes.guard_splat.record_normalise(&mut recorder, &scope, nodes)?;
        recorder.submit(timings)?;
        drop(deposits);
        let (tree, swept) = self.sweep(world, &extinction, fibre_table, timings)?;
        self.buffers.extend(swept);
        if !world.objects.is_empty() {
            // Objects are lit through it in every tile.
            self.buffers.extend(tree);
        }
        self.buffers.push(extinction);
        if world.scene.render.fur == FurLayers::Shells {
            // The hairs are in the textures; here they only attenuate light.
            self.resident = None;
            self.batches.clear();
        }
        if let Some(strands) = &self.resident {
            self.shade(strands, timings)?;
        }
        Ok(())
    }

    /// Deposits all guard hairs on the lattice; they stay resident if one batch holds them.
    fn deposit_guard_hairs(
        &mut self,
        world: &World,
        deposits: &Buffer,
        extinction: &Buffer,
        timings: &mut Timings,
    ) -> Result<()> {
        let batches = self.root_batches(world, timings)?;
        let single = batches.len() == 1;
        for batch in &batches {
            let strands = self.grow(batch, timings)?;
            let mut recorder = Recorder::new(self.gpu);
            let scope = strands.scope(&self.scope()).with(&[deposits, extinction]);
            self.passes.guard_splat.record_deposit(&mut recorder, &scope, strands.count)?;
            recorder.submit(timings)?;
            if single {
                self.resident = Some(strands);
            }
        }
        if !single {
            self.batches = batches;
        }
        Ok(())
    }

    /// Computes `tau`, `node_light` and `base_light`, and the hierarchy of what blocks light.
    fn sweep(
        &mut self,
        world: &World,
        extinction: &Buffer,
        fibre_table: &[[u32; 2]],
        timings: &mut Timings,
    ) -> Result<([Buffer; 2], [Buffer; 3])> {
        let gpu = self.gpu;
        let nodes = self.nodes();
        let columns = self.fur.lattice.columns;
        let tree = hierarchy(gpu, world)?;
        let tau = gpu.storage("tau", 2, nodes * u64::from(self.fur.lattice.tau_stride) * 4)?;
        let source = gpu.storage("node_light", 2, nodes * 16 + fibre_table.len() as u64 * 8)?;
        if !fibre_table.is_empty() {
            gpu.queue.write_buffer(&source.raw, nodes * 16, bytemuck::cast_slice(fibre_table));
        }
        let base_light = gpu.storage("base_light", 2, u64::from(columns) * 8)?;
        let counters = gpu.storage("light_counters", 2, 16)?;
        let mut recorder = Recorder::new(gpu);
        let scope = self
            .scope()
            .with(&[extinction, &tau, &source, &base_light, &counters])
            .with(&tree.iter().collect::<Vec<_>>());
        self.passes.light_occlusion.record(&mut recorder, &scope, columns)?;
        let pairs = groom::tau_pairs(self.fur.lights.count);
        let _sweeps = self.passes.undercoat_light.record(
            gpu,
            &mut recorder,
            &scope,
            columns,
            self.fur.lattice.levels,
            pairs,
        )?;
        self.passes.undercoat_source.record(&mut recorder, &scope, nodes)?;
        recorder.submit(timings)?;
        self.light_paths_cut = u64::from(gpu.read::<u32>(&counters, 4)?.first().copied().unwrap_or(0));
        Ok((tree, [tau, source, base_light]))
    }
}

/// Uploads the lights as the uniform `lights`.
pub(super) fn upload_lights(gpu: &Gpu, lights: &[Light]) -> Result<Buffer> {
    let mut all = <pelage_fur::layout::Lights as bytemuck::Zeroable>::zeroed();
    all.lights[..lights.len()].copy_from_slice(lights);
    gpu.uniform("lights", &all)
}
