//! Logs that are opened in the page.

use seatrial_app::Inspection;
use seatrial_app::documents::IdentificationDocument;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::Verdict;

/// A log's name and how to read it, as the options of `seatrial identify`. Everything has a default.
#[derive(Clone, Debug, Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct LogReading {
    /// What the log is called; its format is found by its content.
    #[param(max_length = 200)]
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

/// The names of a log's columns.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
pub struct LogColumns {
    /// In the order of the log.
    pub columns: Vec<String>,
}

impl LogReading {
    /// What the log is called.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or("log")
    }
}

/// What was made of a log.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
pub struct IdentifiedLog {
    /// The document of `seatrial identify --json`, schema `seatrial.identification.v1`.
    #[schema(value_type = Object)]
    pub document: IdentificationDocument,
    /// May the model be used, and what decides it.
    pub verdict: Verdict,
    /// The samples, to be drawn.
    pub series: LogSeries,
}

/// What is in a log.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
pub struct InspectedLog {
    /// The document of `seatrial inspect --json`.
    #[schema(value_type = Object)]
    pub document: Inspection,
    /// The samples, to be drawn.
    pub series: LogSeries,
}

/// Columns of equal length; of a long log every n-th sample.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, ToSchema)]
pub struct LogSeries {
    /// The log's own seconds.
    pub time_s: Vec<Option<f64>>,
    /// Heading, unwrapped, rad.
    pub heading_rad: Vec<Option<f64>>,
    /// Rudder, rad or a fraction of full as the document says.
    pub rudder: Vec<Option<f64>>,
    /// Measured yaw rate, rad/s.
    pub yaw_rate_rad_s: Vec<Option<f64>>,
    /// Heading simulated over the validation window with the model, rad; null outside.
    pub simulated_heading_rad: Vec<Option<f64>>,
}
