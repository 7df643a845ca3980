//! Buffers that are counted while they live, and sets of them by name.

use super::Scope;
use pelage_core::{Error, Result};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// Bytes of GPU memory in buffers, now and at peak: in total and by row of the paper's Table 1.
#[derive(Debug, Default)]
pub struct Ledger(Mutex<Counts>);

#[derive(Debug, Default)]
struct Counts {
    current: u64,
    peak: u64,
    current_by_step: BTreeMap<u32, u64>,
    peak_by_step: BTreeMap<u32, u64>,
}

impl Ledger {
    fn with<R>(&self, f: impl FnOnce(&mut Counts) -> R) -> R {
        f(&mut self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
    }

    pub(super) fn add(&self, step: u32, bytes: u64) {
        self.with(|c| {
            c.current += bytes;
            c.peak = c.peak.max(c.current);
            let of_step = c.current_by_step.entry(step).or_default();
            *of_step += bytes;
            let now = *of_step;
            let peak = c.peak_by_step.entry(step).or_default();
            *peak = now.max(*peak);
        });
    }

    pub(super) fn remove(&self, step: u32, bytes: u64) {
        self.with(|c| {
            c.current = c.current.saturating_sub(bytes);
            if let Some(of_step) = c.current_by_step.get_mut(&step) {
                *of_step = of_step.saturating_sub(bytes);
            }
        });
    }

    /// Bytes allocated now.
    pub fn current(&self) -> u64 {
        self.with(|c| c.current)
    }

    /// Largest number of bytes allocated at once.
    pub fn peak(&self) -> u64 {
        self.with(|c| c.peak)
    }

    /// Restarts the peaks from what is allocated now.
    pub fn reset_peaks(&self) {
        self.with(|c| {
            c.peak = c.current;
            c.peak_by_step = c.current_by_step.clone();
        });
    }

    /// Largest number of bytes allocated at once for a row of the paper's Table 1.
    pub fn peak_of_step(&self, step: u32) -> u64 {
        self.with(|c| c.peak_by_step.get(&step).copied().unwrap_or(0))
    }
}

/// A GPU buffer that is counted while it lives.
pub struct Buffer {
    /// The buffer.
    pub raw: wgpu::Buffer,
    /// Name of the shader variable to which it is bound.
    pub name: &'static str,
    /// Bytes.
    pub size: u64,
    step: u32,
    ledger: Arc<Ledger>,
}

impl Buffer {
    pub(super) fn new(
        raw: wgpu::Buffer,
        name: &'static str,
        size: u64,
        step: u32,
        ledger: Arc<Ledger>,
    ) -> Self {
        ledger.add(step, size);
        Self { raw, name, size, step, ledger }
    }

    /// The same buffer under the name of another shader variable.
    pub fn renamed(mut self, name: &'static str) -> Self {
        self.name = name;
        self
    }
}

/// A set of buffers with different names.
#[derive(Default)]
pub struct Buffers(Vec<Buffer>);

impl Buffers {
    /// Adds a buffer; one of the same name is replaced.
    pub fn push(&mut self, buffer: Buffer) {
        self.0.retain(|known| known.name != buffer.name);
        self.0.push(buffer);
    }

    /// Adds buffers as [`Buffers::push`] does.
    pub fn extend(&mut self, buffers: impl IntoIterator<Item = Buffer>) {
        buffers.into_iter().for_each(|buffer| self.push(buffer));
    }

    /// A buffer by its name.
    ///
    /// # Errors
    /// [`Error::Gpu`] if there is none of that name; it lists the names of the set.
    pub fn get(&self, name: &str) -> Result<&Buffer> {
        self.0.iter().find(|buffer| buffer.name == name).ok_or_else(|| {
            let known: Vec<&str> = self.0.iter().map(|buffer| buffer.name).collect();
            Error::gpu(name, format!("there is no buffer of this name, only {known:?}"))
        })
    }

    /// `scope` with these buffers added; they replace earlier ones of the same names.
    pub fn add_to<'a>(&'a self, scope: &Scope<'a>) -> Scope<'a> {
        scope.with(&self.0.iter().collect::<Vec<_>>())
    }
}

impl From<Vec<Buffer>> for Buffers {
    fn from(buffers: Vec<Buffer>) -> Self {
        let mut all = Self::default();
        all.extend(buffers);
        all
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        self.ledger.remove(self.step, self.size);
        self.raw.destroy();
    }
}
