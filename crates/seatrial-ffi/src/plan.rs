//! The plan of a trial.

use seatrial_core::envelope::AREA_CORNERS;
use seatrial_core::excitation::DEFLECTIONS;
use seatrial_core::plan::SPEEDS;
use seatrial_core::{
    Axis, Envelope, Excitation, InvalidSetting, List, Manoeuvre, NotSettled, Plan, RudderSense,
    Settle,
};

use crate::SeatrialNumber;
use crate::memory::{give, one_of, status};
use crate::status::SeatrialStatus;

/// Most speeds of a trial.
pub const SEATRIAL_SPEEDS: usize = 16;
/// Most deflections of a switched manoeuvre.
pub const SEATRIAL_DEFLECTIONS: usize = 8;
/// Most corners of the area.
pub const SEATRIAL_AREA_CORNERS: usize = 16;
const _: () = assert!(SEATRIAL_SPEEDS == SPEEDS);
const _: () = assert!(SEATRIAL_DEFLECTIONS == DEFLECTIONS);
const _: () = assert!(SEATRIAL_AREA_CORNERS == AREA_CORNERS);

/// Rudder manoeuvres.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialExcitation {
    /// One deflection to each side.
    Doublet = 0,
    /// Deflections of 3, 2, 1 and 1 units.
    ThreeTwoOneOne = 1,
    /// Deflections to alternating sides, each of its own length.
    Switched = 2,
    /// A sum of cosines.
    Multisine = 3,
}

/// Which way the vehicle is expected to turn.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialRudderSense {
    /// Positive rudder increases the heading.
    Positive = 0,
    /// Positive rudder decreases the heading.
    Negative = 1,
    /// Not known.
    Unknown = 2,
}

const RUDDER_SENSES: [RudderSense; 3] =
    [RudderSense::Positive, RudderSense::Negative, RudderSense::Unknown];

/// What to do with a vehicle that does not become steady.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialNotSettled {
    /// Begin all the same.
    GoOn = 0,
    /// Abort the trial.
    Abort = 1,
}

const NOT_SETTLED: [NotSettled; 2] = [NotSettled::GoOn, NotSettled::Abort];

/// A stage with a manoeuvre: steady, manoeuvre, observe.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeatrialManoeuvre {
    /// Heading hold before the manoeuvre, s.
    pub lead_in_s: f64,
    /// Heading hold after it, s.
    pub observe_s: f64,
    /// Period of a doublet or multisine, unit of a 3-2-1-1, s.
    pub period_s: f64,
    /// Lengths of the deflections of a switched manoeuvre, s.
    pub deflections_s: [f64; SEATRIAL_DEFLECTIONS],
    /// The first deflection, rad.
    pub amplitude_rad: SeatrialNumber,
    /// A SeatrialExcitation.
    pub excitation: u32,
    /// Deflections of a switched manoeuvre.
    pub deflections: u32,
    /// Tones of a multisine.
    pub tones: u32,
}

/// The plan of a trial: seatrial_core::Plan.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatrialPlan {
    /// Training stage.
    pub training: SeatrialManoeuvre,
    /// Validation stage.
    pub validation: SeatrialManoeuvre,
    /// Time between samples that the vehicle is expected to keep, s.
    pub sample_interval_s: f64,
    /// Settling: length of a piece of record that must be steady, s.
    pub settle_steady_for_s: f64,
    /// Settle at least so long, s.
    pub settle_at_least_s: f64,
    /// Settle at most so long, s.
    pub settle_at_most_s: f64,
    /// Longest silence, s.
    pub stale_after_s: f64,
    /// Longest stage, s.
    pub stage_time_limit_s: f64,
    /// The speeds, as thrust in fractions of full.
    pub thrusts: [SeatrialNumber; SEATRIAL_SPEEDS],
    /// Corners [north, east] of the area, m.
    pub area_m: [[SeatrialNumber; 2]; SEATRIAL_AREA_CORNERS],
    /// Largest rudder that the trial commands, rad.
    pub rudder_limit_rad: SeatrialNumber,
    /// A run is accepted from this R^2 of heading on.
    pub accept_from_r2: SeatrialNumber,
    /// Settling: mean heading from the heading of the run, rad.
    pub settle_heading_tolerance_rad: SeatrialNumber,
    /// Settling: slope of the heading, rad/s.
    pub settle_yaw_rate_tolerance_rad_s: SeatrialNumber,
    /// Settling: change of depth, m.
    pub settle_depth_tolerance_m: SeatrialNumber,
    /// Settling: change of speed, as a fraction of it.
    pub settle_speed_tolerance: SeatrialNumber,
    /// Shallowest depth, m.
    pub depth_min_m: SeatrialNumber,
    /// Greatest depth, m.
    pub depth_max_m: SeatrialNumber,
    /// Least height above the bottom, m.
    pub altitude_min_m: SeatrialNumber,
    /// Greatest roll, rad.
    pub roll_max_rad: SeatrialNumber,
    /// Greatest pitch, rad.
    pub pitch_max_rad: SeatrialNumber,
    /// Fastest turn, rad/s.
    pub yaw_rate_max_rad_s: SeatrialNumber,
    /// Farthest heading from the heading of the run, rad.
    pub heading_excursion_max_rad: SeatrialNumber,
    /// Greatest change of speed, as a fraction.
    pub speed_drift_max: SeatrialNumber,
    /// Speeds in thrusts.
    pub speeds: u32,
    /// Corners in area_m; 0: anywhere.
    pub area_corners: u32,
    /// Times a run that is not accepted is repeated.
    pub max_repeats: u32,
    /// End training when the estimate has converged? 0 or 1.
    pub stop_on_convergence: u32,
    /// A SeatrialNotSettled.
    pub not_settled: u32,
    /// A SeatrialRudderSense.
    pub rudder_sense: u32,
}

/// The paper's plan for a vehicle whose yaw rate follows the rudder with this time constant, s: 1/1.07 s is the paper's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_plan(
    time_constant_s: f64,
    sample_interval_s: f64,
    plan: *mut SeatrialPlan,
) -> SeatrialStatus {
    let value = Plan::for_time_constant(time_constant_s, sample_interval_s).into();
    // SAFETY: the caller's promise.
    status(unsafe { give(plan, value) })
}

/// Copies a list into an array; how many there are.
fn fill<V: Copy>(array: &mut [V], list: &[V]) -> u32 {
    array.iter_mut().zip(list).map(|(place, value)| *place = *value).count() as u32
}

fn list<V: Copy + Default, const N: usize>(
    array: &[V; N],
    count: u32,
    field: &'static str,
) -> Result<List<V, N>, InvalidSetting> {
    array
        .get(..count as usize)
        .and_then(List::from_slice)
        .ok_or(InvalidSetting { field, requirement: "at most as long as its array" })
}

impl From<Manoeuvre<SeatrialNumber>> for SeatrialManoeuvre {
    fn from(manoeuvre: Manoeuvre<SeatrialNumber>) -> Self {
        let mut flat = Self {
            lead_in_s: manoeuvre.lead_in_s,
            observe_s: manoeuvre.observe_s,
            amplitude_rad: manoeuvre.excitation.amplitude_rad(),
            ..Self::default()
        };
        let excitation = match manoeuvre.excitation {
            Excitation::Doublet { period_s, .. } => {
                flat.period_s = period_s;
                SeatrialExcitation::Doublet
            }
            Excitation::ThreeTwoOneOne { unit_s, .. } => {
                flat.period_s = unit_s;
                SeatrialExcitation::ThreeTwoOneOne
            }
            Excitation::Switched { deflections_s, .. } => {
                flat.deflections = fill(&mut flat.deflections_s, &deflections_s);
                SeatrialExcitation::Switched
            }
            Excitation::Multisine { period_s, tones, .. } => {
                flat.period_s = period_s;
                flat.tones = tones.into();
                SeatrialExcitation::Multisine
            }
        };
        flat.excitation = excitation as u32;
        flat
    }
}

impl TryFrom<SeatrialManoeuvre> for Manoeuvre<SeatrialNumber> {
    type Error = InvalidSetting;

    fn try_from(flat: SeatrialManoeuvre) -> Result<Self, InvalidSetting> {
        let SeatrialManoeuvre { amplitude_rad, period_s, .. } = flat;
        let kinds = [
            SeatrialExcitation::Doublet,
            SeatrialExcitation::ThreeTwoOneOne,
            SeatrialExcitation::Switched,
            SeatrialExcitation::Multisine,
        ];
        let excitation = match one_of(flat.excitation, &kinds, "excitation")? {
            SeatrialExcitation::Doublet => Excitation::Doublet { amplitude_rad, period_s },
            SeatrialExcitation::ThreeTwoOneOne => {
                Excitation::ThreeTwoOneOne { amplitude_rad, unit_s: period_s }
            }
            SeatrialExcitation::Switched => Excitation::Switched {
                amplitude_rad,
                deflections_s: list(&flat.deflections_s, flat.deflections, "deflections")?,
            },
            SeatrialExcitation::Multisine => Excitation::Multisine {
                amplitude_rad,
                period_s,
                // More than 16 are refused with the plan.
                tones: u8::try_from(flat.tones).unwrap_or(u8::MAX),
            },
        };
        Ok(Self { lead_in_s: flat.lead_in_s, excitation, observe_s: flat.observe_s })
    }
}

impl From<Plan<SeatrialNumber>> for SeatrialPlan {
    fn from(plan: Plan<SeatrialNumber>) -> Self {
        let Plan { settle, envelope, .. } = plan;
        let mut thrusts = [0.0; SEATRIAL_SPEEDS];
        let mut area_m = [[0.0; 2]; SEATRIAL_AREA_CORNERS];
        Self {
            speeds: fill(&mut thrusts, &plan.thrusts),
            area_corners: fill(&mut area_m, &envelope.area),
            training: plan.training.into(),
            validation: plan.validation.into(),
            sample_interval_s: plan.sample_interval_s,
            settle_steady_for_s: settle.steady_for_s,
            settle_at_least_s: settle.at_least_s,
            settle_at_most_s: settle.at_most_s,
            stale_after_s: envelope.stale_after_s,
            stage_time_limit_s: envelope.stage_time_limit_s,
            thrusts,
            area_m,
            rudder_limit_rad: plan.rudder_limit_rad,
            accept_from_r2: plan.accept_from_r2,
            settle_heading_tolerance_rad: settle.heading_tolerance_rad,
            settle_yaw_rate_tolerance_rad_s: settle.yaw_rate_tolerance_rad_s,
            settle_depth_tolerance_m: settle.depth_tolerance_m,
            settle_speed_tolerance: settle.speed_tolerance,
            depth_min_m: envelope.depth_min_m,
            depth_max_m: envelope.depth_max_m,
            altitude_min_m: envelope.altitude_min_m,
            roll_max_rad: envelope.roll_max_rad,
            pitch_max_rad: envelope.pitch_max_rad,
            yaw_rate_max_rad_s: envelope.yaw_rate_max_rad_s,
            heading_excursion_max_rad: envelope.heading_excursion_max_rad,
            speed_drift_max: envelope.speed_drift_max,
            max_repeats: plan.max_repeats,
            stop_on_convergence: plan.stop_on_convergence.into(),
            not_settled: settle.not_settled as u32,
            rudder_sense: envelope.rudder_sense as u32,
        }
    }
}

impl TryFrom<SeatrialPlan> for Plan<SeatrialNumber> {
    type Error = InvalidSetting;

    fn try_from(flat: SeatrialPlan) -> Result<Self, InvalidSetting> {
        Ok(Self {
            axis: Axis::Yaw,
            thrusts: list(&flat.thrusts, flat.speeds, "speeds")?,
            rudder_limit_rad: flat.rudder_limit_rad,
            sample_interval_s: flat.sample_interval_s,
            stop_on_convergence: flat.stop_on_convergence != 0,
            accept_from_r2: flat.accept_from_r2,
            max_repeats: flat.max_repeats,
            settle: Settle {
                heading_tolerance_rad: flat.settle_heading_tolerance_rad,
                yaw_rate_tolerance_rad_s: flat.settle_yaw_rate_tolerance_rad_s,
                depth_tolerance_m: flat.settle_depth_tolerance_m,
                speed_tolerance: flat.settle_speed_tolerance,
                steady_for_s: flat.settle_steady_for_s,
                at_least_s: flat.settle_at_least_s,
                at_most_s: flat.settle_at_most_s,
                not_settled: one_of(flat.not_settled, &NOT_SETTLED, "not_settled")?,
            },
            training: flat.training.try_into()?,
            validation: flat.validation.try_into()?,
            estimator: None,
            envelope: Envelope {
                depth_min_m: flat.depth_min_m,
                depth_max_m: flat.depth_max_m,
                depth_change_max_m: None,
                altitude_min_m: flat.altitude_min_m,
                roll_max_rad: flat.roll_max_rad,
                pitch_max_rad: flat.pitch_max_rad,
                yaw_rate_max_rad_s: flat.yaw_rate_max_rad_s,
                heading_excursion_max_rad: flat.heading_excursion_max_rad,
                speed_drift_max: flat.speed_drift_max,
                area: list(&flat.area_m, flat.area_corners, "area_corners")?,
                stale_after_s: flat.stale_after_s,
                stage_time_limit_s: flat.stage_time_limit_s,
                rudder_sense: one_of(flat.rudder_sense, &RUDDER_SENSES, "rudder_sense")?,
            },
        })
    }
}
