//! Ctrl-C, and the signals that ask a program to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use crate::output::Failure;

/// Calls `handle` on a thread of its own at every SIGINT, SIGTERM and SIGHUP, which from now on do not end the program.
pub fn on_interrupt(handle: impl Fn() + Send + 'static) -> Result<(), Failure> {
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP]).map_err(Failure::internal)?;
    std::thread::spawn(move || signals.forever().for_each(|_| handle()));
    Ok(())
}

/// True from the first such signal on.
pub fn interrupted() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&stop);
    on_interrupt(move || set.store(true, Ordering::Relaxed))?;
    Ok(stop)
}
