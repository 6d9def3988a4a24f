//! What follows from models: turns, gains, schedules.

use pyo3::prelude::*;
use seatrial_core::schedule::{Beyond, ScheduleKey, ScheduleValue};
use seatrial_core::turning::{Side, Turn};
use seatrial_core::{HeadingGain, SchedulePoint, SpeedSchedule, YawModel};

use crate::{error, usage};

/// rad/s, rad, s, s, m, m.
type Limits = (f64, f64, f64, f64, Option<f64>, Option<f64>);

/// Yaw rate, rudder, rise time, U-turn time, mean and steady radius.
#[pyfunction]
pub fn turn(
    py: Python<'_>,
    theta: [f64; 3],
    rudder_limit_rad: f64,
    starboard: bool,
    surge_speed_m_s: Option<f64>,
) -> PyResult<Limits> {
    let hand = if starboard { Side::Starboard } else { Side::Port };
    let turn = Turn::new(&YawModel::from_theta(theta), rudder_limit_rad, hand)
        .map_err(|none| error(py, "RejectedError", none))?;
    Ok((
        turn.yaw_rate_rad_s,
        turn.rudder_rad,
        turn.rise_time_s(),
        turn.u_turn_time_s(),
        surge_speed_m_s.map(|speed| turn.u_turn_mean_radius_m(speed)),
        surge_speed_m_s.map(|speed| turn.steady_turning_radius_m(speed)),
    ))
}

/// K_p and the feed-forward rudder.
#[pyfunction]
pub fn gain(py: Python<'_>, theta: [f64; 3], damping_ratio: f64) -> PyResult<(f64, f64)> {
    HeadingGain::design(&YawModel::from_theta(theta), damping_ratio)
        .map(|gain| (gain.proportional_gain, gain.feed_forward_rudder_rad))
        .map_err(|none| error(py, "RejectedError", none))
}

/// Models over speed or thrust.
#[pyclass(module = "seatrial._native")]
pub struct Schedule(SpeedSchedule<f64>);

type Point = (Option<f64>, Option<f64>, [f64; 3]);

#[pymethods]
impl Schedule {
    #[new]
    fn new(py: Python<'_>, points: Vec<Point>, by_speed: bool) -> PyResult<Self> {
        let key = if by_speed { ScheduleKey::Speed } else { ScheduleKey::Thrust };
        let points: Vec<SchedulePoint<f64>> = points
            .into_iter()
            .map(|(thrust, surge_speed_m_s, theta)| SchedulePoint {
                thrust,
                surge_speed_m_s,
                model: YawModel::from_theta(theta),
            })
            .collect();
        SpeedSchedule::new(key, &points).map(Self).map_err(|invalid| usage(py, invalid))
    }

    /// Thrust, speed and model there, and whether that lies beyond the points.
    fn lookup(&self, py: Python<'_>, at: f64, extrapolate: bool) -> PyResult<(Point, bool)> {
        let beyond = if extrapolate { Beyond::Extrapolate } else { Beyond::Refuse };
        let found = self.0.lookup(at, beyond).map_err(|refused| usage(py, refused))?;
        let is_extrapolated = matches!(found, ScheduleValue::Extrapolated(_));
        let point = found.value();
        let found = (point.thrust, point.surge_speed_m_s, point.model.theta());
        Ok((found, is_extrapolated))
    }
}
