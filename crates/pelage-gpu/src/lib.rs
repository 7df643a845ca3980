//! The GPU: one place for the adapter, its limits, kernels by reflection, counted memory and timed recordings.

pub mod adapter;
pub mod kernel;
pub mod memory;
pub mod recorder;
pub mod shader;

pub use adapter::{AdapterSummary, list_adapters};
pub use kernel::{Kernel, RasterKernel, Resource, Scope};
pub use memory::{Buffer, Buffers, Ledger};
pub use recorder::Recorder;
pub use shader::Sources;

use pelage_core::{Error, Result};
use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// An open device with everything that the passes need of it.
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name, driver, type.
    pub info: wgpu::AdapterInfo,
    /// Limits granted.
    pub limits: wgpu::Limits,
    /// Whether passes can be timed.
    pub timestamps: bool,
    /// The adapter is the CPU: passes are timed by the clock, one by one.
    pub software: bool,
    /// Allocations alive and their peak.
    pub ledger: Arc<Ledger>,
    faults: Arc<Mutex<Faults>>,
    /// Where the texts of shaders are found.
    sources: Sources,
    kept: Mutex<HashMap<(TypeId, usize), Arc<dyn Any + Send + Sync>>>,
}

/// What the device reported outside any error scope.
#[derive(Default)]
struct Faults {
    lost: Option<String>,
    errors: Vec<String>,
    out_of_memory: bool,
}

impl Gpu {
    /// Opens the adapter that the environment asks for (WGPU_BACKEND, WGPU_ADAPTER_NAME, WGPU_POWER_PREF), for the shaders
    /// that `sources` finds.
    ///
    /// # Errors
    /// [`Error::Adapter`] if no adapter answers, none has the asked name, or its limits are below what the passes need.
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
        })
    }

    /// What `make` made for this `key` at the first call: kernels are compiled once a device and variant.
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

    /// An error if the device reported one since the last call; `during` names the pass.
    pub fn check(&self, during: &str) -> Result<()> {
        let faults = || self.faults.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if !faults().errors.is_empty() {
            // What is done with a lost device fails in many ways; that it is lost may be told only now.
            self.device.poll(wgpu::PollType::Poll).ok();
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

    /// Largest buffer that one binding can show, bytes.
    pub fn binding_limit(&self) -> u64 {
        self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size)
    }

    /// A storage buffer of `size` bytes, zeroed, counted under `step` of Table 1.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if it does not fit one binding or the device has no room.
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

    /// Reads a storage buffer back.
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
            // Nobody waits any more where the device was lost meanwhile.
            let _ = sender.send(r);
        });
        self.wait(buffer.name)?;
        // Another thread that waits on the same device may be the one that runs the callback, a moment later.
        match done.recv_timeout(std::time::Duration::from_secs(10)) {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(Error::gpu(buffer.name, e)),
            Err(_) => {
                return Err(Error::DeviceLost {
                    during: buffer.name.into(),
                    reason: "a read-back never came".into(),
                });
            }
        }
        let view = staging.raw.get_mapped_range(0..size).map_err(|e| Error::gpu(buffer.name, e))?;
        Ok(bytemuck::pod_collect_to_vec(&view[..bytes.min(buffer.size) as usize]))
    }

    /// Waits until everything submitted is done.
    ///
    /// # Errors
    /// [`Error::DeviceLost`] if the device is lost meanwhile.
    pub fn wait(&self, during: &str) -> Result<()> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| Error::DeviceLost { during: during.into(), reason: e.to_string() })?;
        self.check(during)
    }
}
