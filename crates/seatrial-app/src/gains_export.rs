//! Gains and limits as the files that controllers read.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use seatrial::gains::export::VehicleType;
//! use seatrial_app::gains::LoopRequirements;
//! use seatrial_app::gains_export::{Format, GainsFile};
//! use seatrial_app::models::Models;
//! use seatrial_app::{Options, identify_log};
//!
//! let found = identify_log(Path::new("run.csv"), &Options::default())?;
//! // This boat's rudder is at 0.6 rad at full steering.
//! let models = Models::of_log(&found, None)?.with_full_rudder(Some(0.6))?;
//! let wanted = LoopRequirements::default();
//! let file = GainsFile::new(Format::Ardupilot, &wanted, &models, VehicleType::Surface, false)?;
//! std::fs::write("run.param", &file.text).expect("a folder to write to");
//! for note in &file.notes {
//!     println!("{note}");
//! }
//! # Ok::<(), seatrial_app::Error>(())
//! ```

use seatrial::gains::export::{OperatingPoint, VehicleType, ardupilot, px4};
use seatrial_core::RudderUnit;
use serde::Deserialize;

use crate::Error;
use crate::file_form::{FileForm, Row};
use crate::gains::LoopRequirements;
use crate::models::Models;

/// A form that controllers read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[non_exhaustive]
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

impl FileForm for Format {
    const ALL: &[Row<Self>] = &[
        Row {
            form: Self::Ardupilot,
            name: "ardupilot",
            extension: "param",
            label: "ArduPilot",
            about: "Parameters of ArduPilot, .param",
        },
        Row {
            form: Self::Px4,
            name: "px4",
            extension: "params",
            label: "PX4",
            about: "Parameters of PX4, .params as QGroundControl loads it",
        },
        Row {
            form: Self::Ros2,
            name: "ros2",
            extension: "yaml",
            label: "ROS 2, YAML",
            about: "Parameters of a ROS 2 node, YAML: the gain schedule as arrays",
        },
        Row {
            form: Self::Json,
            name: "json",
            extension: "json",
            label: "JSON",
            about: "The gain schedule",
        },
        Row {
            form: Self::C,
            name: "c",
            extension: "h",
            label: "C header",
            about: "The gain schedule as a table in a C99 header",
        },
    ];
}

/// A file for a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct GainsFile {
    /// Its text.
    pub text: String,
    /// What to know about it.
    pub notes: Vec<String>,
}

/// Refuses gains that [`LoopRequirements::gains`] warns of, which a file for a controller holds only where that is asked for.
///
/// # Errors
/// Models that their source does not accept, or a gain of which not even the sign is known.
pub fn check_usable(wanted: &LoopRequirements, models: &Models) -> Result<(), Error> {
    let why = models.rejected.first().cloned().or(wanted.gains(models)?.unsure());
    let refused = |why| format!("{}: no file of gains is written: {why}", models.origin);
    why.map_or(Ok(()), |why| Err(Error::Rejected(refused(why))))
}

impl GainsFile {
    /// The file of these models. `takes_rehearsals` allows models of a trial on a simulator, which are not for a vehicle.
    ///
    /// What is warned of is written, too: [`check_usable`] refuses that.
    ///
    /// # Errors
    /// Models of a rehearsal that are not asked for, models whose rudder is a share of full for a file that has angles, a model that allows no gain, or a place outside the models' range.
    pub fn new(
        format: Format,
        wanted: &LoopRequirements,
        models: &Models,
        vehicle: VehicleType,
        takes_rehearsals: bool,
    ) -> Result<Self, Error> {
        models.unless_rehearsed(takes_rehearsals)?;
        if models.rudder_unit == RudderUnit::FullRudder && format != Format::Ardupilot {
            return Err(Error::Setting(format!(
                "{}: the rudder of its models is a share of full, and this file has angles: identify the log again with --rudder-range-deg DEG, the angle of the rudder at full deflection; ArduPilot's parameters need none",
                models.origin
            )));
        }
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
        Ok(Self { text, notes: Vec::new() })
    }

    /// One set of parameters, telling whose and what to know about them.
    fn of_one(
        write: fn(&OperatingPoint, VehicleType) -> String,
        wanted: &LoopRequirements,
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
        Ok(Self { text: write(&point, vehicle), notes })
    }
}
