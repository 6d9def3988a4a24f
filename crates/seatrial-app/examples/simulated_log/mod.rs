//! A log to try things on: a trial of a simulated vehicle at two speeds.

use std::error::Error;
use std::fs::File;
use std::path::Path;

use seatrial_core::{List, Plan, Trial, Vehicle};
use seatrial_logs::write_csv;
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

/// Writes the log.
pub fn write(path: &Path) -> Result<(), Box<dyn Error>> {
    let mut vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 1)?;
    let plan =
        Plan { thrusts: List::from_slice(&[0.6, 0.8]).expect("room for two"), ..Plan::paper() };
    let mut trial = Trial::new(plan)?;
    let mut rows = Vec::new();
    while let Some(sample) = vehicle.next_sample()? {
        rows.push(sample.into());
        let action = trial.step(&sample);
        vehicle.act(&action)?;
        if action.outcome.is_some() {
            break;
        }
    }
    write_csv(File::create(path)?, &rows)?;
    Ok(())
}
