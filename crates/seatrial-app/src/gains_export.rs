//! Gains and limits as the files that controllers read.

use seatrial::export::{OperatingPoint, VehicleType, ardupilot, px4};

use crate::Error;
use crate::gains::Wanted;
use crate::models::Models;

/// A form that controllers read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// A file for a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct GainsFile {
    /// Its text.
    pub text: String,
    /// What to know about it.
    pub notes: Vec<String>,
}

impl GainsFile {
    /// The file of [timed](Wanted::timed) models. Models of a rehearsal are refused, unless they are asked for.
    pub fn new(
        format: Format,
        wanted: &Wanted,
        models: &Models,
        vehicle: VehicleType,
        takes_rehearsals: bool,
    ) -> Result<Self, Error> {
        models.unless_rehearsed(takes_rehearsals)?;
        let schedule = || wanted.schedule(models);
        let text = match format {
            Format::Ardupilot => {
                return Self::of_one(ardupilot::param_file, wanted, models, vehicle);
            }
            Format::Px4 => return Self::of_one(px4::params_file, wanted, models, vehicle),
            Format::Ros2 => schedule()?.ros2_yaml(),
            Format::C => schedule()?.c_header(),
            Format::Json => {
                let text = serde_json::to_string_pretty(&schedule()?);
                text.map_err(|error| Error::Rejected(error.to_string()))? + "\n"
            }
        };
        Ok(Self {
            text,
            notes: Vec::new(),
        })
    }

    /// One set of parameters, telling whose and what to know about them.
    fn of_one(
        write: fn(&OperatingPoint, VehicleType) -> String,
        wanted: &Wanted,
        models: &Models,
        vehicle: VehicleType,
    ) -> Result<Self, Error> {
        let point = wanted.operating_point(models)?;
        let mut notes = Vec::new();
        if let (None, [_, .., fastest]) = (wanted.at, models.points.as_slice()) {
            notes.push(format!(
                "one set of parameters for {} models: those of {} (--at-speed and --at-thrust choose others)",
                models.points.len(),
                fastest.name()
            ));
        }
        notes.extend(point.notes.iter().cloned().chain(point.extrapolation()));
        Ok(Self {
            text: write(&point, vehicle),
            notes,
        })
    }
}
