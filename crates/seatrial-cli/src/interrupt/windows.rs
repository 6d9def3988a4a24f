//! Ctrl-C, Ctrl-Break, the end of the console's window, logging off, and shutting down.

use std::io;

use tokio::runtime::Builder;
use tokio::signal::windows::{ctrl_break, ctrl_c, ctrl_close, ctrl_logoff, ctrl_shutdown};

/// Calls `handle` on a thread of its own at everything that would end the program. Windows waits some seconds for a program whose window
/// is closed.
pub fn on_each(handle: impl Fn() + Send + 'static) -> io::Result<()> {
    let (mut c, mut pause) = (ctrl_c()?, ctrl_break()?);
    let (mut close, mut logoff, mut shutdown) = (ctrl_close()?, ctrl_logoff()?, ctrl_shutdown()?);
    let runtime = Builder::new_current_thread().build()?;
    std::thread::spawn(move || {
        runtime.block_on(async move {
            loop {
                tokio::select! {
                    _ = c.recv() => {}
                    _ = pause.recv() => {}
                    _ = close.recv() => {}
                    _ = logoff.recv() => {}
                    _ = shutdown.recv() => {}
                }
                handle();
            }
        });
    });
    Ok(())
}
