//! Interrupts: the first asks the rendering to stop after its current chunk, the second ends the
//! process.

use pelage::{Error, Result};
use std::sync::atomic::{AtomicBool, Ordering};

static CANCEL: AtomicBool = AtomicBool::new(false);

/// Starts to listen for SIGINT, SIGTERM and SIGHUP; returns the flag that the first one sets.
pub(super) fn listen() -> Result<&'static AtomicBool> {
    ctrlc::set_handler(|| {
        if CANCEL.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(Error::Interrupted.exit_code()));
        }
        eprintln!(
            "interrupted: the partial result is written after the current chunk; interrupt again to quit at once"
        );
    })
    .map_err(|e| Error::io("signals", format!("cannot listen for interrupts: {e}")))?;
    Ok(&CANCEL)
}
