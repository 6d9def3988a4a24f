//! The functions by which a program enters the library, under names that say its ABI and the size of its numbers: a header
//! of another library, or with `SEATRIAL_SINGLE` for a library of doubles, does not link.
//!
//! The header renames them (`cbindgen.toml`). Every other function takes an object that only these make.

use core::ffi::c_void;

use crate::*;

/// Version of the sizes and layouts in the header. It goes up with every change of them that a program notices.
pub const SEATRIAL_ABI: u32 = 1;
/// The library's version.
pub const SEATRIAL_VERSION_MAJOR: u32 = 0;
/// The library's version.
pub const SEATRIAL_VERSION_MINOR: u32 = 3;
/// The library's version.
pub const SEATRIAL_VERSION_PATCH: u32 = 0;

/// Is the library of the header's ABI and numbers: `seatrial_check_abi(SEATRIAL_ABI, sizeof(SeatrialNumber))`?
/// SEATRIAL_STATUS_WRONG_LIBRARY where it is not. For programs that look functions up while they run; any other does not
/// link with the wrong library.
#[unsafe(no_mangle)]
pub extern "C" fn seatrial_check_abi(abi: u32, number_bytes: usize) -> SeatrialStatus {
    if abi == SEATRIAL_ABI && number_bytes == size_of::<SeatrialNumber>() {
        SeatrialStatus::Ok
    } else {
        SeatrialStatus::WrongLibrary
    }
}

macro_rules! entry_point {
    ($name:ident as $single:ident or $double:ident, $($argument:ident: $kind:ty),+) => {
        #[cfg(feature = "single")]
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $single($($argument: $kind),+) -> SeatrialStatus {
            // SAFETY: the caller's promise.
            unsafe { $name($($argument),+) }
        }

        #[cfg(not(feature = "single"))]
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $double($($argument: $kind),+) -> SeatrialStatus {
            // SAFETY: the caller's promise.
            unsafe { $name($($argument),+) }
        }
    };
}

entry_point!(seatrial_plan as seatrial_plan_abi1_single or seatrial_plan_abi1_double,
    time_constant_s: f64, sample_interval_s: f64, plan: *mut SeatrialPlan);
entry_point!(seatrial_trial_new as seatrial_trial_new_abi1_single or seatrial_trial_new_abi1_double,
    memory: *mut c_void, size: usize, plan: *const SeatrialPlan, trial: *mut *mut SeatrialTrial,
    fault: *mut SeatrialFault);
entry_point!(seatrial_estimator_settings as seatrial_estimator_settings_abi1_single
    or seatrial_estimator_settings_abi1_double,
    lambda_rad_s: SeatrialNumber, settings: *mut SeatrialEstimatorSettings);
entry_point!(seatrial_estimator_settings_paper as seatrial_estimator_settings_paper_abi1_single
    or seatrial_estimator_settings_paper_abi1_double,
    settings: *mut SeatrialEstimatorSettings);
entry_point!(seatrial_estimator_new as seatrial_estimator_new_abi1_single or seatrial_estimator_new_abi1_double,
    memory: *mut c_void, size: usize, settings: *const SeatrialEstimatorSettings,
    estimator: *mut *mut SeatrialEstimator, fault: *mut SeatrialFault);
entry_point!(seatrial_fixed_rate_settings as seatrial_fixed_rate_settings_abi1_single
    or seatrial_fixed_rate_settings_abi1_double,
    lambda_rad_s: SeatrialNumber, sample_interval_s: SeatrialNumber, settings: *mut SeatrialFixedRateSettings);
entry_point!(seatrial_fixed_rate_new as seatrial_fixed_rate_new_abi1_single or seatrial_fixed_rate_new_abi1_double,
    memory: *mut c_void, size: usize, settings: *const SeatrialFixedRateSettings,
    heading_rad: SeatrialNumber, rudder_rad: SeatrialNumber,
    estimator: *mut *mut SeatrialFixedRate, fault: *mut SeatrialFault);
entry_point!(seatrial_heading_gain as seatrial_heading_gain_abi1_single or seatrial_heading_gain_abi1_double,
    model: *const SeatrialModel, damping_ratio: SeatrialNumber, gain: *mut SeatrialHeadingGain);
entry_point!(seatrial_turn as seatrial_turn_abi1_single or seatrial_turn_abi1_double,
    model: *const SeatrialModel, rudder_limit_rad: SeatrialNumber, surge_speed_m_s: SeatrialNumber,
    to_starboard: bool, turn: *mut SeatrialTurn);
entry_point!(seatrial_schedule_lookup as seatrial_schedule_lookup_abi1_single or seatrial_schedule_lookup_abi1_double,
    points: *const SeatrialSchedulePoint, count: usize, key: u32, at: SeatrialNumber, extrapolate: bool,
    found: *mut SeatrialSchedulePoint, extrapolated: *mut bool);
entry_point!(seatrial_schedule_gain as seatrial_schedule_gain_abi1_single or seatrial_schedule_gain_abi1_double,
    points: *const SeatrialSchedulePoint, count: usize, key: u32, damping_ratio: SeatrialNumber,
    at: SeatrialNumber, extrapolate: bool, gain: *mut SeatrialHeadingGain, extrapolated: *mut bool);
