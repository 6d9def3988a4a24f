//! Threads that the trial goes before.

/// The niceness of the server's threads: where they and the trial want the same core, they get a tenth of it.
#[cfg(target_os = "linux")]
const NICE: i32 = 10;

/// Lets every other thread go before this one. A thread that it starts is as nice.
pub fn go_last() {
    // Every user may raise the niceness of a thread; other systems than Linux know only that of a process.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(Some(rustix::thread::gettid()), NICE);
}
