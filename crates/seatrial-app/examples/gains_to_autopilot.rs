//! From a log to the parameters of an autopilot: `cargo run -p seatrial-app --example gains_to_autopilot -- run.csv`, or,
//! without a log, from one of a simulated vehicle.

mod simulated_log;

use std::error::Error;
use std::path::PathBuf;

use seatrial::GainAllowance;
use seatrial::export::{OperatingPoint, VehicleType, ardupilot};
use seatrial_app::{Options, identify_log};
use seatrial_core::SchedulePoint;

/// The angle of this vehicle's rudder at full steering, rad.
const FULL_RUDDER_RAD: f64 = 0.26;

/// Of the closed heading loop: well damped, little overshoot.
const DAMPING_RATIO: f64 = std::f64::consts::FRAC_1_SQRT_2;

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
    let identification = found.identification().ok_or("no model")?;
    let model = identification.model();
    // The gain is designed for the least damping that the record allows, and for what the loop waits for.
    let allowance = GainAllowance::of(identification);
    let gain = allowance.design(&model, DAMPING_RATIO)?;
    println!(
        "rudder = {:.3} (desired heading - heading) {:+.4} rad",
        gain.proportional_gain, gain.feed_forward_rudder_rad
    );
    let speed = found
        .models
        .as_deref()
        .and_then(seatrial_app::identify_log::foremost);
    let parameters = ardupilot::param_file(
        &OperatingPoint {
            source: log.display().to_string(),
            at: SchedulePoint {
                thrust: speed.and_then(|speed| speed.thrust),
                surge_speed_m_s: speed.and_then(|speed| speed.surge_speed_m_s),
                model,
            },
            damping_ratio: DAMPING_RATIO,
            full_rudder_rad: FULL_RUDDER_RAD,
            seen_rudder_rad: None,
            allowance,
            covariance: identification
                .refined
                .as_ref()
                .map(|refined| refined.covariance),
            notes: Vec::new(),
        },
        VehicleType::Surface,
    );
    println!("{parameters}");
    Ok(parameters)
}
