//! The first-order vehicle that one of six degrees of freedom passes for.

use seatrial_core::{Event, List, Plan, Trial, Vehicle};

use super::commands::Commands;
use super::config::SixDofConfig;
use super::vehicle::SixDofVehicle;
use crate::body::Body;
use crate::config_error::ConfigError;
use crate::faults::{Rehearsable, Upset};
use crate::plant::Truth;

/// Interval at which the speed is watched, s.
const WATCHED_EVERY_S: f64 = 0.1;
/// Time after which a speed has settled, s.
const SETTLED_AFTER_S: f64 = 120.0;

/// What the paper's trial finds at a thrust without noise and in still water; `None` where it finds no model.
///
/// There is no true a22, b2 and C0 of such a vehicle: its yaw hangs on sway, roll and the size of the
/// manoeuvre. This is the answer that noise, disturbance and current are kept from.
pub fn equivalent(config: &SixDofConfig, thrust: f64) -> Result<Option<Truth>, ConfigError> {
    with_rudder_offset(config, thrust, 0.0)
}

/// What [`equivalent`] finds where the rudder stands off its command by an angle, rad: what it then does is not in
/// proportion.
pub fn with_rudder_offset(
    config: &SixDofConfig,
    thrust: f64,
    offset_rad: f64,
) -> Result<Option<Truth>, ConfigError> {
    let mut vehicle = SixDofVehicle::new(config.clone().noise_free(), 0)?;
    vehicle.upset(&Upset { rudder_offset_rad: offset_rad, ..Upset::default() });
    let plan = Plan {
        thrusts: List::from_slice(&[thrust]).unwrap_or_default(),
        max_repeats: 0,
        ..Plan::paper()
    };
    let mut trial = Trial::new(plan).map_err(|error| ConfigError::Unfit {
        field: error.field.into(),
        requirement: error.requirement,
    })?;
    let mut found = None;
    while let Ok(Some(sample)) = vehicle.next_sample() {
        let action = trial.step(&sample);
        while let Some(event) = trial.take_event() {
            if let Event::RunFinished { result, .. } = event {
                found = result.surge_speed_m_s.map(|surge_speed_m_s| Truth {
                    thrust,
                    surge_speed_m_s,
                    model: result.model,
                });
            }
        }
        if action.outcome.is_some() {
            break;
        }
        let Ok(()) = vehicle.act(&action);
    }
    Ok(found)
}

/// Time in which the speed makes 63 % of its change from the vehicle's own thrust to full thrust at its depth, s.
pub fn surge_time_constant_s(config: &SixDofConfig) -> Result<f64, ConfigError> {
    let mut body = SixDofVehicle::new(config.clone().noise_free(), 0)?.into_body();
    let ahead = Commands { thrust: 1.0, rudder_rad: 0.0, elevator_rad: None };
    let mut speeds_m_s = Vec::new();
    for _ in 0..(SETTLED_AFTER_S / WATCHED_EVERY_S) as u32 {
        speeds_m_s.push(body.motion().surge_speed_m_s);
        body.drive(&ahead, 0.0, WATCHED_EVERY_S);
    }
    let (before, after) = (speeds_m_s[0], body.motion().surge_speed_m_s);
    let reached = before + (1.0 - libm::exp(-1.0)) * (after - before);
    let instants =
        speeds_m_s.partition_point(|speed| (speed - before).abs() < (reached - before).abs());
    Ok(WATCHED_EVERY_S * instants as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::six_dof::{remus100, starfish};

    #[test]
    fn regress_equivalents_are_course_stable_and_grow_with_thrust() {
        for config in [remus100::config(), starfish::config()] {
            let at = |thrust| equivalent(&config, thrust).unwrap().unwrap();
            let (slow, fast) = (at(0.6), at(1.0));
            assert!(fast.model.a22_per_s < slow.model.a22_per_s && slow.model.a22_per_s < 0.0);
            assert!(fast.model.b2_per_s2 > slow.model.b2_per_s2 && slow.model.b2_per_s2 > 0.0);
            assert!(fast.surge_speed_m_s > slow.surge_speed_m_s);
            // Mass over the slope of the drag: 31 kg and 65 kg at some 12 and 10 kg/s.
            let seconds = surge_time_constant_s(&config).unwrap();
            assert!((1.0..10.0).contains(&seconds), "{seconds}");
        }
    }
}
