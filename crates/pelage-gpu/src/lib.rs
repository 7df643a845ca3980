//! The GPU layer: adapter and limits, kernels bound by reflection, counted memory, timed
//! recordings. It knows no pass.

pub mod adapter;
mod cancel;
pub mod kernel;
pub mod memory;
pub mod recorder;
pub mod shader;

pub use adapter::{AdapterSummary, list_adapters};
pub use cancel::end_waits_by;
pub use kernel::{Kernel, RasterKernel, Resource, Scope};
pub use memory::{Buffer, Buffers, Ledger};
pub use recorder::Recorder;
pub use shader::Sources;

use pelage_core::{Error, Result};
use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// An open device with its limits, the count of its memory, the shader sources and compiled passes.
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name, driver and type of the adapter.
    pub info: wgpu::AdapterInfo,
    /// Limits of the device.
    pub limits: wgpu::Limits,
    /// Whether passes can be timed.
    pub timestamps: bool,
    /// Whether the adapter runs on the CPU. Each pass is then submitted alone and timed by the wall
    /// clock.
    pub software: bool,
    /// Bytes allocated now and at peak.
    pub ledger: Arc<Ledger>,
    faults: Arc<Mutex<Faults>>,
    /// Finds the text of a shader by its name.
    sources: Sources,
    /// Results of [`Gpu::keep`] by type and key.
    kept: Mutex<HashMap<(TypeId, usize), Arc<dyn Any + Send + Sync>>>,
    /// Held while the device is polled: wgpu panics where a wait times out while another thread's
    /// finds the queue empty.
    polling: Mutex<()>,
}

/// Errors that the device reported outside error scopes.
#[derive(Default)]
struct Faults {
    lost: Option<String>,
    errors: Vec<String>,
    out_of_memory: bool,
}

impl Gpu {
    /// Opens the adapter that the environment selects (WGPU_BACKEND, WGPU_ADAPTER_NAME,
    /// WGPU_POWER_PREF); shaders are read from `sources`.
    ///
    /// # Errors
    /// [`Error::Adapter`] if there is no adapter, none of the requested name, its limits are below
    /// what the passes need, or it opens no device.
    pub fn open(sources: Sources) -> Result<Self> {
        let adapter = adapter::select()?;
        let info = adapter.get_info();
        let limits = adapter::limits_for(&adapter)?;
        let timestamps = adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("pelage"),
            required_features: if timestamps {
                wgpu::Features::TIMESTAMP_QUERY
            } else {
                wgpu::Features::empty()
            },
            required_limits: limits.clone(),
            ..Default::default()
        }))
        .map_err(|e| Error::Adapter(format!("{}: no device: {e}", info.name)))?;
        let faults = Arc::new(Mutex::new(Faults::default()));
        let seen = faults.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            if let Ok(mut faults) = seen.lock() {
                faults.out_of_memory |= matches!(error, wgpu::Error::OutOfMemory { .. });
                faults.errors.push(error.to_string());
            }
        }));
        let seen = faults.clone();
        device.set_device_lost_callback(move |_, message| {
            if let Ok(mut faults) = seen.lock() {
                faults.lost = Some(message);
            }
        });
        let software = info.device_type == wgpu::DeviceType::Cpu;
        Ok(Self {
            device,
            queue,
            info,
            limits,
            timestamps: timestamps || software,
            software,
            ledger: Arc::default(),
            faults,
            sources,
            kept: Mutex::default(),
            polling: Mutex::default(),
        })
    }

    /// The result of `make`, which is called once per type and `key` and its result kept with the
    /// device, so that kernels are compiled once per device and variant.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn keep<T: Send + Sync + 'static>(
        &self,
        key: usize,
        make: impl FnOnce() -> Result<T>,
    ) -> Result<Arc<T>> {
        let slot = (TypeId::of::<T>(), key);
        let kept = || self.kept.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let known = kept().get(&slot).cloned();
        if let Some(known) = known.and_then(|any| any.downcast().ok()) {
            return Ok(known);
        }
        let made = Arc::new(make()?);
        kept().insert(slot, made.clone());
        Ok(made)
    }

    /// Fails if the device has reported an error since the last call; `during` names the pass.
    ///
    /// # Errors
    /// [`Error::DeviceLost`], [`Error::OutOfMemory`] or [`Error::Gpu`].
    pub fn check(&self, during: &str) -> Result<()> {
        let faults = || self.faults.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if !faults().errors.is_empty() {
            // Calls on a lost device fail in many ways; the loss itself may be reported only by
            // this poll.
            self.poll(wgpu::PollType::Poll).ok();
        }
        let mut faults = faults();
        if let Some(reason) = faults.lost.clone() {
            return Err(Error::DeviceLost { during: during.into(), reason });
        }
        if std::mem::take(&mut faults.out_of_memory) {
            faults.errors.clear();
            return Err(Error::OutOfMemory { pass: during.into(), needed: self.ledger.current() });
        }
        match std::mem::take(&mut faults.errors).into_iter().next() {
            Some(reason) => Err(Error::gpu(during, reason)),
            None => Ok(()),
        }
    }

    fn poll(&self, how: wgpu::PollType) -> std::result::Result<wgpu::PollStatus, wgpu::PollError> {
        let _alone = self.polling.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        self.device.poll(how)
    }

    /// Size of the largest buffer that fits one binding, bytes.
    pub fn binding_limit(&self) -> u64 {
        self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size)
    }

    /// A zeroed storage buffer of `size` bytes, rounded up to a multiple of 16 and counted under
    /// row `step` of the paper's Table 1.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if it does not fit one binding or the device is out of memory.
    pub fn storage(&self, name: &'static str, step: u32, size: u64) -> Result<Buffer> {
        let size = size.max(16).next_multiple_of(16);
        if size > self.binding_limit() {
            return Err(Error::OutOfMemory { pass: name.into(), needed: size });
        }
        use wgpu::BufferUsages as U;
        self.allocate(name, step, size, U::STORAGE | U::COPY_SRC | U::COPY_DST)
    }

    /// A storage buffer that holds `data`.
    ///
    /// # Errors
    /// As [`Gpu::storage`].
    pub fn upload<T: bytemuck::NoUninit>(&self, name: &'static str, step: u32, data: &[T]) -> Result<Buffer> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let buffer = self.storage(name, step, bytes.len() as u64)?;
        self.queue.write_buffer(&buffer.raw, 0, bytes);
        Ok(buffer)
    }

    /// A uniform buffer that holds `value`.
    ///
    /// # Errors
    /// As [`Gpu::storage`].
    pub fn uniform<T: bytemuck::NoUninit>(&self, name: &'static str, value: &T) -> Result<Buffer> {
        let bytes = bytemuck::bytes_of(value);
        use wgpu::BufferUsages as U;
        let buffer =
            self.allocate(name, 0, (bytes.len() as u64).next_multiple_of(16), U::UNIFORM | U::COPY_DST)?;
        self.queue.write_buffer(&buffer.raw, 0, bytes);
        Ok(buffer)
    }

    fn allocate(
        &self,
        name: &'static str,
        step: u32,
        size: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<Buffer> {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let raw = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(name),
            size,
            usage,
            mapped_at_creation: false,
        });
        if pollster::block_on(scope.pop()).is_some() {
            return Err(Error::OutOfMemory { pass: name.into(), needed: size });
        }
        self.check(name)?;
        Ok(Buffer::new(raw, name, size, step, self.ledger.clone()))
    }

    /// Reads the first `bytes` bytes of a storage buffer back, after all submitted work.
    ///
    /// # Errors
    /// [`Error::DeviceLost`] or [`Error::Gpu`] if the copy fails.
    pub fn read<T: bytemuck::Pod>(&self, buffer: &Buffer, bytes: u64) -> Result<Vec<T>> {
        let size = bytes.min(buffer.size).next_multiple_of(4);
        use wgpu::BufferUsages as U;
        let staging = self.allocate("staging", 0, size.max(16), U::MAP_READ | U::COPY_DST)?;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&buffer.raw, 0, &staging.raw, 0, size);
        self.queue.submit([encoder.finish()]);
        let (sender, done) = std::sync::mpsc::channel();
        staging.raw.map_async(wgpu::MapMode::Read, 0..size, move |r| {
            // The receiver is gone if the device was lost meanwhile.
            let _ = sender.send(r);
        });
        self.wait(buffer.name)?;
        // Another thread that polls the same device may run the callback slightly later than this
        // one returns from its wait.
        match done.recv_timeout(std::time::Duration::from_secs(10)) {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(Error::gpu(buffer.name, e)),
            Err(_) => {
                return Err(Error::DeviceLost {
                    during: buffer.name.into(),
                    reason: "no buffer was read back within 10 s".into(),
                });
            }
        }
        let view = staging.raw.get_mapped_range(0..size).map_err(|e| Error::gpu(buffer.name, e))?;
        Ok(bytemuck::pod_collect_to_vec(&view[..bytes.min(buffer.size) as usize]))
    }

    /// Waits until all submitted work is done.
    ///
    /// # Errors
    /// [`Error::Interrupted`] if the flag of [`end_waits_by`] is set meanwhile: the work then goes
    /// on unobserved. [`Error::DeviceLost`] if the device is lost; else as [`Gpu::check`].
    pub fn wait(&self, during: &str) -> Result<()> {
        /// Time between two looks at the flag.
        const SLICE: std::time::Duration = std::time::Duration::from_millis(100);
        loop {
            match self.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(SLICE) }) {
                Ok(_) => return self.check(during),
                Err(wgpu::PollError::Timeout) if cancel::asked() => return Err(Error::Interrupted),
                Err(wgpu::PollError::Timeout) => {}
                Err(e) => return Err(Error::DeviceLost { during: during.into(), reason: e.to_string() }),
            }
        }
    }
}
