//! The configuration of MOOS-IvP's uSimMarine.

use std::fmt::Write as _;

use seatrial_core::{Side, Turn};
use seatrial_sim::IdentifiedVehicle;
use seatrial_sim::identified::IdentifiedSpeed;

use super::{head, single_speed};
use crate::Error;

/// A block `ProcessConfig = uSimMarine` that turns and speeds up as the vehicle does in the steady state.
///
/// uSimMarine turns at once, at rudder/100 turn_rate thrust/50 degrees a second with rudder and thrust in per cent
/// (`SimEngine::propagateHeading`), and changes its speed at constant rates.
pub(super) fn configuration(
    vehicle: &IdentifiedVehicle,
    at: &IdentifiedSpeed,
) -> Result<String, Error> {
    let turn = |side| {
        Turn::new(&at.model(), vehicle.rudder.limit_rad, side).map_err(|reason| {
            Error::Input(format!(
                "{}: no steady turn at {} m/s: {reason}; choose another speed with --at-thrust",
                vehicle.name, at.surge_speed_m_s
            ))
        })
    };
    let rates = [turn(Side::Starboard)?, turn(Side::Port)?].map(|turn| turn.yaw_rate_rad_s);
    let mean_deg_s = 0.5 * (rates[0] + rates[1]).to_degrees();
    let thrust_percent = 100.0 * at.thrust;
    let time_s = match vehicle.surge.drag_length_m {
        Some(l) => 0.5 * l / at.surge_speed_m_s,
        None => vehicle.surge.time_constant_s,
    };
    let mut cannot = single_speed(vehicle, at);
    cannot.extend([
        format!(
            "the yaw's time constant of {} s: uSimMarine turns at once",
            1.0 / at.a22_per_s.abs()
        ),
        format!(
            "the offset: it turns {} deg/s to starboard and {} to port, here alike",
            rates[0].to_degrees(),
            rates[1].to_degrees()
        ),
        "the drag: speed changes at a constant rate, that of half the speed within its time constant".into(),
        "the turn's loss of speed, which uSimMarine fixes at 85 % under full rudder; uSimMarineV22 has turn_spd_loss".into(),
    ]);
    let mut text = String::new();
    for line in head(vehicle, &cannot) {
        let _ = writeln!(text, "// {line}");
    }
    let map: Vec<String> = std::iter::once("0:0".to_owned())
        .chain(
            vehicle
                .speeds
                .iter()
                .map(|p| format!("{:?}:{:?}", 100.0 * p.thrust, p.surge_speed_m_s)),
        )
        .collect();
    let _ = write!(
        text,
        "// DESIRED_RUDDER 100 is {} degrees of rudder.\nProcessConfig = uSimMarine\n{{\n  AppTick = 10\n  CommsTick = 10\n  \
         thrust_map = {}\n  turn_rate = {:?}\n  max_acceleration = {:?}\n  max_deceleration = {:?}\n}}\n",
        vehicle.rudder.limit_rad.to_degrees(),
        map.join(", "),
        mean_deg_s * 50.0 / thrust_percent,
        0.5 * at.surge_speed_m_s / time_s,
        0.5 * at.surge_speed_m_s / time_s,
    );
    Ok(text)
}
