//! Logs that are opened in the page.

use std::collections::BTreeMap;

use seatrial_app::Inspection;
use seatrial_app::documents::IdentificationDocument;
use seatrial_app::series::LogSeries;
use serde::{Deserialize, Serialize};

use super::Verdict;

/// The names of a log's columns.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LogColumns {
    /// In the order of the log.
    pub columns: Vec<String>,
    /// The units that a column may have, by the quantity that it holds.
    pub units: BTreeMap<String, Vec<String>>,
}

/// What was made of a log.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct IdentifiedLog {
    /// The document of `seatrial identify --json`, schema `seatrial.identification.v1`.
    #[cfg_attr(feature = "openapi", schema(value_type = Object))]
    pub document: IdentificationDocument,
    /// May the model be used, and what decides it.
    pub verdict: Verdict,
    /// The samples, to be drawn.
    pub series: LogSeries,
    /// Are latitude and longitude known, so that the track can be had as GPX and KML?
    pub is_located: bool,
}

/// What is in a log.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct InspectedLog {
    /// The document of `seatrial inspect --json`.
    #[cfg_attr(feature = "openapi", schema(value_type = Object))]
    pub document: Inspection,
    /// The samples, to be drawn.
    pub series: LogSeries,
    /// Are latitude and longitude known, so that the track can be had as GPX and KML?
    pub is_located: bool,
}
