//! The U-turn of Fig. 15: a circle through its track against the radius predicted from the model.

use std::f64::consts::PI;

use seatrial_core::model::YawState;
use seatrial_core::turning::{Side, Turn};
use seatrial_core::{Real, Sample, SchedulePoint, Steering, Vehicle, YawModel};
use serde::Serialize;

use super::circle_fit::CircleFit;
use super::pilot::{Pilot, mean, turned_rad};
use super::{FieldError, FieldSettings};
use crate::motions::surge::SurgeModel;
use crate::savitzky_golay::SavitzkyGolay;

/// Heading change of the whole manoeuvre, rad: the U-turn and a full circle after it.
const WHOLE_RAD: f64 = 3.0 * PI;
/// Longest that it may take, s.
const LONGEST_S: f64 = 600.0;
/// Last part of the steady course over which the speed is averaged, s.
const AVERAGED_S: f64 = 10.0;
/// Half of the window over which the compass is differentiated, in samples.
const HALF_WINDOW: usize = 10;

/// One U-turn under full rudder, and the circle that follows.
///
/// ```text
/// R_50     = V T_pi/pi                  (50), V straight ahead
/// R_50,t   = V_t T_pi/pi                (50), V_t in the turn, measured there or by [`SurgeModel`]
/// R_steady = V/psi_dot_max
/// R_1      = R_steady R_ref/R_steady,ref
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | V, V_t | `straight_speed_m_s`, `speed_in_turn_m_s` | m/s |
/// | R_50, R_50,t | `u_turn_mean_radius_m`, `at_speed_in_turn_m` and `from_trial_m` | m |
/// | R_steady | `steady_turning_radius_m` | m |
/// | R_ref | steady circle measured at the reference thrust | m |
/// | R_1 | `from_one_u_turn_m` | m |
///
/// The first-order model is identified from deflections of 2 s. In a turn that lasts the hull drifts, and the
/// cross flow turns against the rudder: the steady yaw rate stays below psi_dot_max, and the steady circle is
/// wider than R_steady by 12 to 35 % on the vehicles of this simulator, by 22 % in the paper's own turn (9.9 m against
/// 8.10 m). (50) makes up for it with its 4/-a22 to build up the yaw rate, by luck of the hull: within 8 % on the
/// STARFISH, 5 to 18 % short on the REMUS 100. The shortfall depends on hull and rudder and hardly on speed (lift and
/// cross-flow drag go with V^2), so that one U-turn at one thrust tells it for all, R_1: within 8 % on both.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UTurn {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// The model identified at that thrust.
    pub model: YawModel<f64>,
    /// Computed from the model.
    pub predicted: PredictedTurn,
    /// Measured.
    pub measured: MeasuredTurn,
    /// From the rudder's movement on: north and east, m.
    #[serde(skip)]
    pub track_m: Vec<[f64; 2]>,
    /// Yaw rate of the U-turn, measured and by the model.
    #[serde(skip)]
    pub yaw_rate: Vec<YawRateSample>,
}

/// A turn computed from the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PredictedTurn {
    /// psi_dot_max (47), rad/s, magnitude.
    pub yaw_rate_rad_s: f64,
    /// T_pi (49), s.
    pub u_turn_time_s: f64,
    /// R (50) with the speed straight ahead, m.
    pub u_turn_mean_radius_m: f64,
    /// R (50) with the mean speed in the turn as measured there, m.
    pub at_speed_in_turn_m: f64,
    /// Mean speed in the turn by the speed that doublets of the trial cost, m/s.
    pub speed_in_turn_m_s: Option<f64>,
    /// R (50) with that speed, m: from the trial alone.
    pub from_trial_m: Option<f64>,
    /// V/psi_dot_max, m.
    pub steady_turning_radius_m: f64,
    /// The steady radius by the shortfall measured at the reference thrust, m.
    pub from_one_u_turn_m: f64,
}

/// A turn as it was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeasuredTurn {
    /// Mean forward speed before the turn, m/s.
    pub straight_speed_m_s: f64,
    /// Mean forward speed in the U-turn, m/s.
    pub speed_in_turn_m_s: f64,
    /// Mean yaw rate of the circle after the U-turn, rad/s, magnitude.
    pub yaw_rate_rad_s: f64,
    /// Time from the rudder's movement to a heading change of 180 degrees, s.
    pub u_turn_time_s: f64,
    /// Radius of the circle through the track of the U-turn, m.
    pub u_turn_radius_m: f64,
    /// Its standard error, m.
    pub u_turn_radius_standard_error_m: f64,
    /// Radius of the circle after the U-turn, m.
    pub steady_turning_radius_m: f64,
}

/// Yaw rate at an instant of a U-turn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct YawRateSample {
    /// Time since the rudder moved, s.
    pub time_s: f64,
    /// From the compass, rad/s.
    pub measured_rad_s: f64,
    /// By the model with the rudder of the record, rad/s.
    pub modelled_rad_s: f64,
}

impl UTurn {
    /// Makes a U-turn at the thrust of a point and compares it with the point's model.
    pub(super) fn make<V: Vehicle<f64>>(
        pilot: &mut Pilot<V>,
        point: &SchedulePoint<f64>,
        rudder_limit_rad: f64,
        surge: Option<&SurgeModel>,
        settings: &FieldSettings,
    ) -> Result<Self, FieldError> {
        let thrust = point.thrust.ok_or(FieldError::Missing("thrust"))?;
        let turn = Turn::new(&point.model, rudder_limit_rad, settings.side)
            .map_err(|reason| FieldError::NoTurn { thrust, reason })?;
        let course = pilot.hold(settings.settle_s, thrust)?;
        let averaged_from_s = course.last().map_or(0.0, |s| s.time_s) - AVERAGED_S;
        let averaged = course.partition_point(|s| s.time_s < averaged_from_s);
        let speed = |s: &Sample<f64>| s.surge_speed_m_s;
        let straight_speed_m_s = mean(&course[averaged..], "forward speed", speed)?;
        let samples = go_round(pilot, turn.rudder_rad, thrust)?;
        // A rudder asked for acts from the next sample on.
        let samples = &samples[1..];
        let turned = turned_rad(samples);
        let [half, whole] = half_and_whole(&turned, thrust)?;
        let (u_turn, circle) = (&samples[..=half], &samples[half..=whole]);
        let fit = |samples: &[Sample<f64>]| {
            CircleFit::new(&track(samples)?)
                .map_err(|reason| FieldError::NoCircle { thrust, reason })
        };
        let (u_turn_circle, steady_circle) = (fit(u_turn)?, fit(circle)?);
        let speed_in_turn_m_s = mean(u_turn, "forward speed", speed)?;
        let lasted_s = |part: &[Sample<f64>]| part[part.len() - 1].time_s - part[0].time_s;
        Ok(Self {
            thrust,
            model: point.model,
            predicted: PredictedTurn::of(&turn, straight_speed_m_s, speed_in_turn_m_s, surge),
            measured: MeasuredTurn {
                straight_speed_m_s,
                speed_in_turn_m_s,
                yaw_rate_rad_s: (turned[whole] - turned[half]).abs() / lasted_s(circle),
                u_turn_time_s: lasted_s(u_turn),
                u_turn_radius_m: u_turn_circle.radius_m,
                u_turn_radius_standard_error_m: u_turn_circle.radius_standard_error_m,
                steady_turning_radius_m: steady_circle.radius_m,
            },
            track_m: track(samples)?,
            yaw_rate: yaw_rates(&point.model, u_turn)?,
        })
    }
}

impl PredictedTurn {
    /// The turn at a speed straight ahead, by the speed in the turn as measured there and as `surge` has it.
    fn of(
        turn: &Turn<f64>,
        straight_speed_m_s: f64,
        measured_speed_m_s: f64,
        surge: Option<&SurgeModel>,
    ) -> Self {
        let steady_turning_radius_m = turn.steady_turning_radius_m(straight_speed_m_s);
        let u_turn_time_s = turn.u_turn_time_s();
        let speed_in_turn_m_s = surge.and_then(|surge| {
            surge.mean_speed_in_turn_m_s(straight_speed_m_s, steady_turning_radius_m, u_turn_time_s)
        });
        Self {
            yaw_rate_rad_s: turn.yaw_rate_rad_s,
            u_turn_time_s,
            u_turn_mean_radius_m: turn.u_turn_mean_radius_m(straight_speed_m_s),
            at_speed_in_turn_m: turn.u_turn_mean_radius_m(measured_speed_m_s),
            speed_in_turn_m_s,
            from_trial_m: speed_in_turn_m_s.map(|speed| turn.u_turn_mean_radius_m(speed)),
            steady_turning_radius_m,
            from_one_u_turn_m: steady_turning_radius_m,
        }
    }
}

/// Holds the rudder until the vehicle has turned round.
fn go_round<V: Vehicle<f64>>(
    pilot: &mut Pilot<V>,
    rudder_rad: f64,
    thrust: f64,
) -> Result<Vec<Sample<f64>>, FieldError> {
    let mut turned_rad = 0.0;
    let mut last_rad = None;
    pilot.steer(LONGEST_S, thrust, |sample| {
        let before_rad = last_rad.replace(sample.heading_rad);
        turned_rad += before_rad.map_or(0.0, |before| (sample.heading_rad - before).wrapped());
        (turned_rad.abs() < WHOLE_RAD).then_some(Steering::Rudder(rudder_rad))
    })
}

/// The samples at which the heading had changed by half a turn and by a whole one.
fn half_and_whole(turned_rad: &[f64], thrust: f64) -> Result<[usize; 2], FieldError> {
    let at = |angle_rad: f64| turned_rad.iter().position(|x| x.abs() >= angle_rad);
    at(PI).zip(at(WHOLE_RAD - 0.1)).map(|(half, whole)| [half, whole]).ok_or(FieldError::NotRound {
        thrust,
        turned_rad: turned_rad.last().copied().unwrap_or(0.0),
        seconds: LONGEST_S,
    })
}

/// The reference: the thrust in the middle.
pub(super) fn reference(u_turns: &[UTurn]) -> Option<&UTurn> {
    u_turns.get(u_turns.len() / 2)
}

/// Carries the shortfall of the steady yaw rate from the reference to every thrust.
pub(super) fn transfer(u_turns: &mut [UTurn]) {
    let wider = reference(u_turns)
        .map(|turn| turn.measured.steady_turning_radius_m / turn.predicted.steady_turning_radius_m);
    for turn in u_turns {
        turn.predicted.from_one_u_turn_m =
            turn.predicted.steady_turning_radius_m * wider.unwrap_or(1.0);
    }
}

fn track(samples: &[Sample<f64>]) -> Result<Vec<[f64; 2]>, FieldError> {
    let points: Option<Vec<[f64; 2]>> =
        samples.iter().map(|s| Some([s.north_m?, s.east_m?])).collect();
    points.ok_or(FieldError::Missing("position"))
}

/// The measured yaw rate (Savitzky-Golay) and that of the model from rest (Fig. 15b).
fn yaw_rates(
    model: &YawModel<f64>,
    samples: &[Sample<f64>],
) -> Result<Vec<YawRateSample>, FieldError> {
    let start_s = samples[0].time_s;
    let times_s: Vec<f64> = samples.iter().map(|s| s.time_s - start_s).collect();
    let measured =
        SavitzkyGolay::new(HALF_WINDOW, 2)?.derivative(&times_s, &turned_rad(samples))?;
    let mut state = YawState::default();
    let mut modelled = vec![0.0];
    for pair in samples.windows(2) {
        state = model.advance(state, pair[0].rudder_rad, pair[1].time_s - pair[0].time_s);
        modelled.push(state.yaw_rate_rad_s);
    }
    let together = times_s.into_iter().zip(measured).zip(modelled);
    Ok(together
        .map(|((time_s, measured_rad_s), modelled_rad_s)| YawRateSample {
            time_s,
            measured_rad_s,
            modelled_rad_s,
        })
        .collect())
}

/// R (50) of a model to a side.
pub(super) fn mean_radius_m(
    model: &YawModel<f64>,
    rudder_limit_rad: f64,
    side: Side,
    surge_speed_m_s: f64,
) -> Option<f64> {
    let turn = Turn::new(model, rudder_limit_rad, side).ok()?;
    Some(turn.u_turn_mean_radius_m(surge_speed_m_s))
}
