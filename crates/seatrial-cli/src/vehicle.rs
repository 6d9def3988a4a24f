//! Vehicles by name: `sim:starfish`, `sim:FILE.toml`.

use std::path::Path;

use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

use crate::output::Failure;

/// What a simulated vehicle of this name is made from.
pub fn config(name: &str) -> Result<VehicleConfig, Failure> {
    match name.strip_prefix("sim:") {
        Some("starfish") => Ok(VehicleConfig::starfish()),
        Some(file) if file.ends_with(".toml") => {
            VehicleConfig::load(Path::new(file)).map_err(Failure::input)
        }
        _ => Err(Failure::usage(format!(
            "--vehicle {name}: expected sim:starfish or sim:FILE.toml"
        ))),
    }
}

/// The simulated vehicle of this name.
pub fn simulated(name: &str, seed: u64) -> Result<FirstOrderVehicle, Failure> {
    FirstOrderVehicle::new(config(name)?, seed)
        .map_err(|error| Failure::input(format!("{name}: {error}")))
}
