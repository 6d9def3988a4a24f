//! What a path follower has to know: radius, rate, lookahead and waypoint radius of each speed, with bounds.

use seatrial::gains::DAMPING_RATIO;
use std::fmt::Write as _;

use seatrial::identification::interval_95;
use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::{HeadingGain, Side, Turn, YawModel};
use seatrial_sim::IdentifiedVehicle;
use seatrial_sim::identified::IdentifiedSpeed;

use super::head;
use crate::Error;

/// Time constants of the heading loop that the cross-track error takes: slower than the loop by this factor, the two do not fight.
const SLOWER: f64 = 3.0;

/// A TOML text with one `[[speed]]` for each speed.
///
/// ```text
/// R      = V/r_max                                   Dubins radius to a side, equation (47)
/// lookahead = 3 V/(zeta omega)                       cross-track error decays as e^{-V t/lookahead}
/// waypoint radius = R tan(45 deg) + V (T + lag + delay + rudder's way)   where a turn by 90 degrees has to begin
/// ```
///
/// | symbol | meaning |
/// |---|---|
/// | r_max | steady yaw rate under full rudder to that side |
/// | zeta omega | decay of the heading loop with the gain of `seatrial gains` for a damping ratio of 0.7071 |
/// | T | time constant of the yaw, by which a turn builds up late |
pub(super) fn toml(vehicle: &IdentifiedVehicle) -> Result<String, Error> {
    let mut text = String::new();
    let cannot = ["drift: a hull that does turns wider than its Dubins radius, by 12 to 35 % on the simulated vehicles".to_owned()];
    for line in head(vehicle, &cannot) {
        let _ = writeln!(text, "# {line}");
    }
    text += "# Where the numbers go:\n\
        #   turning radius   ArduPilot TURN_RADIUS, Nav2 minimum_turning_radius and min_turning_r, a Dubins planner's radius\n\
        #   yaw rate         ArduPilot ATC_STR_RAT_MAX [deg/s], PX4 RO_YAW_RATE_LIM [deg/s], Nav2 wz_max\n\
        #   lookahead        ILOS and L1 lookahead distance, MOOS waypoint lead, Nav2 regulated pure pursuit lookahead_dist\n\
        #   waypoint radius  ArduPilot WP_RADIUS, PX4 NAV_ACC_RAD, MOOS waypoint capture_radius\n\
        schema = \"seatrial.guidance.v1\"\n";
    for speed in &vehicle.speeds {
        text += &of_speed(vehicle, speed)?;
    }
    Ok(text)
}

fn of_speed(vehicle: &IdentifiedVehicle, speed: &IdentifiedSpeed) -> Result<String, Error> {
    let limit_rad = vehicle.rudder.limit_rad;
    let velocity = speed.surge_speed_m_s;
    let rudder = &vehicle.rudder;
    // A rudder that moves at a constant rate is late by half the time that it takes.
    let moving_s = rudder.rate_limit_rad_s.map_or(0.0, |rate| 0.5 * limit_rad / rate);
    let late_s = rudder.lag_s + rudder.delay_s + moving_s;
    let rate = move |side| {
        move |model: &YawModel<f64>| Some(Turn::new(model, limit_rad, side).ok()?.yaw_rate_rad_s)
    };
    let radius = move |side| move |model: &YawModel<f64>| Some(velocity / rate(side)(model)?);
    let timing = LoopTiming {
        delay_s: late_s + vehicle.sample_interval_s.unwrap_or(0.0),
        sample_interval_s: vehicle.sample_interval_s,
    };
    let lookahead = move |model: &YawModel<f64>| {
        // The poles of s^2 + alpha s + K_p b2: pairs decay with alpha/2, real ones with the slower of them.
        let gain = HeadingGain::design_delayed(model, DAMPING_RATIO, timing).ok()?;
        let alpha = -model.a22_per_s;
        let stiffness = gain.proportional_gain * model.b2_per_s2;
        let root = (0.25 * alpha * alpha - stiffness).max(0.0).sqrt();
        Some(SLOWER * velocity / (0.5 * alpha - root))
    };
    let waypoint = move |model: &YawModel<f64>| {
        let wider = radius(Side::Starboard)(model)?.max(radius(Side::Port)(model)?);
        Some(wider + velocity * (1.0 / model.a22_per_s.abs() + late_s))
    };
    let mut text =
        format!("\n[[speed]]\nthrust = {:?}\nsurge_speed_m_s = {velocity:?}\n", speed.thrust);
    let mut write = |name: &str, of: &dyn Fn(&YawModel<f64>) -> Option<f64>| {
        let model = speed.model();
        let value = of(&model).ok_or_else(|| {
            Error::Input(format!(
                "{}: no {name} at {velocity} m/s: it does not turn to both sides, or is not stable on its course",
                vehicle.name
            ))
        })?;
        let _ = writeln!(text, "{name} = {value:?}");
        let interval = speed.covariance.and_then(|covariance| interval_95(&model, &covariance, of));
        if let Some([low, high]) = interval {
            let _ = writeln!(text, "{name}_95 = [{low:?}, {high:?}]");
        }
        Ok::<(), Error>(())
    };
    for (side, name) in [(Side::Starboard, "starboard"), (Side::Port, "port")] {
        write(&format!("turning_radius_{name}_m"), &radius(side))?;
        write(&format!("yaw_rate_{name}_rad_s"), &rate(side))?;
    }
    write("lookahead_m", &lookahead)?;
    write("waypoint_radius_m", &waypoint)?;
    Ok(text)
}
