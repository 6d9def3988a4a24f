//! `gains --export`: gains and limits as files that controllers read.

use seatrial::GainAllowance;
use seatrial::export::{OperatingPoint, Schedule, ardupilot, px4};

use super::{Args, asked, beyond, cautious, no_such_place};
use crate::output::{Failure, Output, say};
use seatrial_app::models::{ModelPoint, Models, Tuned};

/// A form that controllers read.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum Format {
    /// Parameters of ArduPilot, .param.
    Ardupilot,
    /// Parameters of PX4, .params as QGroundControl loads it.
    Px4,
    /// Parameters of a ROS 2 node, YAML: the gain schedule as arrays.
    Ros2,
    /// The gain schedule.
    Json,
    /// The gain schedule as a table in a C99 header.
    C,
}

/// What the vehicle is to its autopilot.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum VehicleType {
    /// A boat.
    Surface,
    /// An underwater vehicle.
    Underwater,
}

/// Writes the export to its file or on standard output.
pub fn write(format: Format, args: &Args, source: &Models, output: &Output) -> Result<(), Failure> {
    if output.json && args.out.is_none() && !matches!(format, Format::Json) {
        return Err(Failure::usage(
            "--json and an --export that is no JSON: give a file with --out",
        ));
    }
    source.unless_rehearsed(args.rehearsal)?;
    let vehicle = match args.vehicle_type {
        VehicleType::Surface => seatrial::export::VehicleType::Surface,
        VehicleType::Underwater => seatrial::export::VehicleType::Underwater,
    };
    let text = match format {
        Format::Ardupilot => ardupilot::param_file(&operating_point(args, source)?, vehicle),
        Format::Px4 => px4::params_file(&operating_point(args, source)?, vehicle),
        Format::Ros2 => schedule(args, source)?.ros2_yaml(),
        Format::C => schedule(args, source)?.c_header(),
        Format::Json => {
            serde_json::to_string_pretty(&schedule(args, source)?).map_err(Failure::internal)?
                + "\n"
        }
    };
    match &args.out {
        Some(path) => std::fs::write(path, text)
            .map_err(|error| Failure::not_saved(format!("{}: {error}", path.display()))),
        None => Output::new(false).print(&(), || text),
    }
}

fn schedule(args: &Args, source: &Models) -> Result<Schedule, Failure> {
    for point in &source.points {
        check(args, source, point)?;
    }
    Ok(source.gain_schedule(args.zeta)?)
}

/// The model at the place asked for, else the fastest.
fn operating_point(args: &Args, source: &Models) -> Result<OperatingPoint, Failure> {
    let tuned = match (asked(args), source.points.as_slice()) {
        (Some((key, value)), _) => {
            let model = source
                .schedule(key)?
                .lookup(value, beyond(args))
                .map_err(|error| no_such_place(args, key, value, error))?;
            let (cautious, timing) = cautious(source, key)?;
            let cautious = cautious
                .lookup(value, beyond(args))
                .map_err(|error| no_such_place(args, key, value, error))?;
            let allowance = GainAllowance {
                damping_per_s: cautious.value().model.a22_per_s - model.value().model.a22_per_s,
                timing,
            };
            Tuned {
                at: *model.value(),
                allowance,
                covariance: None,
            }
        }
        (None, [.., fastest]) => {
            check(args, source, fastest)?;
            if source.points.len() > 1 {
                say(format!(
                    "one set of parameters for {} models: those of {} (--at-speed and --at-thrust choose others)",
                    source.points.len(),
                    fastest.name()
                ));
            }
            Tuned::from(fastest)
        }
        (None, []) => return Err(Failure::input(format!("{}: no model", source.origin))),
    };
    let point = source.operating_point(&tuned, args.zeta)?;
    point
        .notes
        .iter()
        .cloned()
        .chain(point.extrapolation())
        .for_each(say);
    Ok(point)
}

/// Refuses a model without a gain.
fn check(args: &Args, source: &Models, point: &ModelPoint) -> Result<(), Failure> {
    match point.allowance.design(&point.point.model, args.zeta) {
        Ok(_) => Ok(()),
        Err(reason) => Err(Failure::input(format!(
            "{}: no gain for {}: {reason}",
            source.origin,
            point.name()
        ))),
    }
}
