//! What a log is and how it is read.

use seatrial_core::RudderUnit;
use serde::{Deserialize, Serialize};

use crate::error::{Fault, Place, clipped};
use crate::format_name::Format;
use crate::infer::largest_plausible;
use crate::name::ColumnName;
use crate::{Quantity, Unit};

/// Where a unit comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum UnitSource {
    /// The user said so.
    Chosen,
    /// The log says so.
    Stated,
    /// From the values.
    Assumed,
}

/// One column and what it feeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// The quantity it feeds.
    pub quantity: Quantity,
    /// Its name in the log.
    pub column: String,
    /// Its unit.
    pub unit: Unit,
    /// Where the unit comes from.
    pub unit_source: UnitSource,
    /// The unit that the name of the column says, where one of another kind was chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub against: Option<Unit>,
    /// Why the unit was assumed, or why the format takes this column.
    pub because: Option<String>,
    /// value in SI = (value - offset) * scale
    pub scale: f64,
    /// value in SI = (value - offset) * scale
    pub offset: f64,
}

impl Channel {
    /// A unit that was assumed from the first rows must hold to the last.
    pub(crate) fn check(&self, value: f64, place: Place) -> Result<(), Fault> {
        let largest = largest_plausible(self.quantity, self.unit);
        if self.unit_source == UnitSource::Assumed && value.is_finite() && value.abs() > largest {
            return Err(Fault::UnitContradicted {
                place,
                column: clipped(&self.column),
                quantity: self.quantity,
                unit: self.unit,
                found: value,
            });
        }
        Ok(())
    }
}

/// What a log is and how it is read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogDescription {
    /// Its format.
    pub format: Format,
    /// Names of all columns.
    pub columns: Vec<String>,
    /// The columns that are read.
    pub channels: Vec<Channel>,
    /// The unit of the samples' rudder: radians, or a fraction of full deflection where no angle is known.
    #[serde(skip)]
    pub rudder_unit: RudderUnit,
    /// The angle that a servo's full deflection was taken for, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub full_rudder_rad: Option<f64>,
    /// The aircraft that the log says it is of, with its article: a copter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub aircraft: Option<String>,
    /// The firmware as the log names it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub firmware: Option<String>,
    /// Second 0 of the samples in UTC, where the log has an epoch or calendar time.
    pub start_utc: Option<String>,
    /// What people should know before they trust the samples.
    pub warnings: Vec<String>,
}

impl LogDescription {
    /// Columns whose names fit a quantity, without the one that was taken.
    pub fn other_columns(&self, quantity: Quantity) -> Vec<&str> {
        let is_taken = |name: &String| self.channels.iter().any(|c| c.column == *name);
        let columns = self.columns.iter().filter(|name| !is_taken(name));
        columns
            .filter(|name| ColumnName::new(name).fit(quantity).is_some())
            .map(String::as_str)
            .collect()
    }
}

/// Rows read and rows left out, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Rows of the log.
    pub rows: u64,
    /// Samples given.
    pub samples: u64,
    /// Time, heading or rudder was empty.
    pub missing: u64,
    /// Text, NaN, infinity or a wrong number of cells.
    pub invalid: u64,
    /// The time of the sample before.
    pub repeated_time: u64,
    /// Rows with the time of another and another heading or rudder: the clock does not tell them apart.
    #[serde(skip)]
    pub differing_at_a_time: u64,
    /// Earlier than the sample before.
    pub reversed_time: u64,
    /// Was a part of the log left out because it is damaged?
    #[serde(skip)]
    pub is_damaged: bool,
}

impl Counts {
    /// Rows left out, all causes.
    pub fn dropped(&self) -> u64 {
        self.missing + self.invalid + self.repeated_time + self.reversed_time
    }
}
