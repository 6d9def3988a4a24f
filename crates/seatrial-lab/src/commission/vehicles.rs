//! The boats of the study as files of vehicles.

use std::path::{Path, PathBuf};

use seatrial_cli::output::{Exit, Failure, Output};
use seatrial_sim::VehicleConfig;
use seatrial_sim::plant::{Disturbance, Servo, SpeedPoint};
use serde::Serialize;

use super::boat::{CLASSES_S, boat_of};
use super::{CommissionStudy, first_of};

/// The boats that are written: rudder at full steering, rad; speed at half thrust, m/s; disturbance as a share of what full
/// steering gives.
const FULL_RUDDER_RAD: f64 = 0.6;
const SURGE_SPEED_M_S: f64 = 1.5;
const DISTURBANCE: f64 = 0.001;

/// The files of boats that `commission --vehicles` has written.
#[derive(Serialize)]
struct Written {
    schema: &'static str,
    vehicles: Vec<PathBuf>,
}

/// Writes each boat of the study into a folder.
pub fn write(
    study: &CommissionStudy,
    seed: u64,
    folder: &Path,
    output: &Output,
) -> Result<Exit, Failure> {
    let mut written = Written { schema: "seatrial.commission_boats.v1", vehicles: Vec::new() };
    for (number, class_s) in CLASSES_S.iter().enumerate() {
        for boat in 0..study.boats {
            let seed = first_of(number, seed).wrapping_add(boat);
            let name = format!("boat-{}-{}", number + 1, boat + 1);
            let file = format!("{name}.toml");
            let path = folder.join(&file);
            let config = vehicle(name, *class_s, seed);
            let text = toml::to_string(&config).map_err(Failure::internal)?;
            output.save_in(folder, &[(&file, format!("# Boat by seatrial\n{text}"))])?;
            written.vehicles.push(path);
        }
    }
    output.print(&written, || {
        let count = written.vehicles.len();
        format!("{count} boats in {}", folder.display())
    })?;
    Ok(Exit::Done)
}

/// A boat of the study as a vehicle. Its rudder has the boat's lag; the dead time is the autopilot's own.
fn vehicle(name: String, class_s: [f64; 2], seed: u64) -> VehicleConfig {
    let boat = boat_of(class_s, seed);
    let [a22_per_s, authority, c0_rad_per_s2] = boat.model.theta();
    let b2_per_s2 = authority / FULL_RUDDER_RAD;
    let at = |thrust: f64| {
        let faster = thrust / 0.5;
        SpeedPoint {
            thrust,
            surge_speed_m_s: faster * SURGE_SPEED_M_S,
            a22_per_s: faster * a22_per_s,
            b2_per_s2: faster * faster * b2_per_s2,
            c0_rad_per_s2: faster * faster * c0_rad_per_s2,
        }
    };
    VehicleConfig {
        name,
        rudder_limit_rad: FULL_RUDDER_RAD,
        depth_m: 0.0,
        initial_thrust: 0.5,
        servo: Servo { time_constant_s: boat.lag_s, rate_limit_rad_s: None },
        disturbance: Disturbance {
            standard_deviation_rad_s2: DISTURBANCE * authority,
            correlation_time_s: 2.0,
        },
        speeds: vec![at(0.5), at(1.0)],
        ..VehicleConfig::starfish()
    }
}
