//! Interrupts: while there is a partial result, the first one asks for it to be written; otherwise,
//! and the second time, the process ends at once.

use pelage::{Error, Result};
use pelage_core::files;
use std::sync::atomic::{AtomicBool, Ordering};

static CANCEL: AtomicBool = AtomicBool::new(false);

/// Whether an interrupt now would lose a partial result.
static PARTIAL: AtomicBool = AtomicBool::new(false);

/// Starts to listen for SIGINT, SIGTERM and SIGHUP.
///
/// Loading, preparation, baking and so on have nothing to keep, so they need not be asked to stop:
/// whatever they are doing, the process ends, and files that are being written are removed.
pub(super) fn listen() -> Result<()> {
    // The waits for the GPU end when the flag is set, however long a pass takes.
    pelage_gpu::end_waits_by(&CANCEL);
    ctrlc::set_handler(|| {
        let second = CANCEL.swap(true, Ordering::SeqCst);
        if second || !PARTIAL.load(Ordering::SeqCst) {
            files::remove_temporaries();
            eprintln!("interrupted");
            quit();
        }
        eprintln!("interrupted: the partial result is written; interrupt again to quit at once");
    })
    .map_err(|e| Error::io("signals", format!("cannot listen for interrupts: {e}")))
}

/// The flag that the first interrupt sets.
pub(super) fn flag() -> &'static AtomicBool {
    &CANCEL
}

/// Whether from now on an interrupt would lose a partial result.
pub(super) fn partial(there_is: bool) {
    PARTIAL.store(there_is, Ordering::SeqCst);
}

/// Ends the process without running what the libraries have registered for its end: drivers may
/// still be computing in threads of their own, which must not meet destroyed state.
pub(super) fn quit() -> ! {
    signal_hook::low_level::exit(i32::from(Error::Interrupted.exit_code()))
}
