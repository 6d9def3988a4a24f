//! The signals of Unix.

use std::os::raw::c_int;

use signal_hook::consts::{
    SIGABRT, SIGALRM, SIGBUS, SIGHUP, SIGINT, SIGIO, SIGPROF, SIGQUIT, SIGSYS, SIGTERM, SIGTRAP,
    SIGTSTP, SIGUSR1, SIGUSR2, SIGVTALRM, SIGXCPU, SIGXFSZ,
};
use signal_hook::iterator::Signals;

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

/// Calls `handle` on a thread of its own at every signal that would end the program.
pub fn on_each(handle: impl Fn() + Send + 'static) -> std::io::Result<()> {
    let ends = |signal: &c_int| *signal != SIGXFSZ || !a_full_file_is_an_error();
    let mut signals = Signals::new(ENDING.iter().filter(|signal| ends(signal)))?;
    for signal in more() {
        // The C library keeps some for itself, and a signal that cannot be had ends the program as ever.
        let _ = signals.handle().add_signal(signal);
    }
    std::thread::spawn(move || signals.forever().for_each(|_| handle()));
    Ok(())
}
