//! Vehicles by name, as every verb takes them.

use std::path::Path;
use std::sync::Arc;

use seatrial_app::simulated::Simulator;
use seatrial_app::trial_run::TrialVehicle;
use seatrial_app::vehicles::{OnMavlink, OnRos2};

use crate::autopilot::{AtTerminal, LinkArgs, address};
use crate::output::Failure;

/// The vehicle of this name. `scenario` has the faults of a simulated one; what a trial changes on an autopilot is kept
/// beside the logbook.
pub fn named(
    name: &str,
    scenario: Option<&Path>,
    link: &LinkArgs,
    logbook: &Path,
) -> Result<Box<dyn TrialVehicle>, Failure> {
    Ok(match name.split_once(':') {
        Some(("mavlink", _)) => Box::new(autopilot(name, link, logbook)?),
        Some(("ros2", file)) => Box::new(OnRos2::new(name, file, Arc::new(AtTerminal))),
        _ => Box::new(Simulator::new(name, scenario)?),
    })
}

/// The autopilot of this name, mavlink:ADDRESS, on which trials may be run, and whose gains may be tried.
pub fn autopilot(name: &str, link: &LinkArgs, logbook: &Path) -> Result<OnMavlink, Failure> {
    let attendant = Arc::new(AtTerminal);
    Ok(OnMavlink::new(
        name,
        address(name)?,
        link.options()?,
        logbook,
        attendant,
    )?)
}
