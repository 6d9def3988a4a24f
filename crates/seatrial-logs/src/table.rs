//! What every log format is to the rest of this crate: named columns and rows of cells.

use std::fmt;

use jiff::Timestamp;

use crate::error::{Fault, Place, clipped};
use crate::format_name::Format;
use crate::{Quantity, Unit};

/// One cell of a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    /// The cell is empty.
    Missing,
    Number(f64),
    /// A time of day, in seconds since midnight.
    OfDay(f64),
    Instant(Timestamp),
    Text(Box<str>),
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Missing => Ok(()),
            Self::Number(number) | Self::OfDay(number) => write!(f, "{number}"),
            Self::Instant(instant) => write!(f, "{instant}"),
            Self::Text(text) => f.write_str(&clipped(text)),
        }
    }
}

/// A log as a table, read row by row with bounded memory.
pub(crate) trait Table: Send {
    fn format(&self) -> Format;

    /// Names of the columns.
    fn columns(&self) -> &[String];

    /// What the format itself says about its columns; where it says nothing their names decide.
    fn known(&self) -> Known {
        Known::default()
    }

    /// From now on rows hold the cells of these columns, in this order.
    fn select(&mut self, columns: &[(Quantity, usize)]);

    /// From now on rows come without the cell at this position.
    fn leave_out(&mut self, position: usize);

    /// The next row, or `None` at the end. After a fault in one row the next call goes on behind it.
    fn next_row(&mut self, cells: &mut Vec<Cell>) -> Result<Option<Place>, Fault>;

    /// Bytes of the file consumed.
    fn bytes_read(&self) -> u64;

    /// SHA-256 of the whole file, in hexadecimal. Called after the last row.
    fn sha256(&mut self) -> Result<String, Fault>;

    /// What was put right while reading, for people.
    fn warnings(&self) -> Vec<String>;

    /// Is a part of the file damaged, so that what is left may lack something or be wrong?
    fn is_damaged(&self) -> bool {
        false
    }

    /// The aircraft that the log says it is of, with its article: a copter.
    fn aircraft(&self) -> Option<&'static str> {
        None
    }

    /// The latitude and longitude from which north and east are, deg, where rows have had them.
    fn origin_deg(&self) -> Option<[f64; 2]> {
        None
    }

    /// The firmware as the log names it: `ArduRover V4.5.7 (1a2b3c4d)`.
    fn firmware(&self) -> Option<&str> {
        None
    }
}

/// The channels of a format that says itself what they are.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Known {
    /// The preferred one of each quantity first.
    pub channels: Vec<KnownChannel>,
    /// What was looked for and found instead of a quantity.
    pub lacking: Vec<(Quantity, String)>,
}

/// A column whose meaning the format knows.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct KnownChannel {
    /// What it is.
    pub quantity: Quantity,
    /// Its name: that of the kind of message, a dot, and that of the field.
    pub column: String,
    /// `None` where the values must show it.
    pub unit: Option<Unit>,
    /// Why it is this one, for people.
    pub because: Option<String>,
    /// What people should know before they trust it.
    pub doubt: Option<String>,
}

/// A quantity, the kind and the field of the messages that feed it, and its unit where the values need not show it.
pub(crate) type KnownField = (Quantity, &'static str, &'static str, Option<Unit>);

impl Known {
    /// Adds a column; the unit may be left to the values, the reason may be empty.
    pub fn add(&mut self, quantity: Quantity, column: String, unit: Option<Unit>, because: &str) {
        self.channels.push(KnownChannel {
            quantity,
            column,
            unit,
            because: Some(because.to_string()).filter(|text| !text.is_empty()),
            doubt: None,
        });
    }

    /// Says what was looked for and what is there instead of a quantity.
    pub fn lacks(&mut self, quantity: Quantity, found: String) {
        self.lacking.push((quantity, found));
    }

    /// What a file of this format needs for a quantity without a channel, and what there is.
    pub(crate) fn expects(&mut self, quantity: Quantity, what: &str, found: &str) {
        self.lacks(quantity, format!("expected {what}; found {found}"));
    }

    /// The preferred channel of a quantity.
    pub(crate) fn best(&self, quantity: Quantity) -> Option<&KnownChannel> {
        self.channels.iter().find(|known| known.quantity == quantity)
    }

    /// What the format knows about a column as a quantity.
    pub(crate) fn of(&self, quantity: Quantity, column: &str) -> Option<&KnownChannel> {
        self.channels.iter().find(|known| known.quantity == quantity && known.column == column)
    }

    /// Do names of columns mean anything here?
    pub(crate) fn is_empty(&self) -> bool {
        self.channels.is_empty() && self.lacking.is_empty()
    }
}

/// Bytes as people compare them.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
