//! `seatrial study commission`: commissions of many simulated boats, beside the defaults and QuickTune's rule.

use std::path::{Path, PathBuf};

use seatrial::gains::commission::study::{CLASSES_S, Method, boat_of};
use seatrial_app::studies::commission::{Class, Commissions, boats_of_all, commission_boats};
use seatrial_sim::VehicleConfig;
use seatrial_sim::plant::{Disturbance, Servo, SpeedPoint};
use serde::Serialize;

use crate::output::{Exit, Failure, Output, OutputPath};
use crate::progress::RunsOf;
use crate::table::{Table, number};

/// Commissions of simulated boats in three classes, beside the autopilot's defaults and QuickTune's rule.
///
/// Each boat is of first order with a rudder that lags by up to 0.3 s and is up to 0.06 s late, under the heading controller of
/// ArduPilot's Rover; its trial errs by 4 % of a22 and of the rudder's effect. Steps of 30 degrees there and back.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:
  seatrial study commission --boats 3")]
pub struct Args {
    /// Boats of each class.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    boats: u64,
    /// Loops of the autopilot per second.
    #[arg(long, value_name = "HZ", default_value_t = 50, value_parser = clap::value_parser!(u32).range(10..=1000))]
    loop_rate: u32,
    /// Each boat in a sea of its own, up to 2 % of what full steering gives, with a compass of 0.1 to 0.5 degrees.
    #[arg(long)]
    sea: bool,
    /// Write each boat into this folder, for `sim ardupilot-json --vehicle sim:FILE.toml`, and commission none.
    #[arg(long, value_name = "DIR")]
    vehicles: Option<OutputPath>,
    #[command(flatten)]
    runs_of: RunsOf,
}

/// The boats that are written: rudder at full steering, rad; speed at half thrust, m/s; disturbance as a share of what full
/// steering gives.
const FULL_RUDDER_RAD: f64 = 0.6;
const SURGE_SPEED_M_S: f64 = 1.5;
const DISTURBANCE: f64 = 0.001;

/// Commissions them.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    if let Some(folder) = &args.vehicles {
        return write_vehicles(args, folder, output);
    }
    let document = args.runs_of.all(boats_of_all(args.boats), |workers| {
        commission_boats(
            args.boats,
            args.runs_of.seed,
            args.loop_rate,
            args.sea,
            workers,
        )
    });
    output.print(&document, || text(&document))?;
    Ok(Exit::Done)
}

/// The seed of the first boat of a class.
fn first_seed(args: &Args, class: usize) -> u64 {
    args.runs_of.seed.wrapping_add(1_000_000 * class as u64)
}

/// The files of boats that `study commission --vehicles` has written.
#[derive(Serialize)]
struct Written {
    schema: &'static str,
    vehicles: Vec<PathBuf>,
}

fn write_vehicles(args: &Args, folder: &Path, output: &Output) -> Result<Exit, Failure> {
    let mut written = Written {
        schema: "seatrial.commission_boats.v1",
        vehicles: Vec::new(),
    };
    for (number, class_s) in CLASSES_S.iter().enumerate() {
        for boat in 0..args.boats {
            let seed = first_seed(args, number).wrapping_add(boat);
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
        servo: Servo {
            time_constant_s: boat.lag_s,
            rate_limit_rad_s: None,
        },
        disturbance: Disturbance {
            standard_deviation_rad_s2: DISTURBANCE * authority,
            correlation_time_s: 2.0,
        },
        speeds: vec![at(0.5), at(1.0)],
        ..VehicleConfig::starfish()
    }
}

fn text(document: &Commissions) -> String {
    let mut table = Table::under(
        "T [s] | gains | overshoot [median %] | [most %] | unsettled [boats] | settled after [median s] | \
            later than defaults [boats] | rudder [median %/s] | [most %/s]",
    );
    for class in &document.classes {
        for row in &class.methods {
            let name = match row.method {
                Method::Defaults => "defaults",
                Method::QuickTune => "QuickTune's rule",
                Method::Proposed => "proposed",
                Method::Commissioned => "commissioned",
            };
            let [low, high] = class.time_constant_s;
            table.row(vec![
                format!("{low} to {high}"),
                name.into(),
                format!("{:.1}", 100.0 * row.overshoot_median),
                format!("{:.1}", 100.0 * row.overshoot_most),
                row.unsettled.to_string(),
                number(row.settling_median_s, 1),
                row.later_than_defaults.to_string(),
                format!("{:.0}", 100.0 * row.activity_median_per_s),
                format!("{:.0}", 100.0 * row.activity_most_per_s),
            ]);
        }
    }
    let count = |of: fn(&Class) -> u64| document.classes.iter().map(of).sum::<u64>();
    format!(
        "{} boats of each class, {} loops a second; kept {}, no gains proposed for {}; without sea and noise {} would be kept, of them {} were; measured as foreseen {}\n\n{table}",
        document.boats,
        document.loop_rate_hz,
        count(|class| class.kept as u64),
        count(|class| class.refused),
        count(|class| class.better as u64),
        count(|class| class.better_kept as u64),
        count(|class| class.as_foreseen as u64),
    )
}
