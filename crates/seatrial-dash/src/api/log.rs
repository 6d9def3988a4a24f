//! Logs that are opened in the page.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

/// What was made of a log.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
pub struct IdentifiedLog {
    /// The document of `seatrial identify --json`, schema `seatrial.identification.v1`.
    #[schema(value_type = Object)]
    pub document: Value,
    /// The samples, to be drawn.
    pub series: LogSeries,
}

/// What is in a log.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
pub struct InspectedLog {
    /// The document of `seatrial inspect --json`.
    #[schema(value_type = Object)]
    pub document: Value,
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
