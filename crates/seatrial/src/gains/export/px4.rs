//! PX4 parameters.

use std::fmt::Write as _;

use super::cascade::Cascade;
use super::{OperatingPoint, Parameter, VehicleType};

/// MAV_PARAM_TYPE_REAL32 of MAVLink.
const REAL32: u32 = 9;

/// The parameters that the model determines.
pub fn parameters(point: &OperatingPoint, vehicle: VehicleType) -> Vec<Parameter> {
    point.parameters(match vehicle {
        VehicleType::Surface => rover,
        VehicleType::Underwater => underwater,
    })
}

/// A `.params` file as QGroundControl loads it: comments and vehicle, component, name, value and type between tabs.
///
/// ```
/// use seatrial::gains::export::{OperatingPoint, VehicleType, px4};
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
/// let file = px4::params_file(&point, VehicleType::Surface);
/// // As QGroundControl has them: vehicle, component, name, value and type between tabs.
/// let line = file.lines().find(|line| !line.starts_with('#')).unwrap_or_default();
/// assert_eq!(line.split('\t').count(), 5);
/// ```
pub fn params_file(point: &OperatingPoint, vehicle: VehicleType) -> String {
    let module = match vehicle {
        VehicleType::Surface => "Ackermann rover",
        VehicleType::Underwater => "UUV",
    };
    let mut text = point.heading(&format!("PX4 {module} parameters by seatrial"));
    if vehicle == VehicleType::Surface && point.at.surge_speed_m_s.is_none() {
        text += "# RA_WHEEL_BASE and the gains that rely on it need the forward speed, which is not known.\n";
    }
    for parameter in parameters(point, vehicle) {
        let Parameter { name, value, .. } = parameter;
        let comment = parameter.comment();
        let _ = writeln!(text, "{comment}\n1\t1\t{name}\t{}\t{REAL32}", value as f32);
    }
    text
}

/// rudder = atan(r_d L/V) + P (r_d - r) + I integral, L the wheel base.
fn rover(point: &OperatingPoint) -> Vec<Parameter> {
    let speed = point.at.surge_speed_m_s;
    // Steering is an angle here, so B is the acceleration of 1 rad.
    let cascade = speed.and_then(|_| point.cascade(1.0, Cascade::with_feed_forward)).flatten();
    let mut parameters = determined! {
        "RA_MAX_STR_ANG", Some(point.full_rudder_rad), "rad", "the rudder at full steering; other angles here scale with it";
        "RA_WHEEL_BASE", speed.zip(cascade).map(|(speed, c)| speed * c.feed_forward_s), "m", "V alpha/|b2|: the car that turns as fast under a small angle";
        "RO_MAX_THR_SPEED", speed.zip(point.at.thrust).map(|(speed, thrust)| speed / thrust), "m/s", "V/thrust: PX4 takes the speed from the thrust by it, and the feed-forward from that";
        "RO_YAW_RATE_P", cascade.map(|c| c.rate_gain_s), "rad/(rad/s)", "p/|b2| with the pole of the integral p = w^2/(5 alpha)";
        "RO_YAW_RATE_I", cascade.map(|c| c.rate_integral_gain), "rad/rad", "x/|b2| with x the smaller root of x^2 - (w^2 + p alpha) x + p w^2 (alpha + p)";
        "RO_YAW_P", cascade.map(|c| c.angle_gain_per_s), "1/s", "p w^2/x: heading poles s^2 + alpha s + w^2, those of K_p";
    };
    parameters.extend(limits! {
        "RO_YAW_RATE_LIM", point.yaw_rate_limit_rad_s().map(f64::to_degrees), "deg/s", "r_max";
        "RO_YAW_ACCEL_LIM", point.yaw_acceleration_limit_rad_s2().map(f64::to_degrees), "deg/s^2", "alpha r_max = |b2| full rudder - |C0|";
    });
    parameters
}

/// steering = P sin(psi_d - psi) - D r.
fn underwater(point: &OperatingPoint) -> Vec<Parameter> {
    let gain = point.gain();
    determined! {
        "UUV_YAW_P", gain.map(|gain| gain.proportional_gain.abs() / point.full_rudder_rad), "1/rad", "|K_p|/full rudder";
        "UUV_YAW_D", gain.map(|_| 0.0), "1/(rad/s)", "none in the design: the vehicle damps itself";
    }
}
