//! From a log to the parameters of an autopilot: `cargo run -p seatrial-app --example gains_to_autopilot -- run.csv`, or,
//! without a log, from one of a simulated vehicle.

mod simulated_log;

use std::error::Error;
use std::path::PathBuf;

use seatrial::gains::export::VehicleType;
use seatrial_app::gains::LoopRequirements;
use seatrial_app::gains_export::{Format, GainsFile};
use seatrial_app::models::Models;
use seatrial_app::{Options, identify_log};

/// The angle of this vehicle's rudder at full steering, rad.
const FULL_RUDDER_RAD: f64 = 0.26;

fn main() {
    run(std::env::args_os().nth(1).map(PathBuf::from)).unwrap();
}

/// The parameter file of an ArduPilot boat that this log, or that of a simulated vehicle, is of.
pub fn run(log: Option<PathBuf>) -> Result<String, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let log = match log {
        Some(log) => log,
        None => {
            let log = folder.path().join("run.csv");
            simulated_log::write(&log)?;
            log
        }
    };
    let found = identify_log(&log, &Options::default())?;
    if !found.verdict().accepted {
        return Err(found.verdict().reasons[0].text.clone().into());
    }
    let models = Models::of_log(&found, None)?.with_full_rudder(Some(FULL_RUDDER_RAD))?;
    // Gains are designed for the least damping that the record allows, and for what the loop waits for.
    let wanted = LoopRequirements::default();
    for point in wanted.gains(&models)?.points {
        println!(
            "{:?} m/s: rudder per heading error {:?}",
            point.surge_speed_m_s, point.proportional_gain
        );
    }
    let file = GainsFile::new(Format::Ardupilot, &wanted, &models, VehicleType::Surface, false)?;
    println!("{}", file.text);
    Ok(file.text)
}
