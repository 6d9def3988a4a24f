//! How a person says in a page that a log is to be read: every option of `seatrial identify` as a field.

use std::fmt::Display;

use seatrial_logs::{ChannelChoice, Quantity, Unit, UnknownQuantity, UnknownUnit};
use serde::Deserialize;

use crate::Error;
use crate::identify_log::{Options, Windows};
use crate::logs::{ReadSettings, above_zero, servo_of};

/// A log's name and how to read it. Everything has a default.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "openapi", derive(utoipa::IntoParams))]
#[cfg_attr(feature = "openapi", into_params(parameter_in = Query))]
pub struct LogReading {
    /// What the log is called; its format is found by its content.
    #[cfg_attr(feature = "openapi", param(max_length = 200))]
    pub name: Option<String>,
    /// Column with the time.
    pub time: Option<String>,
    /// Column with the heading.
    pub heading: Option<String>,
    /// Column with the rudder: measured angle, command, PWM or percent.
    pub rudder: Option<String>,
    /// Column with the forward speed; `none` leaves it out, as for all that follow.
    pub speed: Option<String>,
    /// Column with the depth.
    pub depth: Option<String>,
    /// Column with the roll angle.
    pub roll: Option<String>,
    /// Column with the pitch angle.
    pub pitch: Option<String>,
    /// Column with the measured yaw rate.
    pub yaw_rate: Option<String>,
    /// Column with the position north.
    pub north: Option<String>,
    /// Column with the position east.
    pub east: Option<String>,
    /// Column with the thrust that is asked for.
    pub thrust: Option<String>,
    /// Units of columns, as in `heading=deg,rudder=pwm`.
    pub units: Option<String>,
    /// Pulse width of the neutral rudder, us [default: 1500].
    pub rudder_trim_us: Option<f64>,
    /// Rudder angle at full deflection, degrees.
    pub rudder_range_deg: Option<f64>,
    /// Dead time of the rudder behind the logged command, s.
    pub rudder_delay_s: Option<f64>,
    /// Time constant with which the rudder follows the logged command, s.
    pub rudder_lag_s: Option<f64>,
    /// Leave rows out that have text, no number or a time that goes back, instead of refusing the log.
    pub drop_invalid: Option<bool>,
    /// Start of the training window, the log's own seconds; without windows the manoeuvres are found.
    pub from_s: Option<f64>,
    /// End of the training window, s.
    pub to_s: Option<f64>,
    /// Start of the validation window, s.
    pub validate_from_s: Option<f64>,
    /// End of the validation window, s.
    pub validate_to_s: Option<f64>,
}

impl LogReading {
    /// What the log is called.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or("log")
    }

    /// The options of an identification.
    pub fn options(self) -> Result<Options, Error> {
        Ok(Options {
            windows: Windows {
                from_s: self.from_s,
                to_s: self.to_s,
                validate_from_s: self.validate_from_s,
                validate_to_s: self.validate_to_s,
                validate_on: None,
            },
            reading: self.settings()?,
            ..Options::default()
        })
    }

    /// Columns, units and servo.
    pub fn settings(self) -> Result<ReadSettings, Error> {
        above_zero("rudder_range_deg", self.rudder_range_deg)?;
        above_zero("rudder_trim_us", self.rudder_trim_us)?;
        let servo = servo_of(self.rudder_delay_s, self.rudder_lag_s)
            .map_err(|error| Error::Setting(format!("rudder {error}")))?;
        let units = self.units.as_deref().unwrap_or_default();
        let units = units.split(',').map(str::trim).filter(|u| !u.is_empty());
        let units = units.map(quantity_and_unit).collect::<Result<_, Error>>();
        let units = units.map_err(|error| Error::Setting(format!("units: {error}")))?;
        let columns = [
            (Quantity::Time, self.time),
            (Quantity::Heading, self.heading),
            (Quantity::Rudder, self.rudder),
            (Quantity::Speed, self.speed),
            (Quantity::Depth, self.depth),
            (Quantity::Roll, self.roll),
            (Quantity::Pitch, self.pitch),
            (Quantity::YawRate, self.yaw_rate),
            (Quantity::North, self.north),
            (Quantity::East, self.east),
            (Quantity::Thrust, self.thrust),
        ];
        let mut channels = ChannelChoice::default();
        for (quantity, column) in columns {
            if let Some(column) = column {
                channels.name_column(quantity, column);
            }
        }
        channels.units = units;
        channels.rudder_trim = self.rudder_trim_us;
        channels.full_rudder_rad = self.rudder_range_deg.map(f64::to_radians);
        channels.drop_invalid = self.drop_invalid.unwrap_or(false);
        Ok(ReadSettings { channels, servo, ..ReadSettings::default() })
    }
}

/// The unit of a quantity as people say it: `heading=deg`.
///
/// # Errors
/// What is expected instead.
pub fn quantity_and_unit(text: &str) -> Result<(Quantity, Unit), Error> {
    let refused = |what: &dyn Display| Error::Setting(what.to_string());
    let (quantity, unit) = text.split_once('=').ok_or_else(|| {
        refused(&format_args!("`{text}`: expected QUANTITY=UNIT, such as heading=deg"))
    })?;
    let quantity = quantity.parse().map_err(|error: UnknownQuantity| refused(&error))?;
    let unit = unit.parse().map_err(|error: UnknownUnit| refused(&error))?;
    Ok((quantity, unit))
}
