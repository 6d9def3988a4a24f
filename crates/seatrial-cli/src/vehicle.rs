//! Vehicles by name, as every verb takes them.

use std::path::Path;
use std::sync::Arc;

use seatrial_app::trials::order::TrialVehicle;
use seatrial_app::trials::simulator::Simulator;
use seatrial_app::trials::vehicles::{OnMavlink, OnRos2};

use crate::autopilot::{AtTerminal, LinkArgs, address};
use crate::output::Failure;

/// The kinds of vehicles, for who mistyped one.
const KINDS: &str = "expected sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml for a simulated one; mavlink:udp:HOST:PORT, \
    mavlink:udpout:HOST:PORT, mavlink:tcp:HOST:PORT or mavlink:serial:DEVICE:BAUD for an autopilot; ros2:FILE.toml for one on ROS 2";

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
        Some(("sim", _)) => Box::new(Simulator::new(name, scenario)?),
        _ => {
            return Err(Failure::usage(format!(
                "--vehicle {name}: no such kind of vehicle; {KINDS}"
            )));
        }
    })
}

/// The autopilot of this name, mavlink:ADDRESS, on which trials may be run, and whose gains may be tried.
pub fn autopilot(name: &str, link: &LinkArgs, logbook: &Path) -> Result<OnMavlink, Failure> {
    let attendant = Arc::new(AtTerminal);
    Ok(OnMavlink::new(name, address(name)?, link.options()?, logbook, attendant)?)
}
