//! The guarded estimator.

use core::ffi::c_void;

use seatrial_core::{
    ConvergenceSettings, Estimator, EstimatorSettings, GuardSettings, Intake, InvalidSetting,
    LostRudder, Method, RejectedCounts,
};

use crate::SeatrialNumber;
use crate::fixed_rate::{FILTER_STARTS, HOLDS, SeatrialModel};
use crate::memory::{Kind, Object, Outcome, give, one_of, place, reach, refuse, status, take};
use crate::status::{SeatrialFault, SeatrialStatus};

/// The guarded estimator: seatrial_core::Estimator.
pub struct SeatrialEstimator(Estimator<SeatrialNumber>);

impl Kind for SeatrialEstimator {
    const TAG: u32 = u32::from_be_bytes(*b"Sest");
}

/// Memory that a SeatrialEstimator needs, bytes.
pub const SEATRIAL_ESTIMATOR_BYTES: usize = 1024;
const _: () = assert!(size_of::<Object<SeatrialEstimator>>() <= SEATRIAL_ESTIMATOR_BYTES);

/// How the parameters are estimated.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialMethod {
    /// Recursive least squares throughout.
    LeastSquares = 0,
    /// The recursive instrumental variable after the excitation.
    InstrumentalVariable = 1,
}

const METHODS: [Method; 2] = [Method::LeastSquares, Method::InstrumentalVariable];

/// How the rudder ran while samples were lost.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialLostRudder {
    /// It waited.
    Held = 0,
    /// It moved in equal steps.
    Interpolated = 1,
}

const LOST_RUDDERS: [LostRudder; 2] = [LostRudder::Held, LostRudder::Interpolated];

/// What became of a sample.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialIntake {
    /// The estimate learnt from it.
    Used = 0,
    /// It only moved the filters, or the instrument could not learn from it.
    Warming = 1,
    /// It was refused.
    Rejected = 2,
}

/// How a SeatrialEstimator works: seatrial_core::EstimatorSettings, with NaN for what is absent.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatrialEstimatorSettings {
    /// The filters' double pole, rad/s.
    pub lambda_rad_s: SeatrialNumber,
    /// P0 = this times I.
    pub initial_covariance: SeatrialNumber,
    /// Factor on the weight of every earlier sample when the next one comes, in (0, 1]; 1 forgets nothing.
    pub forgetting_factor: SeatrialNumber,
    /// Largest step of the estimate that counts as converged.
    pub convergence_threshold: SeatrialNumber,
    /// A longer silence than this many filter time constants 1/lambda is a gap. NaN: none is.
    pub gap_time_constants: SeatrialNumber,
    /// After a gap nothing is learnt for this many filter time constants 1/lambda.
    pub warm_time_constants: SeatrialNumber,
    /// A heading further off than this is a spike, rad. NaN: none is.
    pub heading_jump_rad: SeatrialNumber,
    /// Fastest change of heading, rad/s.
    pub max_yaw_rate_rad_s: SeatrialNumber,
    /// Samples in a row that must stay under the threshold.
    pub convergence_consecutive: u32,
    /// Both in the vehicle's own time? 0 or 1.
    pub convergence_in_own_time: u32,
    /// After this many samples refused in a row the last of them is the new level.
    pub refused_in_a_row: u32,
    /// A SeatrialHold, of the heading.
    pub heading_hold: u32,
    /// A SeatrialFilterStart.
    pub filter_start: u32,
    /// A SeatrialLostRudder.
    pub lost_rudder: u32,
    /// A SeatrialMethod.
    pub method: u32,
}

/// A number, or nothing for NaN.
pub(crate) fn known(number: SeatrialNumber) -> Option<SeatrialNumber> {
    (!number.is_nan()).then_some(number)
}

/// A number, or NaN for nothing.
pub(crate) fn or_nan(number: Option<SeatrialNumber>) -> SeatrialNumber {
    number.unwrap_or(SeatrialNumber::NAN)
}

impl From<EstimatorSettings<SeatrialNumber>> for SeatrialEstimatorSettings {
    fn from(settings: EstimatorSettings<SeatrialNumber>) -> Self {
        Self {
            lambda_rad_s: settings.lambda_rad_s,
            initial_covariance: settings.initial_covariance,
            forgetting_factor: settings.forgetting_factor,
            convergence_threshold: settings.convergence.threshold,
            gap_time_constants: or_nan(settings.guard.gap_time_constants),
            warm_time_constants: settings.guard.warm_time_constants,
            heading_jump_rad: or_nan(settings.guard.heading_jump_rad),
            max_yaw_rate_rad_s: settings.guard.max_yaw_rate_rad_s,
            convergence_consecutive: settings.convergence.consecutive,
            convergence_in_own_time: settings.convergence.in_own_time.into(),
            refused_in_a_row: settings.guard.refused_in_a_row,
            heading_hold: settings.heading_hold as u32,
            filter_start: settings.filter_start as u32,
            lost_rudder: settings.lost_rudder as u32,
            method: settings.method as u32,
        }
    }
}

impl TryFrom<SeatrialEstimatorSettings> for EstimatorSettings<SeatrialNumber> {
    type Error = InvalidSetting;

    fn try_from(settings: SeatrialEstimatorSettings) -> Result<Self, InvalidSetting> {
        Ok(Self {
            lambda_rad_s: settings.lambda_rad_s,
            heading_hold: one_of(settings.heading_hold, &HOLDS, "heading_hold")?,
            lost_rudder: one_of(settings.lost_rudder, &LOST_RUDDERS, "lost_rudder")?,
            filter_start: one_of(settings.filter_start, &FILTER_STARTS, "filter_start")?,
            initial_covariance: settings.initial_covariance,
            forgetting_factor: settings.forgetting_factor,
            has_restoring_moment: false,
            method: one_of(settings.method, &METHODS, "method")?,
            convergence: ConvergenceSettings {
                threshold: settings.convergence_threshold,
                consecutive: settings.convergence_consecutive,
                in_own_time: settings.convergence_in_own_time != 0,
            },
            guard: GuardSettings {
                gap_time_constants: known(settings.gap_time_constants),
                warm_time_constants: settings.warm_time_constants,
                heading_jump_rad: known(settings.heading_jump_rad),
                max_yaw_rate_rad_s: settings.max_yaw_rate_rad_s,
                refused_in_a_row: settings.refused_in_a_row,
            },
        })
    }
}

/// The improved settings with filters of this lambda, rad/s; 1.5 for the paper's vehicle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_estimator_settings(
    lambda_rad_s: SeatrialNumber,
    settings: *mut SeatrialEstimatorSettings,
) -> SeatrialStatus {
    let value = EstimatorSettings::for_lambda(lambda_rad_s).into();
    // SAFETY: the caller's promise.
    status(unsafe { give(settings, value) })
}

/// What the paper does.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_estimator_settings_paper(
    settings: *mut SeatrialEstimatorSettings,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    status(unsafe { give(settings, EstimatorSettings::paper().into()) })
}

/// Makes an estimator in `memory` of `size` bytes. `fault` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_estimator_new(
    memory: *mut c_void,
    size: usize,
    settings: *const SeatrialEstimatorSettings,
    estimator: *mut *mut SeatrialEstimator,
    fault: *mut SeatrialFault,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    let settings = match unsafe { take(settings) } {
        Ok(settings) => settings,
        Err(status) => return status,
    };
    // SAFETY: the caller's promise.
    unsafe {
        match EstimatorSettings::try_from(settings).and_then(Estimator::new) {
            Ok(made) => status(place(memory, size, SeatrialEstimator(made), estimator.cast())),
            Err(setting) => refuse(setting, fault),
        }
    }
}

/// # Safety
/// As [`reach`].
unsafe fn guarded<'a>(
    estimator: *mut SeatrialEstimator,
) -> Outcome<&'a mut Estimator<SeatrialNumber>> {
    // SAFETY: the caller's promise; what C holds as a SeatrialEstimator is an object with it.
    unsafe { reach(estimator.cast::<Object<SeatrialEstimator>>()) }.map(|object| &mut object.0)
}

fn intake(intake: Intake) -> SeatrialIntake {
    match intake {
        Intake::Used => SeatrialIntake::Used,
        Intake::Warming => SeatrialIntake::Warming,
        Intake::Rejected(_) => SeatrialIntake::Rejected,
    }
}

/// A sample of the settling phase: moves the filters, learns nothing. `answer` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_estimator_warm(
    estimator: *mut SeatrialEstimator,
    time_s: f64,
    heading_rad: SeatrialNumber,
    rudder_rad: SeatrialNumber,
    answer: *mut SeatrialIntake,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    unsafe {
        let taken = guarded(estimator).map(|guarded| guarded.warm(time_s, heading_rad, rudder_rad));
        answered(taken, answer)
    }
}

/// A sample of the training phase. The rudder acts from this instant on. `answer` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_estimator_update(
    estimator: *mut SeatrialEstimator,
    time_s: f64,
    heading_rad: SeatrialNumber,
    rudder_rad: SeatrialNumber,
    answer: *mut SeatrialIntake,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    unsafe {
        let taken =
            guarded(estimator).map(|guarded| guarded.update(time_s, heading_rad, rudder_rad));
        answered(taken, answer)
    }
}

/// # Safety
/// As [`give`].
unsafe fn answered(taken: Outcome<Intake>, answer: *mut SeatrialIntake) -> SeatrialStatus {
    match taken {
        Err(status) => status,
        Ok(_) if answer.is_null() => SeatrialStatus::Ok,
        // SAFETY: the caller's promise.
        Ok(taken) => status(unsafe { give(answer, intake(taken)) }),
    }
}

/// The doublet is over: convergence counts from now on, and the instrument takes over.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_estimator_excitation_ended(
    estimator: *mut SeatrialEstimator,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    status(unsafe { guarded(estimator) }.map(Estimator::excitation_ended))
}

/// Forgets the estimate for the next speed; filters and guard run on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_estimator_restart(
    estimator: *mut SeatrialEstimator,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    status(unsafe { guarded(estimator) }.map(Estimator::restart))
}

/// What an estimator knows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatrialEstimate {
    /// The estimate.
    pub model: SeatrialModel,
    /// That of plain least squares, which runs on beside the instrument.
    pub least_squares_model: SeatrialModel,
    /// P of plain least squares.
    pub covariance: [[SeatrialNumber; 3]; 3],
    /// Length of the latest step of the estimate.
    pub step_norm: SeatrialNumber,
    /// Seconds from the first training sample to convergence; NaN before.
    pub converged_s: f64,
    /// Samples refused: no number.
    pub rejected_non_finite: u32,
    /// Samples refused: same time again.
    pub rejected_repeated_time: u32,
    /// Samples refused: time ran backwards.
    pub rejected_reversed_time: u32,
    /// Samples refused: impossible heading.
    pub rejected_spike: u32,
    /// Silences over which the filters could not be carried.
    pub gaps: u32,
    /// Lasting jumps of heading or clock.
    pub discontinuities: u32,
}

impl From<&Estimator<SeatrialNumber>> for SeatrialEstimate {
    fn from(estimator: &Estimator<SeatrialNumber>) -> Self {
        let RejectedCounts {
            non_finite,
            repeated_time,
            reversed_time,
            spike,
            gaps,
            discontinuities,
        } = estimator.rejected();
        Self {
            model: estimator.model().into(),
            least_squares_model: estimator.least_squares_model().into(),
            covariance: estimator.covariance(),
            step_norm: estimator.step_norm(),
            converged_s: estimator.converged_s().unwrap_or(f64::NAN),
            rejected_non_finite: non_finite,
            rejected_repeated_time: repeated_time,
            rejected_reversed_time: reversed_time,
            rejected_spike: spike,
            gaps,
            discontinuities,
        }
    }
}

/// What the estimator knows now.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_estimator_estimate(
    estimator: *mut SeatrialEstimator,
    estimate: *mut SeatrialEstimate,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    status(unsafe { guarded(estimator).and_then(|guarded| give(estimate, (&*guarded).into())) })
}
