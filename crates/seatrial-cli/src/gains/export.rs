//! `gains --export`: gains and limits as files that controllers read.

use seatrial::export::{OperatingPoint, ardupilot, px4};
use seatrial_app::models::Models;

use super::Args;
use crate::output::{Failure, Output, say};

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
        Format::Ros2 => args.wanted().schedule(source)?.ros2_yaml(),
        Format::C => args.wanted().schedule(source)?.c_header(),
        Format::Json => {
            serde_json::to_string_pretty(&args.wanted().schedule(source)?)
                .map_err(Failure::internal)?
                + "\n"
        }
    };
    match &args.out {
        Some(path) => std::fs::write(path, text)
            .map_err(|error| Failure::not_saved(format!("{}: {error}", path.display()))),
        None => Output::new(false).print(&(), || text),
    }
}

/// One set of parameters, telling whose and what to know about them.
fn operating_point(args: &Args, models: &Models) -> Result<OperatingPoint, Failure> {
    let wanted = args.wanted();
    let point = wanted.operating_point(models)?;
    if let (None, [_, .., fastest]) = (wanted.at, models.points.as_slice()) {
        say(format!(
            "one set of parameters for {} models: those of {} (--at-speed and --at-thrust choose others)",
            models.points.len(),
            fastest.name()
        ));
    }
    point
        .notes
        .iter()
        .cloned()
        .chain(point.extrapolation())
        .for_each(say);
    Ok(point)
}
