//! `gains --export`: gains and limits as files that controllers read.

use seatrial_app::gains_export::{Format as Form, GainsFile};
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

impl Format {
    fn form(self) -> Form {
        match self {
            Self::Ardupilot => Form::Ardupilot,
            Self::Px4 => Form::Px4,
            Self::Ros2 => Form::Ros2,
            Self::Json => Form::Json,
            Self::C => Form::C,
        }
    }
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
    let vehicle = match args.vehicle_type {
        VehicleType::Surface => seatrial::gains::export::VehicleType::Surface,
        VehicleType::Underwater => seatrial::gains::export::VehicleType::Underwater,
    };
    let wanted = args.wanted();
    let file = GainsFile::new(format.form(), &wanted, source, vehicle, args.rehearsal)?;
    file.notes.iter().for_each(say);
    let text = file.text;
    match &args.out {
        Some(path) => output.save(path, text),
        None => output.as_text().print(&(), || text),
    }
}
