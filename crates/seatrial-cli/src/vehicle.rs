//! Vehicles by name: `sim:starfish`, `sim:FILE.toml`.

use std::path::Path;

use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

use crate::output::Failure;

/// A simulated vehicle by its name on the command line.
pub fn simulated(name: &str, seed: u64) -> Result<FirstOrderVehicle, Failure> {
    let config = match name.strip_prefix("sim:") {
        Some("starfish") => VehicleConfig::starfish(),
        Some(file) if file.ends_with(".toml") => {
            VehicleConfig::load(Path::new(file)).map_err(Failure::input)?
        }
        _ => {
            return Err(Failure::usage(format!(
                "no vehicle is called {name:?}; use sim:starfish or sim:FILE.toml"
            )));
        }
    };
    FirstOrderVehicle::new(config, seed).map_err(|error| Failure::input(format!("{name}: {error}")))
}
