//! ArduPilot parameters.

use std::fmt::Write as _;

use super::cascade::Cascade;
use super::{OperatingPoint, Parameter, VehicleType};

/// g of `ATC_TURN_MAX_G`, m/s^2.
const GRAVITY_M_S2: f64 = 9.80665;
/// Rover divides steering by the speed over this one, and takes slower turns for turns at this speed, m/s.
const SCALING_SPEED_M_S: f64 = 1.0;

/// The parameters that the model determines.
///
/// ```
/// use seatrial::gains::export::{OperatingPoint, VehicleType, ardupilot};
/// use seatrial_core::{SchedulePoint, YawModel};
///
/// let point = OperatingPoint {
///     source: "trial 3".into(),
///     at: SchedulePoint {
///         thrust: Some(0.8),
///         surge_speed_m_s: Some(1.0),
///         model: YawModel::from_theta([-1.0, 2.0, 0.0]),
///     },
///     damping_ratio: 0.7,
///     full_rudder_rad: 0.5,
///     seen_rudder_rad: Some(0.26),
///     allowance: Default::default(),
///     covariance: None,
///     notes: Vec::new(),
/// };
/// let parameters = ardupilot::parameters(&point, VehicleType::Surface);
/// // alpha/B with B = 2 1/s^2 times 0.5 rad.
/// let found = parameters.iter().find(|parameter| parameter.name == "ATC_STR_RAT_FF");
/// assert_eq!(found.map(|parameter| parameter.value), Some(1.0));
/// assert!(point.extrapolation().is_some_and(|words| words.contains("EXTRAPOLATED")));
/// ```
pub fn parameters(point: &OperatingPoint, vehicle: VehicleType) -> Vec<Parameter> {
    point.parameters(match vehicle {
        VehicleType::Surface => rover,
        VehicleType::Underwater => sub,
    })
}

/// A `.param` file: comments and `NAME,value`.
///
/// ```
/// use seatrial::gains::export::{OperatingPoint, VehicleType, ardupilot};
/// use seatrial_core::{SchedulePoint, YawModel};
///
/// # let point = OperatingPoint {
/// #     source: "trial 3".into(),
/// #     at: SchedulePoint {
/// #         thrust: Some(0.8),
/// #         surge_speed_m_s: Some(1.0),
/// #         model: YawModel::from_theta([-1.0, 2.0, 0.0]),
/// #     },
/// #     damping_ratio: 0.7,
/// #     full_rudder_rad: 0.5,
/// #     seen_rudder_rad: Some(0.26),
/// #     allowance: Default::default(),
/// #     covariance: None,
/// #     notes: Vec::new(),
/// # };
/// let file = ardupilot::param_file(&point, VehicleType::Surface);
/// assert!(file.lines().any(|line| line == "ATC_STR_RAT_FF,1"));
/// ```
pub fn param_file(point: &OperatingPoint, vehicle: VehicleType) -> String {
    let firmware = match vehicle {
        VehicleType::Surface => "Rover",
        VehicleType::Underwater => "Sub",
    };
    let mut text = point.heading(&format!("ArduPilot {firmware} parameters by seatrial"));
    for parameter in parameters(point, vehicle) {
        let Parameter { name, value, .. } = parameter;
        let _ = writeln!(text, "{}\n{name},{}", parameter.comment(), value as f32);
    }
    text
}

/// steering = F r_d + P (r_d - r) + I integral, scaled by the speed.
fn rover(point: &OperatingPoint) -> Vec<Parameter> {
    let speed = point.at.surge_speed_m_s;
    let scaling = speed.map_or(1.0, |speed| (SCALING_SPEED_M_S / speed).min(1.0));
    let cascade =
        point.cascade(point.full_rudder_rad * scaling, Cascade::with_feed_forward).flatten();
    let base = speed.map_or(0.0, |_| SCALING_SPEED_M_S);
    let mut parameters = determined! {
        "MOT_SPD_SCA_BASE", cascade.map(|_| base), "m/s", "steering is divided by the speed above this one (0: never); B = |b2| full rudder min(1, base/V)";
        "ATC_STR_RAT_FF", cascade.map(|c| c.feed_forward_s), "1/(rad/s)", "alpha/B: the steering of a steady turn";
        "ATC_STR_RAT_P", cascade.map(|c| c.rate_gain_s), "1/(rad/s)", "p/B with the pole of the integral p = w^2/(5 alpha)";
        "ATC_STR_RAT_I", cascade.map(|c| c.rate_integral_gain), "1/rad", "x/B with x the smaller root of x^2 - (w^2 + p alpha) x + p w^2 (alpha + p)";
        "ATC_STR_RAT_D", cascade.map(|_| 0.0), "s/(rad/s)", "none in the design";
        "ATC_STR_ANG_P", cascade.map(|c| c.angle_gain_per_s), "1/s", "p w^2/x: heading poles s^2 + alpha s + w^2, those of K_p";
    };
    parameters.extend(rover_limits(point));
    parameters
}

fn rover_limits(point: &OperatingPoint) -> Vec<Parameter> {
    let yaw_rate = point.yaw_rate_limit_rad_s();
    let turn = yaw_rate.zip(point.at.surge_speed_m_s);
    limits! {
        "ATC_STR_RAT_MAX", yaw_rate.map(f64::to_degrees), "deg/s", "r_max";
        "ATC_STR_ACC_MAX", point.yaw_acceleration_limit_rad_s2().map(f64::to_degrees), "deg/s^2", "alpha r_max = |b2| full rudder - |C0|";
        "ATC_TURN_MAX_G", turn.map(|(rate, speed)| rate * speed.max(SCALING_SPEED_M_S) / GRAVITY_M_S2), "g", "r_max max(V, 1 m/s)/g";
        "TURN_RADIUS", turn.map(|(rate, speed)| speed / rate), "m", "V/r_max";
    }
}

/// steering = P (r_d - r) + I integral: Sub takes no feed-forward.
fn sub(point: &OperatingPoint) -> Vec<Parameter> {
    let cascade = point.cascade(point.full_rudder_rad, Cascade::without_feed_forward);
    let acceleration = point.yaw_acceleration_limit_rad_s2();
    let mut parameters = determined! {
        "ATC_RAT_YAW_P", cascade.map(|c| c.rate_gain_s), "1/(rad/s)", "alpha/B with B = |b2| full rudder";
        "ATC_RAT_YAW_I", cascade.map(|c| c.rate_integral_gain), "1/rad", "alpha^2/B: its zero cancels the vehicle's own pole";
        "ATC_RAT_YAW_D", cascade.map(|_| 0.0), "s/(rad/s)", "none in the design";
        "ATC_ANG_YAW_P", cascade.map(|c| c.angle_gain_per_s), "1/s", "w^2/alpha: heading poles s^2 + alpha s + w^2, those of K_p";
    };
    parameters.extend(limits! {
        "ATC_RATE_Y_MAX", point.yaw_rate_limit_rad_s().map(f64::to_degrees), "deg/s", "r_max";
        "ATC_ACCEL_Y_MAX", acceleration.map(|a| 100.0 * a.to_degrees()), "cdeg/s^2", "alpha r_max = |b2| full rudder - |C0|";
    });
    parameters
}
