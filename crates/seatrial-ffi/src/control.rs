//! Gains and turning limits from models, and models over speed.

use seatrial_core::NoGain;
use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::schedule::{Beyond, ScheduleError, ScheduleKey, ScheduleValue};
use seatrial_core::turning::NoTurn;
use seatrial_core::{GainSchedule, HeadingGain, SchedulePoint, Side, SpeedSchedule, Turn};

use crate::SeatrialNumber;
use crate::estimator::{known, or_nan};
use crate::fixed_rate::SeatrialModel;
use crate::memory::{Outcome, give, status, take, take_all};
use crate::status::SeatrialStatus;

/// Rudder = proportional_gain times heading error + feed_forward_rudder_rad.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeatrialHeadingGain {
    /// Rudder per heading error; has the sign of b2.
    pub proportional_gain: SeatrialNumber,
    /// The rudder that holds a constant heading, rad.
    pub feed_forward_rudder_rad: SeatrialNumber,
}

impl From<HeadingGain<SeatrialNumber>> for SeatrialHeadingGain {
    fn from(gain: HeadingGain<SeatrialNumber>) -> Self {
        Self {
            proportional_gain: gain.proportional_gain,
            feed_forward_rudder_rad: gain.feed_forward_rudder_rad,
        }
    }
}

fn no_gain(reason: NoGain) -> SeatrialStatus {
    match reason {
        NoGain::CourseUnstable => SeatrialStatus::CourseUnstable,
        NoGain::NoAuthority | NoGain::WrongSign => SeatrialStatus::NoAuthority,
        NoGain::DampingRatio | NoGain::RudderLimit | NoGain::Timing | NoGain::NonFinite => {
            SeatrialStatus::InvalidSetting
        }
    }
}

/// The gain that gives the heading loop this damping ratio; 0.7071 is the paper's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_heading_gain(
    model: *const SeatrialModel,
    damping_ratio: SeatrialNumber,
    gain: *mut SeatrialHeadingGain,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    status(unsafe {
        take(model).and_then(|model| {
            let design = HeadingGain::design(&model.into(), damping_ratio).map_err(no_gain)?;
            give(gain, design.into())
        })
    })
}

/// A turn under the full rudder to one side.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatrialTurn {
    /// The full rudder to that side with its sign, rad.
    pub rudder_rad: SeatrialNumber,
    /// Magnitude of the steady yaw rate, rad/s.
    pub yaw_rate_rad_s: SeatrialNumber,
    /// Time until the yaw rate is within 2 %, s.
    pub rise_time_s: SeatrialNumber,
    /// Time of a U-turn by the paper's profile, s.
    pub u_turn_time_s: SeatrialNumber,
    /// Its path length over pi, m.
    pub u_turn_mean_radius_m: SeatrialNumber,
    /// Radius of the circle that a long turn draws, m.
    pub steady_turning_radius_m: SeatrialNumber,
}

/// The turn of a model under its full rudder; to starboard, where the heading increases, or to port.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_turn(
    model: *const SeatrialModel,
    rudder_limit_rad: SeatrialNumber,
    surge_speed_m_s: SeatrialNumber,
    to_starboard: bool,
    turn: *mut SeatrialTurn,
) -> SeatrialStatus {
    let side = if to_starboard { Side::Starboard } else { Side::Port };
    let limits = |model: SeatrialModel| {
        let turn = Turn::new(&model.into(), rudder_limit_rad, side).map_err(|why| match why {
            NoTurn::CourseUnstable => SeatrialStatus::CourseUnstable,
            NoTurn::NoAuthority => SeatrialStatus::NoAuthority,
            NoTurn::RudderLimit | NoTurn::NonFinite => SeatrialStatus::InvalidSetting,
        })?;
        Ok(SeatrialTurn {
            rudder_rad: turn.rudder_rad,
            yaw_rate_rad_s: turn.yaw_rate_rad_s,
            rise_time_s: turn.rise_time_s(),
            u_turn_time_s: turn.u_turn_time_s(),
            u_turn_mean_radius_m: turn.u_turn_mean_radius_m(surge_speed_m_s),
            steady_turning_radius_m: turn.steady_turning_radius_m(surge_speed_m_s),
        })
    };
    // SAFETY: the caller's promise.
    status(unsafe { take(model).and_then(|model| give(turn, limits(model)?)) })
}

/// The model of one speed. NaN: not known.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatrialSchedulePoint {
    /// Thrust as a fraction of full.
    pub thrust: SeatrialNumber,
    /// Forward speed, m/s.
    pub surge_speed_m_s: SeatrialNumber,
    /// The model identified there.
    pub model: SeatrialModel,
}

/// Most points of a schedule.
pub const SEATRIAL_SCHEDULE_POINTS: usize = 16;
const _: () = assert!(SEATRIAL_SCHEDULE_POINTS == seatrial_core::schedule::CAPACITY);

/// What a schedule is looked up by.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeatrialScheduleKey {
    /// Thrust as a fraction of full.
    Thrust = 0,
    /// Forward speed, m/s.
    Speed = 1,
}

fn refused(reason: ScheduleError) -> SeatrialStatus {
    match reason {
        ScheduleError::Outside { .. } | ScheduleError::TooFar { .. } => {
            SeatrialStatus::OutsideRange
        }
        ScheduleError::InvalidKey => SeatrialStatus::InvalidSetting,
        _ => SeatrialStatus::InvalidSchedule,
    }
}

/// A schedule of the caller's points.
///
/// # Safety
/// As [`take_all`].
unsafe fn schedule(
    points: *const SeatrialSchedulePoint,
    count: usize,
    key: u32,
) -> Outcome<SpeedSchedule<SeatrialNumber>> {
    let key = match key {
        0 => ScheduleKey::Thrust,
        1 => ScheduleKey::Speed,
        _ => return Err(SeatrialStatus::InvalidSetting),
    };
    // SAFETY: the caller's promise.
    let points = unsafe { take_all(points, count) }?;
    let mut own = [SchedulePoint::default(); SEATRIAL_SCHEDULE_POINTS];
    let own = own.get_mut(..points.len()).ok_or(SeatrialStatus::InvalidSchedule)?;
    for (own, point) in own.iter_mut().zip(points) {
        *own = SchedulePoint {
            thrust: known(point.thrust),
            surge_speed_m_s: known(point.surge_speed_m_s),
            model: point.model.into(),
        };
    }
    SpeedSchedule::new(key, own).map_err(refused)
}

fn beyond(extrapolate: bool) -> Beyond {
    if extrapolate { Beyond::Extrapolate } else { Beyond::Refuse }
}

/// The model at a key (a SeatrialScheduleKey) among `count` points in any order. `extrapolated` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_schedule_lookup(
    points: *const SeatrialSchedulePoint,
    count: usize,
    key: u32,
    at: SeatrialNumber,
    extrapolate: bool,
    found: *mut SeatrialSchedulePoint,
    extrapolated: *mut bool,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    let looked_up = unsafe { schedule(points, count, key) }
        .and_then(|schedule| schedule.lookup(at, beyond(extrapolate)).map_err(refused));
    let flat = |point: SchedulePoint<SeatrialNumber>| SeatrialSchedulePoint {
        thrust: or_nan(point.thrust),
        surge_speed_m_s: or_nan(point.surge_speed_m_s),
        model: point.model.into(),
    };
    // SAFETY: the caller's promise.
    status(unsafe { write_out(looked_up, flat, found, extrapolated) })
}

/// The heading gain at a key (a SeatrialScheduleKey) among `count` points in any order. `extrapolated` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seatrial_schedule_gain(
    points: *const SeatrialSchedulePoint,
    count: usize,
    key: u32,
    damping_ratio: SeatrialNumber,
    at: SeatrialNumber,
    extrapolate: bool,
    gain: *mut SeatrialHeadingGain,
    extrapolated: *mut bool,
) -> SeatrialStatus {
    // SAFETY: the caller's promise.
    let looked_up = unsafe { schedule(points, count, key) }.and_then(|schedule| {
        let gains = GainSchedule::design(schedule, damping_ratio, LoopTiming::default())
            .map_err(|refused| no_gain(refused.reason))?;
        gains.lookup(at, beyond(extrapolate)).map_err(refused)
    });
    // SAFETY: the caller's promise.
    status(unsafe { write_out(looked_up, Into::into, gain, extrapolated) })
}

/// # Safety
/// As [`give`].
unsafe fn write_out<V: Copy, F>(
    looked_up: Outcome<ScheduleValue<V>>,
    flat: impl FnOnce(V) -> F,
    found: *mut F,
    extrapolated: *mut bool,
) -> Outcome<()> {
    let looked_up = looked_up?;
    // SAFETY: the caller's promise.
    unsafe {
        give(found, flat(*looked_up.value()))?;
        if extrapolated.is_null() {
            return Ok(());
        }
        give(extrapolated, looked_up.is_extrapolated())
    }
}
