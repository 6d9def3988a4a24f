//! Vehicles by name, as every verb takes them.

use std::path::Path;

use seatrial_app::commission::GainsVehicle;
use seatrial_app::simulated::Simulator;
use seatrial_app::trial_run::{TrialVehicle, VehicleError};

use crate::autopilot::{LinkArgs, OnMavlink};
use crate::ros2::OnRos2;

/// The vehicle of this name. `scenario` has the faults of a simulated one; what a trial changes on an autopilot is kept
/// beside the logbook.
pub fn named(
    name: &str,
    scenario: Option<&Path>,
    link: &LinkArgs,
    logbook: &Path,
) -> Result<Box<dyn TrialVehicle>, VehicleError> {
    Ok(match name.split_once(':') {
        Some(("mavlink", address)) => Box::new(OnMavlink::new(name, address, link, logbook)?),
        Some(("ros2", file)) => Box::new(OnRos2::new(name, file)),
        _ => Box::new(Simulator::new(name, scenario)?),
    })
}

/// The autopilot of this name, whose gains may be tried; `None` where the name is of another kind of vehicle.
pub fn autopilot(
    name: &str,
    link: &LinkArgs,
    logbook: &Path,
) -> Result<Option<Box<dyn GainsVehicle>>, VehicleError> {
    let Some(address) = name.strip_prefix("mavlink:") else {
        return Ok(None);
    };
    Ok(Some(Box::new(OnMavlink::new(
        name, address, link, logbook,
    )?)))
}
