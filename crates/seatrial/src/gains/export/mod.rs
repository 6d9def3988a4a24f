//! Gains and limits in the form that controllers read: autopilot parameters, ROS 2, JSON, C.
//!
//! The numbers are made in [`Schedule`], [`OperatingPoint`] and [`cascade`]; a format only writes them down.
//! `docs/exports.md` derives each of them and says where its parameter is defined.

/// A table of parameters: name, value, unit, why.
macro_rules! determined {
    ($($name:literal, $value:expr, $unit:literal, $why:literal;)*) => {
        Parameter::determined(&[$(($name, $value, $unit, $why)),*])
    };
}

/// [`determined`] of parameters that are limits.
macro_rules! limits {
    ($($row:tt)*) => {
        Parameter::as_limits(determined!($($row)*))
    };
}

pub mod ardupilot;
mod c_header;
pub mod cascade;
mod operating_point;
pub mod px4;
mod ros2;

use seatrial_core::NoGain;
use seatrial_core::SchedulePoint;
use seatrial_core::heading_loop::LoopTiming;
use serde::Serialize;

use crate::figures::three_figures;
use crate::gain_allowance::{GainAllowance, longest};

use operating_point::yaw_rate_limit_rad_s;
pub use operating_point::{OperatingPoint, Parameter};

/// The control law of [`Schedule`].
const LAW: &str = "rudder_rad = limit(proportional_gain * wrap(desired_heading_rad - heading_rad) + feed_forward_rudder_rad, rudder_limit_rad)";

/// Which firmware of an autopilot the parameters are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VehicleType {
    /// A boat: ArduPilot Rover, PX4 Ackermann rover.
    Surface,
    /// An underwater vehicle: ArduPilot Sub, PX4 UUV.
    Underwater,
}

/// What a heading controller needs and nothing else, over speed or thrust.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Schedule {
    schema: &'static str,
    law: &'static str,
    source: String,
    damping_ratio: f64,
    /// What the gains allow for.
    timing: LoopTiming<f64>,
    rudder_limit_rad: f64,
    /// The vehicle's rudder at full steering, where it is known.
    full_rudder_rad: Option<f64>,
    /// What has to be known of the source.
    notes: Vec<String>,
    points: Vec<Point>,
}

/// One row of a [`Schedule`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Point {
    thrust: Option<f64>,
    surge_speed_m_s: Option<f64>,
    proportional_gain: f64,
    feed_forward_rudder_rad: f64,
    /// Steady, under full rudder to its weaker side.
    yaw_rate_limit_rad_s: Option<f64>,
    /// The circle of that turn.
    turning_radius_m: Option<f64>,
}

impl Schedule {
    /// The gains of each model for this damping ratio, in order of speed, or of thrust where a speed is missing.
    ///
    /// ```
    /// use seatrial::GainAllowance;
    /// use seatrial::gains::{DAMPING_RATIO, export::Schedule};
    /// use seatrial_core::{NoGain, SchedulePoint, YawModel};
    ///
    /// let at = |a22| {
    ///     let model = YawModel::from_theta([a22, 1.0, 0.0]);
    ///     let point = SchedulePoint { thrust: Some(0.8), surge_speed_m_s: Some(1.6), model };
    ///     [(point, GainAllowance::default())]
    /// };
    /// assert!(Schedule::design("trial 3", &at(-1.0), DAMPING_RATIO, 0.26).is_ok());
    /// let unstable = Schedule::design("trial 3", &at(0.1), DAMPING_RATIO, 0.26);
    /// assert_eq!(unstable.err(), Some(NoGain::CourseUnstable));
    /// ```
    pub fn design(
        source: &str,
        models: &[(SchedulePoint<f64>, GainAllowance)],
        damping_ratio: f64,
        rudder_limit_rad: f64,
    ) -> Result<Self, NoGain> {
        let point = |(at, allowance): &(SchedulePoint<f64>, GainAllowance)| {
            let gain = allowance.design(&at.model, damping_ratio)?;
            let yaw_rate_limit_rad_s = yaw_rate_limit_rad_s(&at.model, rudder_limit_rad);
            Ok(Point {
                thrust: at.thrust,
                surge_speed_m_s: at.surge_speed_m_s,
                proportional_gain: gain.proportional_gain,
                feed_forward_rudder_rad: gain.feed_forward_rudder_rad,
                yaw_rate_limit_rad_s,
                turning_radius_m: at
                    .surge_speed_m_s
                    .zip(yaw_rate_limit_rad_s)
                    .map(|(speed, rate)| speed / rate),
            })
        };
        let mut points: Vec<Point> = models.iter().map(point).collect::<Result<_, _>>()?;
        let by_speed = points.iter().all(|p| p.surge_speed_m_s.is_some());
        let key = |p: &Point| if by_speed { p.surge_speed_m_s } else { p.thrust }.unwrap_or(0.0);
        points.sort_by(|a, b| key(a).total_cmp(&key(b)));
        Ok(Self {
            schema: "seatrial.gain_schedule.v1",
            law: LAW,
            source: source.into(),
            damping_ratio,
            timing: longest(models.iter().map(|(_, allowance)| *allowance)),
            rudder_limit_rad,
            full_rudder_rad: None,
            notes: Vec::new(),
            points,
        })
    }

    /// Says what the vehicle's rudder is at full steering, rad.
    pub fn with_full_rudder(self, full_rudder_rad: Option<f64>) -> Self {
        Self { full_rudder_rad, ..self }
    }

    /// Says what a user has to know of the source.
    pub fn noting(self, notes: Vec<String>) -> Self {
        Self { notes, ..self }
    }

    /// What the gains allow for, for a comment.
    fn allows_for(&self) -> String {
        format!(
            "The gains allow for {} and the least damped model of each 95 % interval",
            delays(&self.timing)
        )
    }

    /// What has to be known, a comment a line.
    fn note_lines(&self, begin: &str) -> String {
        let lines = self.notes.iter();
        lines.map(|note| format!("{begin}{}\n", comment(note))).collect()
    }

    /// The columns that every point has: name, unit and values.
    fn columns(&self) -> Vec<(&'static str, &'static str, Vec<f64>)> {
        let column = |name, unit, value: fn(&Point) -> Option<f64>| {
            let values: Option<Vec<f64>> = self.points.iter().map(value).collect();
            values.map(|values| (name, unit, values))
        };
        [
            column("surge_speed_m_s", "m/s", |p| p.surge_speed_m_s),
            column("thrust", "fraction of full", |p| p.thrust),
            column("proportional_gain", "rad/rad", |p| Some(p.proportional_gain)),
            column("feed_forward_rudder_rad", "rad", |p| Some(p.feed_forward_rudder_rad)),
            column("yaw_rate_limit_rad_s", "rad/s, steady under full rudder, weaker side", |p| {
                p.yaw_rate_limit_rad_s
            }),
            column("turning_radius_m", "m, circle of that turn", |p| p.turning_radius_m),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

/// A number with a decimal point and without an exponent, which every reader takes for floating point.
fn decimal(value: f64) -> String {
    let text = value.to_string();
    if text.contains('.') { text } else { text + ".0" }
}

/// What a loop waits for, in words.
fn delays(timing: &LoopTiming<f64>) -> String {
    let hold = timing.sample_interval_s.map_or_else(
        || "a continuous controller".into(),
        |interval_s| format!("a rudder held over {} s", three_figures(interval_s)),
    );
    format!("{} s of delay, {hold}", three_figures(timing.delay_s))
}

/// Columns that a line of a comment may take.
const COMMENT_WIDTH: usize = 80;

/// Text as lines of a comment that begin with `#` and hold no more than 80 columns.
fn comment_lines(note: &str) -> String {
    let mut text = String::from("#");
    let mut columns = 1;
    for word in comment(note).split_whitespace() {
        let length = word.chars().count();
        let is_full = columns > 1 && columns + 1 + length > COMMENT_WIDTH;
        let before = if is_full { "\n#  " } else { " " };
        columns = length + if is_full { 3 } else { columns + 1 };
        text += before;
        text += word;
    }
    text
}

/// Text for a comment of one line, in C too.
fn comment(text: &str) -> String {
    text.replace(char::is_control, " ").replace("*/", "* /")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_numbers_are_floating_point_in_every_format() {
        for (value, text) in
            [(1.0, "1.0"), (-0.25, "-0.25"), (1e-7, "0.0000001"), (1e16, "10000000000000000.0")]
        {
            assert_eq!(decimal(value), text);
        }
    }

    #[test]
    fn exact_a_comment_cannot_end_early() {
        assert_eq!(comment("a*/b\nc"), "a* /b c");
    }
}
