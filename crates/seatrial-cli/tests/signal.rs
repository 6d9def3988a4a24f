//! Signals to processes.

use std::process::Command;

/// Sends a signal, as `"INT"`, to a process by the shell's own `kill`: the smallest systems have no program of that name.
pub fn send(process: u32, signal: &str) {
    let kill = format!("kill -{signal} {process}");
    let sent = Command::new("sh").args(["-c", &kill]).status();
    assert!(sent.expect("a shell").success(), "{kill}");
}
