//! Ctrl-C, and the signals that ask a program to end.

use std::os::raw::c_int;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use signal_hook::consts::{
    SIGABRT, SIGALRM, SIGBUS, SIGHUP, SIGINT, SIGIO, SIGPROF, SIGQUIT, SIGSYS, SIGTERM, SIGTRAP,
    SIGTSTP, SIGUSR1, SIGUSR2, SIGVTALRM, SIGXCPU, SIGXFSZ,
};
use signal_hook::iterator::Signals;

use crate::standard_error;

/// Every signal that ends or suspends a program and can be caught. The kernel sends ILL, FPE and SEGV where the program itself is at fault.
const ENDING: [c_int; 17] = [
    SIGABRT, SIGALRM, SIGBUS, SIGHUP, SIGINT, SIGIO, SIGPROF, SIGQUIT, SIGSYS, SIGTERM, SIGTRAP,
    SIGTSTP, SIGUSR1, SIGUSR2, SIGVTALRM, SIGXCPU, SIGXFSZ,
];

/// STKFLT, PWR and the real-time signals, which the C library leaves to programs.
#[cfg(target_os = "linux")]
fn more() -> impl Iterator<Item = c_int> {
    [16, 30].into_iter().chain(34..=64)
}

#[cfg(not(target_os = "linux"))]
fn more() -> impl Iterator<Item = c_int> {
    std::iter::empty()
}

/// Has whoever began this program had XFSZ ignored? Then a file that may grow no further is an error of the write, as a full disk is.
fn a_full_file_is_an_error() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    ignored.is_some_and(|mask| mask >> (SIGXFSZ - 1) & 1 == 1)
}

static ASKED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Calls `handle` on a thread of its own at every signal that would end the program, and from now on waits for no standard error.
pub fn on_interrupt(handle: impl Fn() + Send + 'static) -> std::io::Result<()> {
    standard_error::detach();
    let ends = |signal: &c_int| *signal != SIGXFSZ || !a_full_file_is_an_error();
    let mut signals = Signals::new(ENDING.iter().filter(|signal| ends(signal)))?;
    for signal in more() {
        // The C library keeps some for itself, and a signal that cannot be had ends the program as ever.
        let _ = signals.handle().add_signal(signal);
    }
    std::thread::spawn(move || signals.forever().for_each(|_| handle()));
    Ok(())
}

/// True from the first such signal on.
pub fn interrupted() -> std::io::Result<Arc<AtomicBool>> {
    let stop = Arc::clone(ASKED.get_or_init(Arc::default));
    let set = Arc::clone(&stop);
    on_interrupt(move || set.store(true, Ordering::Relaxed))?;
    Ok(stop)
}

/// Has such a signal come, where it does not end the program?
pub fn is_asked() -> bool {
    ASKED
        .get()
        .is_some_and(|asked| asked.load(Ordering::Relaxed))
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
