//! Gains and limits of the controllers of ROS 2 (`ros2_controllers`), and the joints of its hardware.
//!
//! ```text
//! heading:   rudder = K_p (wanted - heading)                       K_p of `HeadingGain::design_delayed`, damping ratio 1/sqrt(2)
//! yaw rate:  rudder = p e + i integral of e,  e = wanted - yaw rate
//!            p = 1/(|b2| (T + theta)),  i = p/T                    T = -1/a22
//! tricycle:  yaw rate = u tan(rudder)/wheelbase,  wheelbase = -u a22/|b2|
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | a22, b2, C0 | damping, authority and offset of the yaw model | 1/s, 1/s^2, rad/s^2 |
//! | u | forward speed | m/s |
//! | theta | dead time and lag of the rudder, and half an interval of the controller | s |
//!
//! Angles and rates of the file are positive to port, as REP-103 has them, and a positive rudder turns to port: with the model's rudder
//! delta and heading psi (clockwise) the joint has -sign(b2) delta and the heading is -psi.
//!
//! Source of p and i: S. Skogestad, Simple analytic rules for model reduction and PID controller tuning, J. Process Control 13 (2003)
//! 291-309, for a closed loop as slow as the vehicle, tau_c = T. Valid for a22 < 0.

use std::fmt::Write as _;

use seatrial::gains::DAMPING_RATIO;
use seatrial::identification::interval_95;
use seatrial::words::three_figures;
use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::{HeadingGain, Side, Turn, YawModel};
use seatrial_sim::IdentifiedVehicle;
use seatrial_sim::identified::IdentifiedSpeed;

use super::{attribute, head, plain, single_speed};
use crate::Error;
use crate::gains::unsure_at;

/// Interval of the controller where the vehicle file has none, s.
const INTERVAL_S: f64 = 0.05;
/// What the controllers take of a vehicle at one speed.
struct Figures {
    heading_gain: f64,
    yaw_rate_gains: [f64; 2],
    wheelbase_m: f64,
    /// Yaw rate under full rudder to port and to starboard, rad/s.
    yaw_rates_rad_s: [f64; 2],
    /// What full rudder accelerates from straight ahead, rad/s^2.
    yaw_accelerations_rad_s2: [f64; 2],
    surge_acceleration_m_s2: f64,
    interval_s: f64,
}

impl Figures {
    fn of(vehicle: &IdentifiedVehicle, at: &IdentifiedSpeed) -> Result<Self, Error> {
        let (model, rudder) = (at.model(), &vehicle.rudder);
        let refused = |what: &str, reason: &dyn std::fmt::Display| {
            Error::Input(format!(
                "{}: {what} at {} m/s: {reason}; choose another speed with --at-thrust",
                vehicle.name, at.surge_speed_m_s
            ))
        };
        let turn = |side| {
            let turn = Turn::new(&model, rudder.limit_rad, side);
            turn.map(|turn| turn.yaw_rate_rad_s)
                .map_err(|reason| refused("no steady turn", &reason))
        };
        let yaw_rates_rad_s = [turn(Side::Port)?, turn(Side::Starboard)?];
        let interval_s = vehicle.sample_interval_s.unwrap_or(INTERVAL_S);
        let timing = timing(vehicle);
        let late_s = timing.delay_s;
        let gain = HeadingGain::design_delayed(&model, DAMPING_RATIO, timing)
            .map_err(|reason| refused("no heading gain", &reason))?;
        let (damping, authority) = (model.a22_per_s.abs(), model.b2_per_s2.abs());
        let proportional = 1.0 / (authority * (1.0 / damping + late_s + 0.5 * interval_s));
        let speed = at.surge_speed_m_s;
        let time_s = match vehicle.surge.drag_length_m {
            Some(length_m) => 0.5 * length_m / speed,
            None => vehicle.surge.time_constant_s,
        };
        Ok(Self {
            heading_gain: gain.proportional_gain.abs(),
            yaw_rate_gains: [proportional, proportional * damping],
            wheelbase_m: speed * damping / authority,
            yaw_rates_rad_s,
            yaw_accelerations_rad_s2: yaw_rates_rad_s.map(|rate| rate * damping),
            surge_acceleration_m_s2: 0.5 * speed / time_s,
            interval_s,
        })
    }
}

/// Where not even the sign of the heading gain is known, in words.
pub(super) fn unsure(vehicle: &IdentifiedVehicle, at: &IdentifiedSpeed) -> Option<String> {
    let timing = timing(vehicle);
    let gain = |model: &YawModel<f64>| {
        Some(HeadingGain::design_delayed(model, DAMPING_RATIO, timing).ok()?.proportional_gain)
    };
    let [low, high] = interval_95(&at.model(), &at.covariance?, gain)?;
    (low <= 0.0 && 0.0 <= high).then(|| unsure_at(&format!("{:.2} m/s", at.surge_speed_m_s)))
}

/// What the loop waits for.
fn timing(vehicle: &IdentifiedVehicle) -> LoopTiming<f64> {
    LoopTiming {
        delay_s: vehicle.rudder.lag_s + vehicle.rudder.delay_s,
        sample_interval_s: Some(vehicle.sample_interval_s.unwrap_or(INTERVAL_S)),
    }
}

/// Parameters of `pid_controller`, `diff_drive_controller` and `tricycle_controller`.
pub(super) fn yaml(vehicle: &IdentifiedVehicle, at: &IdentifiedSpeed) -> Result<String, Error> {
    let figures = Figures::of(vehicle, at)?;
    let mut text = String::new();
    for line in head(vehicle, &not_carried(vehicle, at, &figures)) {
        let _ = writeln!(text, "# {line}");
    }
    let _ = writeln!(
        text,
        "# Heading, yaw rate and rudder_joint are positive to port (REP-103): rudder_joint is {} the rudder of the vehicle file.\n\
         # Run one controller of the rudder at a time. Joint names are those of the URDF that `seatrial export --to ros2_control-urdf` writes.\n\
         controller_manager:\n  ros__parameters:\n    update_rate: {}\n    \
         heading_controller:\n      type: \"pid_controller/PidController\"\n    \
         yaw_rate_controller:\n      type: \"pid_controller/PidController\"\n    \
         diff_drive_controller:\n      type: \"diff_drive_controller/DiffDriveController\"\n    \
         tricycle_controller:\n      type: \"tricycle_controller/TricycleController\"",
        if at.b2_per_s2 > 0.0 { "minus" } else { "equal to" },
        (1.0 / figures.interval_s).round().max(1.0)
    );
    let limit_rad = vehicle.rudder.limit_rad;
    let heading = [figures.heading_gain, 0.0];
    text += &pid("heading_controller", &["position"], heading, limit_rad);
    let gains = figures.yaw_rate_gains;
    text += &pid("yaw_rate_controller", &["velocity"], gains, limit_rad);
    text += &diff_drive(at, &figures);
    text += &tricycle(vehicle, at, &figures);
    Ok(text)
}

fn not_carried(
    vehicle: &IdentifiedVehicle,
    at: &IdentifiedSpeed,
    figures: &Figures,
) -> Vec<String> {
    let mut cannot = single_speed(vehicle, at);
    let offset_rad = at.c0_rad_per_s2 / at.b2_per_s2;
    if offset_rad != 0.0 {
        cannot.push(format!(
            "the rudder that holds a course, {} rad in the sense of the vehicle file: trim it in the hardware; without trim the heading stays \
             off by {} rad, the yaw rate's integral finds it",
            three_figures(-offset_rad),
            three_figures((offset_rad / figures.heading_gain).abs())
        ));
    }
    cannot.push(format!(
        "the lag of the yaw rate behind the rudder, {} s: diff_drive and tricycle take a commanded velocity for reached",
        three_figures(1.0 / at.a22_per_s.abs())
    ));
    cannot.push(
        "in diff_drive_controller: left_wheel_names, right_wheel_names, wheel_separation and wheel_radius, which it requires and no trial of the rudder tells"
            .into(),
    );
    cannot.push(
        "in tricycle_controller: that the yaw rate grows with the rudder, not with its tangent; wheel_radius 1 makes the traction joint's rad/s the forward speed in m/s"
            .into(),
    );
    cannot
}

/// A PID controller of the rudder from the heading or the yaw rate, clamped to its limit.
fn pid(name: &str, interfaces: &[&str], [p, i]: [f64; 2], limit_rad: f64) -> String {
    let is_heading = interfaces.contains(&"position");
    format!(
        "{name}:\n  ros__parameters:\n    dof_names: [\"rudder_joint\"]\n    command_interface: \"position\"\n    \
         reference_and_state_dof_names: [\"heading\"]\n    reference_and_state_interfaces: {interfaces:?}\n    \
         gains:\n      rudder_joint:\n        p: {p:?}\n        i: {i:?}\n        d: 0.0\n        \
         u_clamp_max: {limit_rad:?}\n        u_clamp_min: {:?}\n        i_clamp_max: {limit_rad:?}\n        i_clamp_min: {:?}\n        \
         antiwindup_strategy: \"conditional_integration\"\n        angle_wraparound: {is_heading}\n",
        -limit_rad, -limit_rad
    )
}

/// Limits of the twist: each side has its own.
fn diff_drive(at: &IdentifiedSpeed, figures: &Figures) -> String {
    let [port, starboard] = figures.yaw_rates_rad_s;
    let [to_port, to_starboard] = figures.yaw_accelerations_rad_s2;
    let (speed, surge) = (at.surge_speed_m_s, figures.surge_acceleration_m_s2);
    format!(
        "diff_drive_controller:\n  ros__parameters:\n    linear:\n      x:\n        max_velocity: {speed:?}\n        min_velocity: 0.0\n        \
         max_acceleration: {surge:?}\n        max_deceleration: {:?}\n    angular:\n      z:\n        \
         max_velocity: {port:?}\n        min_velocity: {:?}\n        max_acceleration: {to_port:?}\n        max_deceleration: {:?}\n        \
         max_acceleration_reverse: {:?}\n        max_deceleration_reverse: {to_port:?}\n",
        -surge, -starboard, -to_starboard, -to_starboard
    )
}

fn tricycle(vehicle: &IdentifiedVehicle, at: &IdentifiedSpeed, figures: &Figures) -> String {
    let surge = figures.surge_acceleration_m_s2;
    let rate = vehicle
        .rudder
        .rate_limit_rad_s
        .map_or(String::new(), |rate| format!("      max_velocity: {rate:?}\n"));
    format!(
        "tricycle_controller:\n  ros__parameters:\n    traction_joint_name: \"thruster_joint\"\n    steering_joint_name: \"rudder_joint\"\n    \
         wheelbase: {:?}\n    wheel_radius: 1.0\n    traction:\n      max_velocity: {:?}\n      max_acceleration: {surge:?}\n      \
         max_deceleration: {surge:?}\n    steering:\n      max_position: {:?}\n{rate}",
        figures.wheelbase_m, at.surge_speed_m_s, vehicle.rudder.limit_rad
    )
}

/// The hardware's joints with their limits, an element of URDF.
pub(super) fn urdf(vehicle: &IdentifiedVehicle, at: &IdentifiedSpeed) -> String {
    let limit_rad = vehicle.rudder.limit_rad;
    let mut text = String::from("<!--\n");
    let cannot = [
        "the rudder's fastest motion: it belongs into the <limit velocity> of the URDF's joint"
            .into(),
        "the hardware itself: mock_components/GenericSystem of ros2_control moves nothing".into(),
    ];
    for line in head(vehicle, &cannot) {
        let _ = writeln!(text, "{}", line.replace("--", "- -"));
    }
    let _ = write!(
        text,
        "rudder_joint is positive to port, {} the rudder of the vehicle file; thruster_joint is the forward speed in m/s.\n-->\n\
         <ros2_control name=\"{}\" type=\"system\">\n  <hardware>\n    <plugin>mock_components/GenericSystem</plugin>\n  </hardware>\n  \
         <joint name=\"rudder_joint\">\n    <command_interface name=\"position\">\n      <param name=\"min\">{:?}</param>\n      \
         <param name=\"max\">{limit_rad:?}</param>\n    </command_interface>\n    <state_interface name=\"position\"/>\n  </joint>\n  \
         <joint name=\"thruster_joint\">\n    <command_interface name=\"velocity\">\n      <param name=\"min\">0.0</param>\n      \
         <param name=\"max\">{:?}</param>\n    </command_interface>\n    <state_interface name=\"velocity\"/>\n  </joint>\n  \
         <sensor name=\"heading\">\n    <state_interface name=\"position\"/>\n    <state_interface name=\"velocity\"/>\n  </sensor>\n\
         </ros2_control>\n",
        if at.b2_per_s2 > 0.0 { "minus" } else { "equal to" },
        attribute(&plain(&vehicle.name)),
        -limit_rad,
        at.surge_speed_m_s
    );
    text
}
