#![doc = include_str!("../README.md")]
#![cfg_attr(not(feature = "std"), no_std)]
#![allow(clippy::missing_safety_doc)]

mod control;
mod entry_points;
mod estimator;
mod fixed_rate;
mod memory;
mod plan;
mod status;
mod trial;

pub use control::*;
pub use entry_points::*;
pub use estimator::*;
pub use fixed_rate::*;
pub use plan::*;
pub use status::*;
pub use trial::*;

/// A number that is no time.
#[cfg(not(feature = "single"))]
pub type SeatrialNumber = f64;
/// A number that is no time.
#[cfg(feature = "single")]
pub type SeatrialNumber = f32;

#[cfg(not(feature = "std"))]
mod panic {
    unsafe extern "C" {
        /// Defined nowhere: a program with a panic path does not link.
        fn seatrial_has_a_panic_path() -> !;
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        // SAFETY: never linked, hence never called.
        unsafe { seatrial_has_a_panic_path() }
    }
}
