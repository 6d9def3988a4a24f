//! What the programs for the Cortex-M share: text for the debugger, and the proof that nothing can panic.
#![no_std]

pub mod meter;

use core::fmt;

use cortex_m_semihosting::debug;
use cortex_m_semihosting::hio::{HostStream, hstdout};

unsafe extern "C" {
    /// Defined nowhere: an image that calls it does not link.
    fn seatrial_has_a_panic_path() -> !;
}

/// A linked image has no panic path: the linker keeps this function, whose callee does not exist,
/// only if something can call it.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    // SAFETY: never linked, hence never called.
    unsafe { seatrial_has_a_panic_path() }
}

/// Standard output of the host, a line at a time: each semihosting call stops the processor.
pub struct Console {
    stream: Option<HostStream>,
    line: [u8; 1024],
    len: usize,
}

impl Console {
    /// Opens the host's standard output.
    pub fn open() -> Self {
        Self { stream: hstdout().ok(), line: [0; 1024], len: 0 }
    }

    fn flush(&mut self) -> fmt::Result {
        let line = self.line.get(..self.len).unwrap_or_default();
        self.len = 0;
        self.stream.as_mut().ok_or(fmt::Error)?.write_all(line).map_err(|()| fmt::Error)
    }
}

impl fmt::Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            if self.len >= self.line.len() {
                self.flush()?;
            }
            if let Some(place) = self.line.get_mut(self.len) {
                *place = byte;
            }
            self.len += 1;
            if byte == b'\n' {
                self.flush()?;
            }
        }
        Ok(())
    }
}

/// Ends the emulation.
pub fn finish(result: fmt::Result) -> ! {
    debug::exit(match result {
        Ok(()) => debug::EXIT_SUCCESS,
        Err(fmt::Error) => debug::EXIT_FAILURE,
    });
    loop {
        cortex_m::asm::wfi();
    }
}
