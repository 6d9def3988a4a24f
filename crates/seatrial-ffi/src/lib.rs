//! seatrial-core for C.
//!
//! No heap: every object lives in memory of the caller, `SEATRIAL_..._BYTES` of it, aligned to 8 bytes. Every
//! function answers with a [`SeatrialStatus`]; nothing that a caller passes makes it panic, and a build without
//! `std` that had a panic path would not link. An object is not to be used by two threads at once.
//!
//! Numbers are `double`, times always; with the feature `single` (and `SEATRIAL_SINGLE` defined for the header) the
//! others are `float`. Units are SI, angles rad, and NaN stands for what is not measured or not known.
#![cfg_attr(not(feature = "std"), no_std)]
#![allow(clippy::missing_safety_doc)]

mod control;
mod estimator;
mod fixed_rate;
mod memory;
mod plan;
mod status;
mod trial;

pub use control::*;
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
