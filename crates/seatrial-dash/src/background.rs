//! Threads that the trial goes before.

/// How nice the server's threads are: where they and the trial want the same core, they get a tenth of it.
#[cfg(target_os = "linux")]
const NICE: i32 = 10;

/// Lets every other thread go before this one. A thread that it starts is as nice.
pub fn go_last() {
    // Nicer is what everybody may be; elsewhere than on Linux only a whole process can.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(Some(rustix::thread::gettid()), NICE);
}
