//! The trial.

use core::ffi::c_void;

use seatrial_core::{
    AbortReason, Event, Outcome as TrialOutcome, Plan, RunResult, Sample, Stage, Steering, Trial,
};

use crate::SeatrialNumber;
use crate::estimator::{SeatrialEstimate, known, or_nan};
use crate::fixed_rate::SeatrialModel;
use crate::memory::{Kind, Object, Outcome, give, place, reach, refuse, status, take};
use crate::plan::SeatrialPlan;
use crate::status::{SeatrialFault, SeatrialStatus};

/// A sea trial: seatrial_core::Trial.
pub struct SeatrialTrial(Trial<SeatrialNumber>);

impl Kind for SeatrialTrial {
    const TAG: u32 = u32::from_be_bytes(*b"Stri");
}

/// Memory that a SeatrialTrial needs, bytes.
pub const SEATRIAL_TRIAL_BYTES: usize = 6144;
const _: () = assert!(size_of::<Object<SeatrialTrial>>() <= SEATRIAL_TRIAL_BYTES);

/// One instant of a vehicle. NaN: not measured.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatrialSample {
    /// The vehicle's own clock, s.
    pub time_s: f64,
    /// Heading, rad, wrapped or not.
    pub heading_rad: SeatrialNumber,
    /// Rudder angle that acts from this instant on, rad.
    pub rudder_rad: SeatrialNumber,
    /// Forward speed, m/s.
    pub surge_speed_m_s: SeatrialNumber,
    /// Depth below the surface, m.
    pub depth_m: SeatrialNumber,
    /// Height above the bottom, m.
    pub altitude_m: SeatrialNumber,
    /// Roll, rad.
    pub roll_rad: SeatrialNumber,
    /// Pitch, rad.
    pub pitch_rad: SeatrialNumber,
    /// Yaw rate, rad/s.
    pub yaw_rate_rad_s: SeatrialNumber,
    /// Position north of the origin, m.
    pub north_m: SeatrialNumber,
    /// Position east of the origin, m.
    pub east_m: SeatrialNumber,
}

impl From<SeatrialSample> for Sample<SeatrialNumber> {
    fn from(sample: SeatrialSample) -> Self {
        Self {
            time_s: sample.time_s,
            heading_rad: sample.heading_rad,
            rudder_rad: sample.rudder_rad,
            surge_speed_m_s: known(sample.surge_speed_m_s),
            depth_m: known(sample.depth_m),
            altitude_m: known(sample.altitude_m),
            roll_rad: known(sample.roll_rad),
            pitch_rad: known(sample.pitch_rad),
            yaw_rate_rad_s: known(sample.yaw_rate_rad_s),
            north_m: known(sample.north_m),
            east_m: known(sample.east_m),
            thrust: None,
        }
    }
}

/// How the vehicle is to steer.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialSteering {
    /// Hold this rudder angle.
    Rudder = 0,
    /// The vehicle's heading controller holds this heading.
    HoldHeading = 1,
}

/// How a trial ended.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialOutcome {
    /// It has not.
    UnderWay = 0,
    /// Every speed was run.
    Finished = 1,
    /// Stopped, see the reason.
    Aborted = 2,
}

/// Why a trial was stopped.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialAbortReason {
    /// It was not.
    None = 0,
    /// The operator asked for it.
    Operator = 1,
    /// Depth outside the envelope.
    Depth = 2,
    /// Too close to the bottom.
    Altitude = 3,
    /// Roll outside the envelope.
    Roll = 4,
    /// Pitch outside the envelope.
    Pitch = 5,
    /// Yaw rate outside the envelope.
    YawRate = 6,
    /// Heading too far from the heading of the run.
    HeadingExcursion = 7,
    /// Outside the area.
    Area = 8,
    /// Speed changed too much during a stage.
    SpeedDrift = 9,
    /// No new usable sample for too long.
    StaleSamples = 10,
    /// A stage took longer than its limit.
    StageTimeLimit = 11,
    /// The vehicle turned against the rudder.
    ReversedRudder = 12,
    /// The vehicle did not settle.
    NotSettled = 13,
    /// The link to the vehicle was lost.
    LinkLost = 14,
    /// The pilot changed the mode.
    ModeChanged = 15,
    /// The pilot moved a stick.
    StickMoved = 16,
    /// The vehicle was disarmed.
    Disarmed = 17,
    /// The battery was low.
    LowBattery = 18,
    /// The autopilot reported a failsafe.
    Failsafe = 19,
    /// The autopilot started again.
    Restarted = 20,
    /// Somebody else commanded the vehicle under our name.
    SecondStation = 21,
    /// The rudder did something else than asked for.
    RudderNotFollowed = 22,
    /// The program that conducts the trial was held up.
    NotAttended = 23,
    /// The heading did not answer the rudder.
    NoAnswer = 24,
}

impl From<AbortReason> for SeatrialAbortReason {
    fn from(reason: AbortReason) -> Self {
        match reason {
            AbortReason::Operator => Self::Operator,
            AbortReason::Depth => Self::Depth,
            AbortReason::Altitude => Self::Altitude,
            AbortReason::Roll => Self::Roll,
            AbortReason::Pitch => Self::Pitch,
            AbortReason::YawRate => Self::YawRate,
            AbortReason::HeadingExcursion => Self::HeadingExcursion,
            AbortReason::Area => Self::Area,
            AbortReason::SpeedDrift => Self::SpeedDrift,
            AbortReason::StaleSamples => Self::StaleSamples,
            AbortReason::StageTimeLimit => Self::StageTimeLimit,
            AbortReason::ReversedRudder => Self::ReversedRudder,
            AbortReason::NotSettled => Self::NotSettled,
            AbortReason::LinkLost => Self::LinkLost,
            AbortReason::ModeChanged => Self::ModeChanged,
            AbortReason::StickMoved => Self::StickMoved,
            AbortReason::Disarmed => Self::Disarmed,
            AbortReason::LowBattery => Self::LowBattery,
            AbortReason::Failsafe => Self::Failsafe,
            AbortReason::Restarted => Self::Restarted,
            AbortReason::SecondStation => Self::SecondStation,
            AbortReason::RudderNotFollowed => Self::RudderNotFollowed,
            AbortReason::NotAttended => Self::NotAttended,
            AbortReason::NoAnswer => Self::NoAnswer,
        }
    }
}

/// What the vehicle is to do until the next action.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatrialAction {
    /// Rudder or heading hold.
    pub steering: SeatrialSteering,
    /// Its angle, rad.
    pub steering_rad: SeatrialNumber,
    /// Thrust as a fraction of full. NaN gives it back to the vehicle.
    pub thrust: SeatrialNumber,
    /// Other than under way: this is the last action.
    pub outcome: SeatrialOutcome,
    /// Why the trial was stopped, if it was.
    pub reason: SeatrialAbortReason,
}

fn ended(outcome: Option<TrialOutcome>) -> (SeatrialOutcome, SeatrialAbortReason) {
    match outcome {
        None => (SeatrialOutcome::UnderWay, SeatrialAbortReason::None),
        Some(TrialOutcome::Finished) => (SeatrialOutcome::Finished, SeatrialAbortReason::None),
        Some(TrialOutcome::Aborted(reason)) => (SeatrialOutcome::Aborted, reason.into()),
    }
}

/// Makes a trial in `memory` of `size` bytes. `fault` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_trial_new(
    memory: *mut c_void,
    size: usize,
    plan: *const SeatrialPlan,
    trial: *mut *mut SeatrialTrial,
    fault: *mut SeatrialFault,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    let plan = match unsafe { take(plan) } {
        Ok(plan) => plan,
        Err(status) => return status,
    };
    // SAFETY: the caller's promise.
    unsafe {
        match Plan::try_from(plan).and_then(Trial::new) {
            Ok(made) => status(place(memory, size, SeatrialTrial(made), trial.cast())),
            Err(setting) => refuse(setting, fault),
        }
    }
}

/// # Safety
/// As [`reach`].
unsafe fn running<'a>(trial: *mut SeatrialTrial) -> Outcome<&'a mut Trial<SeatrialNumber>> {
    // SAFETY: the caller's promise; what C holds as a SeatrialTrial is an object with it.
    unsafe { reach(trial.cast::<Object<SeatrialTrial>>()) }.map(|object| &mut object.0)
}

/// Takes in the next sample; the action holds until the next one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_trial_step(
    trial: *mut SeatrialTrial,
    sample: *const SeatrialSample,
    action: *mut SeatrialAction,
) -> SeatrialStatus {
    if action.is_null() {
        return SeatrialStatus::NullPointer;
    }
    // SAFETY: the caller's promise.
    let (trial, sample) = match unsafe { (running(trial), take(sample)) } {
        (Ok(trial), Ok(sample)) => (trial, sample),
        (Err(status), _) | (_, Err(status)) => return status,
    };
    let asked = trial.step(&sample.into());
    let (steering, steering_rad) = match asked.steering {
        Steering::Rudder(rudder_rad) => (SeatrialSteering::Rudder, rudder_rad),
        Steering::HoldHeading(heading_rad) => (SeatrialSteering::HoldHeading, heading_rad),
    };
    let (outcome, reason) = ended(asked.outcome);
    let value =
        SeatrialAction { steering, steering_rad, thrust: or_nan(asked.thrust), outcome, reason };
    // SAFETY: the caller's promise.
    status(unsafe { give(action, value) })
}

/// Ends the trial for a reason that the samples do not show: SEATRIAL_ABORT_REASON_OPERATOR or ..._LINK_LOST.
/// The next action hands the vehicle back.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_trial_abort(
    trial: *mut SeatrialTrial,
    reason: u32,
) -> SeatrialStatus {
    let reason = match reason {
        reason if reason == SeatrialAbortReason::Operator as u32 => AbortReason::Operator,
        reason if reason == SeatrialAbortReason::LinkLost as u32 => AbortReason::LinkLost,
        _ => return SeatrialStatus::InvalidSetting,
    };
    // SAFETY: the caller's promise.
    status(unsafe { running(trial) }.map(|trial| trial.abort(reason)))
}

/// The estimate is good enough: training ends with the next sample, or with the manoeuvre if that is not over yet.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_trial_finish_training(
    trial: *mut SeatrialTrial,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    status(unsafe { running(trial) }.map(Trial::finish_training))
}

/// The stages of a run.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialStage {
    /// Before the first sample or after the end.
    None = 0,
    /// Waiting for a steady vehicle.
    Settle = 1,
    /// Estimating.
    Train = 2,
    /// Recording the validation manoeuvre.
    Validate = 3,
}

impl From<Option<Stage>> for SeatrialStage {
    fn from(stage: Option<Stage>) -> Self {
        match stage {
            None => Self::None,
            Some(Stage::Settle) => Self::Settle,
            Some(Stage::Train) => Self::Train,
            Some(Stage::Validate) => Self::Validate,
        }
    }
}

/// Where a trial is.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatrialTrialStatus {
    /// Time in the stage, s.
    pub elapsed_s: f64,
    /// Time until the stage ends at the latest, s.
    pub remaining_s: f64,
    /// What the estimator knows.
    pub estimate: SeatrialEstimate,
    /// Thrust of the run as a fraction of full.
    pub thrust: SeatrialNumber,
    /// 1 for the first run, 0 before it.
    pub run: u32,
    /// 1 for the first try at this thrust.
    pub attempt: u32,
    /// The stage.
    pub stage: SeatrialStage,
    /// How the trial ended.
    pub outcome: SeatrialOutcome,
    /// Why it was stopped.
    pub reason: SeatrialAbortReason,
}

/// Where the trial is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_trial_status(
    trial: *mut SeatrialTrial,
    value: *mut SeatrialTrialStatus,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    let trial = match unsafe { running(trial) } {
        Ok(trial) => trial,
        Err(status) => return status,
    };
    let now = trial.status();
    let (outcome, reason) = ended(now.outcome);
    let now = SeatrialTrialStatus {
        elapsed_s: now.elapsed_s,
        remaining_s: now.remaining_s,
        estimate: trial.estimator().into(),
        thrust: now.thrust,
        run: now.run,
        attempt: now.attempt,
        stage: now.stage.into(),
        outcome,
        reason,
    };
    // SAFETY: the caller's promise.
    status(unsafe { give(value, now) })
}

/// A run at one thrust with its result. NaN: not known.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatrialRunResult {
    /// Seconds from the start of training to convergence.
    pub converged_s: f64,
    /// The estimate.
    pub model: SeatrialModel,
    /// The estimate of plain least squares on the same samples.
    pub least_squares_model: SeatrialModel,
    /// P of plain least squares.
    pub covariance: [[SeatrialNumber; 3]; 3],
    /// Thrust as a fraction of full.
    pub thrust: SeatrialNumber,
    /// Mean forward speed over the training stage, m/s.
    pub surge_speed_m_s: SeatrialNumber,
    /// R^2 of the heading in validation.
    pub r2_heading: SeatrialNumber,
    /// R^2 of the yaw rate in validation.
    pub r2_yaw_rate: SeatrialNumber,
    /// 1 for the first run of the trial.
    pub number: u32,
    /// 1 for the first try at this thrust.
    pub attempt: u32,
    /// Samples that the estimate learnt from.
    pub samples_used: u32,
    /// Samples refused during the run.
    pub samples_rejected: u32,
    /// Was the vehicle steady before training?
    pub settled: bool,
    /// Is R^2 of the heading high enough?
    pub accepted: bool,
}

impl From<RunResult<SeatrialNumber>> for SeatrialRunResult {
    fn from(result: RunResult<SeatrialNumber>) -> Self {
        Self {
            converged_s: result.converged_s.unwrap_or(f64::NAN),
            model: result.model.into(),
            least_squares_model: result.least_squares_model.into(),
            covariance: result.covariance,
            thrust: result.thrust,
            surge_speed_m_s: or_nan(result.surge_speed_m_s),
            r2_heading: or_nan(result.validation.r2_heading),
            r2_yaw_rate: or_nan(result.validation.r2_yaw_rate),
            number: result.number,
            attempt: result.attempt,
            samples_used: result.samples_used,
            samples_rejected: result.rejected.samples(),
            settled: result.settled,
            accepted: result.accepted,
        }
    }
}

/// Takes the results of finished runs, the oldest first; SEATRIAL_STATUS_NO_EVENT when there are no more. Ask after
/// every step: a trial keeps 8 events, the beginnings of stages among them, and loses what comes after.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_trial_take_result(
    trial: *mut SeatrialTrial,
    result: *mut SeatrialRunResult,
) -> SeatrialStatus {
    if result.is_null() {
        return SeatrialStatus::NullPointer;
    }
    // SAFETY: the caller's promise.
    let trial = match unsafe { running(trial) } {
        Ok(trial) => trial,
        Err(status) => return status,
    };
    while let Some(event) = trial.take_event() {
        if let Event::RunFinished { result: run, .. } = event {
            // SAFETY: the caller's promise.
            return status(unsafe { give(result, run.into()) });
        }
    }
    SeatrialStatus::NoEvent
}
