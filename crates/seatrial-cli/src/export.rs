//! `seatrial export`: the vehicle that was identified, for simulators, planners and controllers.

use std::path::{Path, PathBuf};

use seatrial_app::file_form::FileForm;
use seatrial_app::vehicle_export::{self, Form};
use seatrial_app::vehicle_file::VehicleOverrides;
use seatrial_sim::IdentifiedVehicle;
use serde::Serialize;

use crate::choice::form_of;
use crate::model_source::{SourceArgs, warn};
use crate::output::{Exit, Failure, Output, OutputPath, say};

/// The vehicle that was identified, for simulators, planners and controllers.
#[derive(clap::Args)]
#[command(after_help = "\
vehicle is the vehicle file, which every verb with --vehicle sim:FILE.toml reads; docs/vehicle-file.md explains its fields, and \
docs/simulators.md the other targets.

Example:
  seatrial export --to vehicle --a22 -1.07 --b2 1.08 --c0 0.012 --speed 1.63 \\
      --name myboat --out myboat.toml
  seatrial export --to python --vehicle sim:myboat.toml --out myboat.py")]
pub struct Args {
    /// What is written.
    #[arg(long, value_name = "TARGET", value_parser = form_of::<Form>())]
    to: Form,
    #[command(flatten)]
    vehicle: VehicleArgs,
    /// Thrust of a target that has one speed only [default: the fastest].
    #[arg(long, value_name = "FRACTION")]
    at_thrust: Option<f64>,
    /// Writes gains that are warned of, too: of models that are not to be used, or whose interval holds 0.
    #[arg(long)]
    accept: bool,
    /// Draws so many vehicles from what is known of this one, into the folder that --out names.
    #[arg(long, value_name = "N", requires = "out", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    sample: Option<u64>,
    /// Seed of the first of them.
    #[arg(long, value_name = "N", default_value_t = 1, requires = "sample")]
    seed: u64,
    /// Where it goes; standard output without.
    #[arg(long, value_name = "FILE")]
    out: Option<OutputPath>,
}

/// The vehicle of a file or of models.
#[derive(clap::Args)]
pub struct VehicleArgs {
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
    full_steering_deg: Option<f64>,
    /// Time constant of the rudder's lag, s [default: the one that the record tells].
    #[arg(long, value_name = "S")]
    lag: Option<f64>,
    /// Dead time of the rudder, s.
    #[arg(long, value_name = "S")]
    dead_time: Option<f64>,
    /// Fastest motion of the rudder, degrees a second.
    #[arg(long, value_name = "DEG_S")]
    rudder_rate_deg: Option<f64>,
    /// Time constant of the speed after a change of thrust, s [default: the one that the trial tells].
    #[arg(long, value_name = "S")]
    surge_time_constant: Option<f64>,
}

/// `export --sample --json`.
#[derive(Serialize)]
struct SampleDocument {
    schema: &'static str,
    files: Vec<PathBuf>,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let (vehicle, exit) = args.vehicle.vehicle()?;
    vehicle.provenance.assumptions.iter().for_each(say);
    let form = args.to;
    if !args.accept {
        let not_to_be_used = "its models are not to be used".to_owned();
        let rejected = (exit == Exit::Rejected).then_some(&not_to_be_used);
        vehicle_export::check_usable(&vehicle, form, args.at_thrust, rejected).map_err(
            |error| Failure::rejected(format!("{error}; --accept writes it all the same")),
        )?;
    }
    match (&args.out, args.sample) {
        (Some(folder), Some(count)) => {
            let files = draw(args, &vehicle, folder, count, output)?;
            let drawn = SampleDocument { schema: "seatrial.drawn_vehicles.v1", files };
            output.print(&drawn, || format!("{count} vehicles in {}\n", folder.display()))?;
        }
        (Some(path), None) => {
            output.save(path, file(args, &vehicle)?)?;
            output.print(&vehicle, || format!("{}\n", path.display()))?;
        }
        (None, _) if form == Form::Fmu => {
            return Err(Failure::usage(
                "--to fmu writes no text: say where it goes with --out FILE.fmu",
            ));
        }
        (None, _) => {
            let text = String::from_utf8(file(args, &vehicle)?).map_err(Failure::internal)?;
            output.print(&vehicle, || text)?;
        }
    }
    Ok(exit)
}

fn file(args: &Args, vehicle: &IdentifiedVehicle) -> Result<Vec<u8>, Failure> {
    let (bytes, note) = vehicle_export::file(vehicle, args.to, args.at_thrust)?;
    if let Some(note) = note {
        say(format!("{}: {note}", vehicle.name));
    }
    Ok(bytes)
}

/// Writes vehicles that are drawn, numbered from 1.
fn draw(
    args: &Args,
    vehicle: &IdentifiedVehicle,
    folder: &Path,
    count: u64,
    output: &Output,
) -> Result<Vec<PathBuf>, Failure> {
    if vehicle.speeds.iter().all(|speed| speed.covariance.is_none()) {
        return Err(Failure::usage(format!(
            "--sample: {} has no covariance to draw from: take the vehicle from a logbook or a document of `identify --json`",
            vehicle.name
        )));
    }
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::not_saved(format!("{}: {error}", folder.display())))?;
    let digits = count.to_string().len();
    // Every file of the folder is of one form: the last part of its ending is enough.
    let extension = args.to.row().extension.rsplit('.').next();
    let extension = extension.unwrap_or_default();
    (1..=count)
        .map(|number| {
            let mut drawn = vehicle.drawn(args.seed.wrapping_add(number - 1));
            drawn.name = format!("{} {number:0digits$}", vehicle.name);
            let path = folder.join(format!("vehicle-{number:0digits$}.{extension}"));
            output.save(&path, file(args, &drawn)?)?;
            Ok(path)
        })
        .collect()
}

impl VehicleArgs {
    /// The vehicle, and whether its source says something against it.
    pub fn vehicle(&self) -> Result<(IdentifiedVehicle, Exit), Failure> {
        if let Some(name) = &self.vehicle {
            let path = name.strip_prefix("sim:").unwrap_or(name);
            let vehicle = IdentifiedVehicle::load(path.as_ref()).map_err(Failure::input)?;
            return Ok((vehicle, Exit::Done));
        }
        let models = self.source.read()?;
        warn(&models);
        let vehicle = self.stated().vehicle(&models)?;
        let exit = Exit::done_if(models.rejected.is_empty());
        Ok((vehicle, exit))
    }

    fn stated(&self) -> VehicleOverrides {
        VehicleOverrides {
            name: self.name.clone(),
            full_rudder_rad: self.full_steering_deg.map(f64::to_radians),
            lag_s: self.lag,
            delay_s: self.dead_time,
            rate_limit_rad_s: self.rudder_rate_deg.map(f64::to_radians),
            surge_time_constant_s: self.surge_time_constant,
        }
    }
}
