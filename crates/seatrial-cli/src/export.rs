//! `seatrial export`: the vehicle that was identified, for simulators, planners and controllers.

use std::path::PathBuf;

use seatrial_app::vehicle_file::Stated;
use seatrial_sim::IdentifiedVehicle;

use crate::model_source::{SourceArgs, warn};
use crate::output::{Exit, Failure, Output, say};

/// The vehicle that was identified, for simulators, planners and controllers.
#[derive(clap::Args)]
#[command(after_help = "\
vehicle is the vehicle file, which every verb with --vehicle sim:FILE.toml reads. docs/vehicle-file.md explains its fields.

Example:
  seatrial export --to vehicle --a22 -1.07 --b2 1.08 --c0 0.012 --speed 1.63 --name myboat --out myboat.toml
  seatrial trial --vehicle sim:myboat.toml --yes")]
pub struct Args {
    /// What is written.
    #[arg(long, value_name = "TARGET")]
    to: Target,
    #[command(flatten)]
    source: SourceArgs,
    /// A vehicle file, in the place of models.
    #[arg(
        long,
        value_name = "sim:FILE.toml",
        conflicts_with_all = ["a22", "model", "schedule", "logbook", "name"]
    )]
    vehicle: Option<String>,
    /// Name of the vehicle [default: the one of the trial].
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Rudder at full steering, degrees, where the models have it as a fraction of full.
    #[arg(long, value_name = "DEG")]
    full_rudder_deg: Option<f64>,
    /// Time constant of the rudder's lag, s [default: the one that the record tells].
    #[arg(long, value_name = "S")]
    rudder_lag: Option<f64>,
    /// Dead time of the rudder, s.
    #[arg(long, value_name = "S")]
    rudder_delay: Option<f64>,
    /// Fastest motion of the rudder, degrees a second.
    #[arg(long, value_name = "DEG_S")]
    rudder_rate_deg: Option<f64>,
    /// Time constant of the speed after a change of thrust, s [default: the one that the trial tells].
    #[arg(long, value_name = "S")]
    surge_time_constant: Option<f64>,
    /// Where it goes; standard output without.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Target {
    /// The vehicle file, TOML.
    Vehicle,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let (vehicle, exit) = args.vehicle()?;
    let provenance = &vehicle.provenance;
    provenance.assumptions.iter().for_each(say);
    let text = match args.to {
        Target::Vehicle => vehicle.to_toml().map_err(Failure::internal)?,
    };
    match &args.out {
        Some(path) => {
            std::fs::write(path, text)
                .map_err(|error| Failure::not_saved(format!("{}: {error}", path.display())))?;
            output.print(&vehicle, || format!("{}\n", path.display()))?;
        }
        None => output.print(&vehicle, || text)?,
    }
    Ok(exit)
}

impl Args {
    /// The vehicle, and whether its source says something against it.
    fn vehicle(&self) -> Result<(IdentifiedVehicle, Exit), Failure> {
        if let Some(name) = &self.vehicle {
            let path = name.strip_prefix("sim:").unwrap_or(name);
            let vehicle = IdentifiedVehicle::load(path.as_ref()).map_err(Failure::input)?;
            return Ok((vehicle, Exit::Done));
        }
        let models = self.source.read()?;
        warn(&models);
        let vehicle = self.stated().vehicle(&models)?;
        let exit = match models.rejected.is_empty() {
            true => Exit::Done,
            false => Exit::Rejected,
        };
        Ok((vehicle, exit))
    }

    fn stated(&self) -> Stated {
        Stated {
            name: self.name.clone(),
            full_rudder_rad: self.full_rudder_deg.map(f64::to_radians),
            lag_s: self.rudder_lag,
            delay_s: self.rudder_delay,
            rate_limit_rad_s: self.rudder_rate_deg.map(f64::to_radians),
            surge_time_constant_s: self.surge_time_constant,
        }
    }
}
