//! Ctrl-C: the first one asks the rendering to end after its current chunk, the second one ends the process.

use pelage_core::{Error, Result};
use std::sync::atomic::{AtomicBool, Ordering};

static CANCEL: AtomicBool = AtomicBool::new(false);

/// Starts listening for SIGINT, SIGTERM and SIGHUP and returns the flag that the first one raises.
pub(super) fn listen() -> Result<&'static AtomicBool> {
    ctrlc::set_handler(|| {
        if CANCEL.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(Error::Interrupted.exit_code()));
        }
        eprintln!(
            "interrupted: writing what there is after the current chunk; interrupt again to quit at once"
        );
    })
    .map_err(|e| Error::io("signals", format!("cannot listen for interrupts: {e}")))?;
    Ok(&CANCEL)
}
