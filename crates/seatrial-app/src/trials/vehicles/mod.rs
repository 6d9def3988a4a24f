//! Vehicles that move, over their links: what a trial and a commission do with them before, at and after it.

pub mod ardupilot_json;
mod attendant;
mod gains_lease;
mod mavlink;
mod put_back;
mod ros2;

use crate::trials::order::{Check, VehicleError};
use seatrial::preview::Prior;
use seatrial_core::Plan;

pub use attendant::{Attendant, hand_back_text};
pub use mavlink::{ASSUMED_FULL_RUDDER_DEG, MavlinkOptions, OnMavlink, signing};
pub use put_back::{compared, read_backup, restored};
pub use ros2::{OnRos2, inspect as inspect_ros2};

/// Refuses where a check has not passed.
fn refuse(checks: &[Check]) -> Result<(), VehicleError> {
    let refused: Vec<&str> =
        checks.iter().filter(|check| !check.passed).map(|check| check.name.as_str()).collect();
    if refused.is_empty() {
        return Ok(());
    }
    Err(VehicleError::refused(format!("the trial is refused for: {}", refused.join(", "))))
}

/// A vehicle whose model nobody knows yet.
fn no_prior(name: &str) -> Result<Prior, VehicleError> {
    Err(VehicleError::setting(format!(
        "{name}: how it steers is not known before its trial; preview the plan on a simulator"
    )))
}

/// The limits of a plan for people.
fn limits(plan: &Plan<f64>) -> String {
    let envelope = &plan.envelope;
    let area = match envelope.area.len() {
        0 => "no area".into(),
        corners => format!("an area of {corners} corners"),
    };
    format!(
        "heading within {:.0} degrees, yaw rate up to {:.0} degrees/s, depth {} to {} m, {area}",
        envelope.heading_excursion_max_rad.to_degrees(),
        envelope.yaw_rate_max_rad_s.to_degrees(),
        envelope.depth_min_m,
        envelope.depth_max_m
    )
}
