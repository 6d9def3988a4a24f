//! Prints the parity vectors as this processor computes them.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use seatrial_firmware::{Console, finish};

#[entry]
fn main() -> ! {
    let mut console = Console::open();
    #[cfg(feature = "panic-path")]
    panic_where_the_compiler_cannot_tell();
    finish(seatrial_parity::write_all(&mut console))
}

#[cfg(feature = "panic-path")]
fn panic_where_the_compiler_cannot_tell() {
    let digits = [0_u8; 4];
    let place = core::hint::black_box(9_usize);
    core::hint::black_box(digits[place]);
}
