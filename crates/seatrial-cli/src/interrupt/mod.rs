//! Ctrl-C, and what else asks a program to end.

#[cfg(unix)]
#[path = "unix.rs"]
mod platform;
#[cfg(windows)]
#[path = "windows.rs"]
mod platform;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use crate::standard_error;

static ASKED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Calls `handle` on a thread of its own whenever the program is asked to end, and from now on waits for no standard error.
pub fn on_interrupt(handle: impl Fn() + Send + 'static) -> std::io::Result<()> {
    standard_error::detach();
    platform::on_each(handle)
}

/// True from the first time on that the program is asked to end.
pub fn interrupted() -> std::io::Result<Arc<AtomicBool>> {
    let stop = Arc::clone(ASKED.get_or_init(Arc::default));
    let set = Arc::clone(&stop);
    on_interrupt(move || set.store(true, Ordering::Relaxed))?;
    Ok(stop)
}

/// Was the program asked to end, where that does not end it at once?
pub fn is_asked() -> bool {
    ASKED.get().is_some_and(|asked| asked.load(Ordering::Relaxed))
}

/// Longest a file may still be written once the program was asked to end.
const STILL_WRITTEN: Duration = Duration::from_secs(2);

/// What a job gives that a disk or a pipe may hold up for good; `None` where the program was asked to end meanwhile.
pub fn unless_asked<T: Send + 'static>(job: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    let (tell, told) = channel();
    std::thread::spawn(move || tell.send(job()));
    let look = Duration::from_millis(50);
    let mut asked_for = Duration::ZERO;
    while asked_for < STILL_WRITTEN {
        match told.recv_timeout(look) {
            Ok(done) => return Some(done),
            Err(RecvTimeoutError::Timeout) if is_asked() => asked_for += look,
            Err(RecvTimeoutError::Timeout) => {}
            // The job has panicked, and said so.
            Err(RecvTimeoutError::Disconnected) => return None,
        }
    }
    None
}
