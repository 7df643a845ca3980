//! Recording of passes: labelled dispatches and draws, each of them timed.

use super::kernel::Target;
use super::{Buffer, Gpu, Kernel, RasterKernel, Scope};
use pelage_core::{Error, Result};
use std::collections::BTreeMap;

/// Timestamp queries per recording, two per pass. Passes beyond that have no time.
const QUERIES: u32 = 512;

/// Samples around the tile that the viewport also covers, so that triangles are not clipped at the
/// tile's edge. Must equal `RASTER_MARGIN` in `shaders/shared/frame.wgsl`.
pub const RASTER_MARGIN: f32 = 1024.0;

/// Times of passes by label (`stem.entry`), summed over recordings.
#[derive(Debug, Clone, Default)]
pub struct Timings {
    /// Milliseconds and number of dispatches; the time is `None` where the driver gives none.
    pub passes: BTreeMap<String, (Option<f64>, u64)>,
    /// Labels in the order of first use.
    pub order: Vec<String>,
}

impl Timings {
    fn add(&mut self, label: &str, ms: Option<f64>) {
        if !self.passes.contains_key(label) {
            self.order.push(label.to_owned());
        }
        let entry = self.passes.entry(label.to_owned()).or_insert((ms.map(|_| 0.0), 0));
        entry.0 = entry.0.zip(ms).map(|(a, b)| a + b);
        entry.1 += 1;
    }
}

/// The targets of raster passes.
pub struct RasterTargets<'a> {
    /// Colour target: triangle numbers or colours.
    pub ids: &'a wgpu::TextureView,
    /// Depth target.
    pub depth: &'a wgpu::TextureView,
    /// Samples that are drawn, from the upper left corner; the textures may be larger.
    pub size: [u32; 2],
}

/// A command buffer that is being recorded.
pub struct Recorder<'g> {
    gpu: &'g Gpu,
    encoder: wgpu::CommandEncoder,
    queries: Option<(wgpu::QuerySet, wgpu::Buffer)>,
    labels: Vec<String>,
    /// Milliseconds of each pass by the wall clock, on software adapters only: Mesa's timestamps no
    /// longer enclose compute passes once anything has been rasterised.
    clock: Vec<f64>,
}

impl<'g> Recorder<'g> {
    /// An empty recording.
    pub fn new(gpu: &'g Gpu) -> Self {
        let queries = (gpu.timestamps && !gpu.software).then(|| {
            let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: QUERIES,
            });
            let resolved = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: u64::from(QUERIES) * 8,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            (set, resolved)
        });
        Self {
            gpu,
            encoder: gpu.device.create_command_encoder(&Default::default()),
            queries,
            labels: Vec::new(),
            clock: Vec::new(),
        }
    }

    fn stamp(&mut self, label: &str) -> Option<(u32, u32)> {
        let first = 2 * self.labels.len() as u32;
        self.labels.push(label.to_owned());
        (self.queries.is_some() && first + 2 <= QUERIES).then_some((first, first + 1))
    }

    /// Records `invocations` invocations of `kernel` in workgroups of 64, folded to two dimensions
    /// where one does not hold them.
    ///
    /// # Errors
    /// [`Error::Gpu`] if a binding has no resource or two dimensions do not hold the dispatch.
    pub fn dispatch(&mut self, kernel: &Kernel, scope: &Scope<'_>, invocations: u64) -> Result<()> {
        if invocations == 0 {
            return Ok(());
        }
        let limit = u64::from(self.gpu.limits.max_compute_workgroups_per_dimension);
        let groups = invocations.div_ceil(64);
        let y = groups.div_ceil(limit);
        let x = groups.div_ceil(y);
        if y > limit || invocations > u64::from(u32::MAX) {
            return Err(Error::gpu(
                kernel.stem,
                format!("{invocations} invocations are too many for one dispatch"),
            ));
        }
        let bind_group = kernel.bind(self.gpu, scope)?;
        let stamp = self.stamp(&kernel.label);
        let writes =
            stamp.zip(self.queries.as_ref()).map(|((a, b), (set, _))| wgpu::ComputePassTimestampWrites {
                query_set: set,
                beginning_of_pass_write_index: Some(a),
                end_of_pass_write_index: Some(b),
            });
        let mut pass = self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(&kernel.label),
            timestamp_writes: writes,
        });
        pass.set_pipeline(&kernel.pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.dispatch_workgroups(x as u32, y as u32, 1);
        drop(pass);
        self.run_by_clock()
    }

    /// Records a draw of `vertices` vertices to cleared targets.
    ///
    /// # Errors
    /// [`Error::Gpu`] if a binding has no resource.
    pub fn draw(
        &mut self,
        kernel: &RasterKernel,
        scope: &Scope<'_>,
        targets: &RasterTargets<'_>,
        vertices: u32,
    ) -> Result<()> {
        self.draw_instances(kernel, scope, targets, [vertices, 1], true)
    }

    /// Records a draw of `instances` instances of `vertices` vertices each, in order. `clear`:
    /// clears the targets first.
    ///
    /// # Errors
    /// [`Error::Gpu`] if a binding has no resource.
    pub fn draw_instances(
        &mut self,
        kernel: &RasterKernel,
        scope: &Scope<'_>,
        targets: &RasterTargets<'_>,
        [vertices, instances]: [u32; 2],
        clear: bool,
    ) -> Result<()> {
        let bind_group = kernel.bind(self.gpu, scope)?;
        let stamp = self.stamp(&kernel.label);
        let writes =
            stamp.zip(self.queries.as_ref()).map(|((a, b), (set, _))| wgpu::RenderPassTimestampWrites {
                query_set: set,
                beginning_of_pass_write_index: Some(a),
                end_of_pass_write_index: Some(b),
            });
        let picture = kernel.target != Target::Records;
        let kept = matches!(kernel.target, Target::Color { .. });
        let color = [Some(wgpu::RenderPassColorAttachment {
            view: targets.ids,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: if clear { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load },
                store: wgpu::StoreOp::Store,
            },
        })];
        let mut pass = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&kernel.label),
            color_attachments: if picture { &color } else { &[] },
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: targets.depth,
                depth_ops: Some(wgpu::Operations {
                    load: if clear { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load },
                    store: if kept { wgpu::StoreOp::Store } else { wgpu::StoreOp::Discard },
                }),
                stencil_ops: None,
            }),
            timestamp_writes: writes,
            ..Default::default()
        });
        pass.set_pipeline(&kernel.pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        let [width, height] = targets.size.map(|s| s as f32 + 2.0 * RASTER_MARGIN);
        pass.set_viewport(-RASTER_MARGIN, -RASTER_MARGIN, width, height, 0.0, 1.0);
        pass.set_scissor_rect(0, 0, targets.size[0], targets.size[1]);
        pass.draw(0..vertices, 0..instances);
        drop(pass);
        self.run_by_clock()
    }

    /// On a software adapter, submits what was recorded and measures its time; does nothing
    /// otherwise.
    fn run_by_clock(&mut self) -> Result<()> {
        if !self.gpu.software {
            return Ok(());
        }
        let fresh = self.gpu.device.create_command_encoder(&Default::default());
        let recorded = std::mem::replace(&mut self.encoder, fresh).finish();
        let started = std::time::Instant::now();
        self.gpu.queue.submit([recorded]);
        self.gpu.wait(self.labels.last().map_or("", String::as_str))?;
        self.clock.push(started.elapsed().as_secs_f64() * 1e3);
        Ok(())
    }

    /// Records the zeroing of the first `bytes` bytes of a buffer.
    pub fn clear(&mut self, buffer: &Buffer, bytes: u64) {
        self.encoder.clear_buffer(&buffer.raw, 0, Some(bytes.min(buffer.size).next_multiple_of(4)));
    }

    /// Submits the recording, waits for it, and adds its times to `timings`.
    ///
    /// # Errors
    /// [`Error::DeviceLost`], [`Error::OutOfMemory`] or [`Error::Gpu`]; they name the last pass
    /// recorded.
    pub fn submit(mut self, timings: &mut Timings) -> Result<()> {
        let used = (2 * self.labels.len() as u32).min(QUERIES);
        let mut readback = None;
        if let Some((set, resolved)) = self.queries.as_ref().filter(|_| used > 0) {
            self.encoder.resolve_query_set(set, 0..used, resolved, 0);
            let staging = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: u64::from(QUERIES) * 8,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            self.encoder.copy_buffer_to_buffer(resolved, 0, &staging, 0, u64::from(used) * 8);
            readback = Some(staging);
        }
        let during = self.labels.last().cloned().unwrap_or_default();
        self.gpu.queue.submit([self.encoder.finish()]);
        if let Some(staging) = &readback {
            staging.map_async(wgpu::MapMode::Read, 0..u64::from(used) * 8, |_| {});
        }
        self.gpu.wait(&during)?;
        let period = f64::from(self.gpu.queue.get_timestamp_period()) * 1e-6;
        let ticks: Option<Vec<u64>> = readback.and_then(|staging| {
            let view = staging.get_mapped_range(0..u64::from(used) * 8).ok()?;
            Some(bytemuck::pod_collect_to_vec(&view))
        });
        for (i, label) in self.labels.iter().enumerate() {
            // Some drivers leave timestamps at zero: the time is then unknown, not zero.
            let ms = ticks
                .as_ref()
                .and_then(|t| t.get(2 * i).zip(t.get(2 * i + 1)))
                .filter(|(a, b)| **a != 0 && b >= a)
                .map(|(a, b)| (b - a) as f64 * period)
                .or_else(|| self.clock.get(i).copied());
            timings.add(label, ms);
        }
        Ok(())
    }
}
