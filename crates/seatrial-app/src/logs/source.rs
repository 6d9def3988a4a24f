//! What documents say of a log that was read.

use seatrial::identification::Reader;
use seatrial::log::Servo;
use seatrial_core::RudderUnit;
use seatrial_logs::{Counts, LogDescription};
use serde::{Deserialize, Serialize};

use crate::advice::addressed;

/// `source` in the document of whatever reads a log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// Where the log lies, or the name that it goes by.
    pub path: String,
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: String,
    /// Samples of the log.
    pub samples_read: u64,
    /// The median of the intervals between the samples that were kept, s.
    pub median_interval_s: Option<f64>,
    /// In what the rudder is.
    pub rudder_unit: RudderUnit,
    /// The servo that was given.
    pub servo: Option<Servo>,
    #[serde(flatten)]
    pub(crate) description: LogDescription,
    /// Rows read and left out.
    pub rows: Counts,
}

impl Source {
    /// With what it warns of in the words of the place where it is read.
    pub fn addressed_to(mut self, reader: Reader) -> Self {
        for warning in &mut self.description.warnings {
            *warning = addressed(warning, reader);
        }
        self
    }

    /// What the log is and how it was read.
    pub fn description(&self) -> LogDescription {
        LogDescription { rudder_unit: self.rudder_unit, ..self.description.clone() }
    }
}
