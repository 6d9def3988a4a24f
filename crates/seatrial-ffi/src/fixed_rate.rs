//! The lean estimator.

use core::ffi::c_void;

use seatrial_core::{FilterStart, FixedRateEstimator, FixedRateSettings, Hold, YawModel};

use crate::SeatrialNumber;
use crate::memory::{Kind, Object, Outcome, give, one_of, place, reach, refuse, status, take};
use crate::status::{SeatrialFault, SeatrialStatus};

/// The lean estimator for a loop of fixed rate: seatrial_core::FixedRateEstimator.
pub struct SeatrialFixedRate(FixedRateEstimator<SeatrialNumber>);

impl Kind for SeatrialFixedRate {
    const TAG: u32 = u32::from_be_bytes(*b"Slea");
}

/// Memory that a SeatrialFixedRate needs, bytes.
pub const SEATRIAL_FIXED_RATE_BYTES: usize = 208;
const _: () = assert!(size_of::<Object<SeatrialFixedRate>>() <= SEATRIAL_FIXED_RATE_BYTES);

/// First-order yaw model r' = a22 r + b2 delta + C0.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeatrialModel {
    /// a22, 1/s.
    pub a22_per_s: SeatrialNumber,
    /// b2, 1/s^2.
    pub b2_per_s2: SeatrialNumber,
    /// C0, rad/s^2.
    pub c0_rad_per_s2: SeatrialNumber,
}

impl From<YawModel<SeatrialNumber>> for SeatrialModel {
    fn from(model: YawModel<SeatrialNumber>) -> Self {
        Self {
            a22_per_s: model.a22_per_s,
            b2_per_s2: model.b2_per_s2,
            c0_rad_per_s2: model.c0_rad_per_s2,
        }
    }
}

impl From<SeatrialModel> for YawModel<SeatrialNumber> {
    fn from(model: SeatrialModel) -> Self {
        Self {
            a22_per_s: model.a22_per_s,
            b2_per_s2: model.b2_per_s2,
            c0_rad_per_s2: model.c0_rad_per_s2,
        }
    }
}

/// How a signal runs between two samples.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialHold {
    /// Constant.
    ZeroOrder = 0,
    /// On a straight line.
    FirstOrder = 1,
}

pub(crate) const HOLDS: [Hold; 2] = [Hold::ZeroOrder, Hold::FirstOrder];

/// Where the filters start.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialFilterStart {
    /// At zero, as the paper does.
    Zero = 0,
    /// As if the first value had always been.
    Equilibrium = 1,
}

pub(crate) const FILTER_STARTS: [FilterStart; 2] = [FilterStart::Zero, FilterStart::Equilibrium];

/// How a SeatrialFixedRate works.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatrialFixedRateSettings {
    /// Time between samples, s.
    pub sample_interval_s: SeatrialNumber,
    /// The filters' double pole, rad/s.
    pub lambda_rad_s: SeatrialNumber,
    /// P0 = this times I.
    pub initial_covariance: SeatrialNumber,
    /// A SeatrialHold, of the heading.
    pub heading_hold: u32,
    /// A SeatrialFilterStart.
    pub filter_start: u32,
}

/// Settings for filters of this lambda at this interval: seatrial_core::FixedRateSettings::for_lambda.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_fixed_rate_settings(
    lambda_rad_s: SeatrialNumber,
    sample_interval_s: SeatrialNumber,
    settings: *mut SeatrialFixedRateSettings,
) -> SeatrialStatus {
    let defaults = FixedRateSettings::for_lambda(lambda_rad_s, sample_interval_s);
    let value = SeatrialFixedRateSettings {
        sample_interval_s,
        lambda_rad_s,
        initial_covariance: defaults.initial_covariance,
        heading_hold: defaults.heading_hold as u32,
        filter_start: defaults.filter_start as u32,
    };
    // SAFETY: the caller's promise.
    status(unsafe { give(settings, value) })
}

/// Makes a lean estimator in `memory` of `size` bytes, at a first sample. `fault` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_fixed_rate_new(
    memory: *mut c_void,
    size: usize,
    settings: *const SeatrialFixedRateSettings,
    heading_rad: SeatrialNumber,
    rudder_rad: SeatrialNumber,
    estimator: *mut *mut SeatrialFixedRate,
    fault: *mut SeatrialFault,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    let settings = match unsafe { take(settings) } {
        Ok(settings) => settings,
        Err(status) => return status,
    };
    let made = one_of(settings.heading_hold, &HOLDS, "heading_hold").and_then(|heading_hold| {
        let settings = FixedRateSettings {
            sample_interval_s: settings.sample_interval_s,
            lambda_rad_s: settings.lambda_rad_s,
            heading_hold,
            filter_start: one_of(settings.filter_start, &FILTER_STARTS, "filter_start")?,
            initial_covariance: settings.initial_covariance,
        };
        FixedRateEstimator::new(&settings, heading_rad, rudder_rad)
    });
    // SAFETY: the caller's promise.
    unsafe {
        match made {
            Ok(made) => status(place(memory, size, SeatrialFixedRate(made), estimator.cast())),
            Err(setting) => refuse(setting, fault),
        }
    }
}

/// # Safety
/// As [`reach`].
unsafe fn lean<'a>(
    estimator: *mut SeatrialFixedRate,
) -> Outcome<&'a mut FixedRateEstimator<SeatrialNumber>> {
    // SAFETY: the caller's promise; what C holds as a SeatrialFixedRate is an object with it.
    unsafe { reach(estimator.cast::<Object<SeatrialFixedRate>>()) }.map(|object| &mut object.0)
}

fn used(learnt: bool) -> Outcome<()> {
    if learnt { Ok(()) } else { Err(SeatrialStatus::Refused) }
}

/// A sample of the settling phase: moves the filters, learns nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_fixed_rate_settle(
    estimator: *mut SeatrialFixedRate,
    heading_rad: SeatrialNumber,
    rudder_rad: SeatrialNumber,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    let lean = unsafe { lean(estimator) };
    status(lean.and_then(|lean| used(lean.settle(heading_rad, rudder_rad))))
}

/// A sample of the training phase. The rudder acts from this instant on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_fixed_rate_update(
    estimator: *mut SeatrialFixedRate,
    heading_rad: SeatrialNumber,
    rudder_rad: SeatrialNumber,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    let lean = unsafe { lean(estimator) };
    status(lean.and_then(|lean| used(lean.update(heading_rad, rudder_rad))))
}

/// Learns from where the filters stand; seatrial_fixed_rate_update does so by itself.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_fixed_rate_learn(
    estimator: *mut SeatrialFixedRate,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    let lean = unsafe { lean(estimator) };
    status(lean.and_then(|lean| used(lean.learn())))
}

/// The next samples follow at this interval, s, positive and below 0.5/lambda.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_fixed_rate_set_interval(
    estimator: *mut SeatrialFixedRate,
    interval_s: SeatrialNumber,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    let lean = unsafe { lean(estimator) };
    status(lean.and_then(|lean| {
        if lean.set_interval(interval_s) { Ok(()) } else { Err(SeatrialStatus::InvalidSetting) }
    }))
}

/// Forgets the estimate for the next speed; the filters run on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_fixed_rate_restart(
    estimator: *mut SeatrialFixedRate,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    let lean = unsafe { lean(estimator) };
    status(lean.map(FixedRateEstimator::restart))
}

/// The estimate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_fixed_rate_model(
    estimator: *mut SeatrialFixedRate,
    model: *mut SeatrialModel,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    status(unsafe { lean(estimator).and_then(|lean| give(model, lean.model().into())) })
}

/// Its covariance P, row by row: 9 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_fixed_rate_covariance(
    estimator: *mut SeatrialFixedRate,
    covariance: *mut SeatrialNumber,
) -> SeatrialStatus {
    let rows = covariance.cast::<[[SeatrialNumber; 3]; 3]>();
    // SAFETY: the caller's promise.
    status(unsafe { lean(estimator).and_then(|lean| give(rows, lean.covariance())) })
}
