//! Limits of ROS 2's Nav2.

use std::fmt::Write as _;

use seatrial_core::{Side, Turn};
use seatrial_sim::IdentifiedVehicle;
use seatrial_sim::identified::IdentifiedSpeed;

use super::{head, single_speed};
use crate::Error;

/// Parameters of the MPPI controller, the velocity smoother and the Smac planner that keep within what the vehicle can do.
pub(super) fn yaml(vehicle: &IdentifiedVehicle, at: &IdentifiedSpeed) -> Result<String, Error> {
    let turn = |side| {
        Turn::new(&at.model(), vehicle.rudder.limit_rad, side).map_err(|reason| {
            Error::Input(format!(
                "{}: no steady turn at {} m/s: {reason}; choose another speed with --at-thrust",
                vehicle.name, at.surge_speed_m_s
            ))
        })
    };
    let weaker = [turn(Side::Starboard)?, turn(Side::Port)?]
        .into_iter()
        .min_by(|a, b| a.yaw_rate_rad_s.total_cmp(&b.yaw_rate_rad_s))
        .map_or(0.0, |turn| turn.yaw_rate_rad_s);
    let yaw_acceleration = weaker * at.a22_per_s.abs();
    let speed = at.surge_speed_m_s;
    let time_s = match vehicle.surge.drag_length_m {
        Some(l) => 0.5 * l / speed,
        None => vehicle.surge.time_constant_s,
    };
    let surge_acceleration = 0.5 * speed / time_s;
    let radius_m = speed / weaker;
    let slowest = vehicle.speeds[0].surge_speed_m_s;
    let mut cannot = single_speed(vehicle, at);
    cannot.push(format!(
        "the lag of yaw rate behind its command, {} s, and of the speed, {time_s} s: Nav2 takes a commanded velocity for reached",
        1.0 / at.a22_per_s.abs()
    ));
    cannot.push(format!(
        "the slowest speed that it was seen at, {slowest} m/s: slower, it may turn wider; `vx_min` is 0, so that Nav2 can slow down at the goal and before an obstacle"
    ));
    let mut text = String::new();
    for line in head(vehicle, &cannot) {
        let _ = writeln!(text, "# {line}");
    }
    let _ = write!(
        text,
        "# Limits of a turn: full rudder to the weaker side, and what it accelerates from straight ahead.\n\
         controller_server:\n  ros__parameters:\n    FollowPath:\n      plugin: \"nav2_mppi_controller::MPPIController\"\n      \
         motion_model: \"Ackermann\"\n      vx_max: {speed:?}\n      vx_min: 0.0\n      vy_max: 0.0\n      wz_max: {weaker:?}\n      \
         ax_max: {surge_acceleration:?}\n      ax_min: {:?}\n      az_max: {yaw_acceleration:?}\n      AckermannConstraints:\n        \
         min_turning_r: {radius_m:?}\n\
         velocity_smoother:\n  ros__parameters:\n    max_velocity: [{speed:?}, 0.0, {weaker:?}]\n    \
         min_velocity: [0.0, 0.0, {:?}]\n    max_accel: [{surge_acceleration:?}, 0.0, {yaw_acceleration:?}]\n    \
         max_decel: [{:?}, 0.0, {:?}]\n\
         planner_server:\n  ros__parameters:\n    GridBased:\n      plugin: \"nav2_smac_planner::SmacPlannerHybrid\"\n      \
         motion_model_for_search: \"DUBIN\"\n      minimum_turning_radius: {radius_m:?}\n",
        -surge_acceleration, -weaker, -surge_acceleration, -yaw_acceleration
    );
    Ok(text)
}
