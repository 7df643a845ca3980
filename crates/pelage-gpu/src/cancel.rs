//! Ends the waits for the device when the process is asked to stop.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

static FLAG: OnceLock<&'static AtomicBool> = OnceLock::new();

/// From now on, waits for any device fail with
/// [`Error::Interrupted`](pelage_core::Error::Interrupted) while `flag` is true. The first flag of
/// the process stays.
pub fn end_waits_by(flag: &'static AtomicBool) {
    FLAG.get_or_init(|| flag);
}

/// Whether waits are to end.
pub(super) fn asked() -> bool {
    FLAG.get().is_some_and(|flag| flag.load(Ordering::Relaxed))
}
