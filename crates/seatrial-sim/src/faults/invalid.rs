//! What is wrong with a fault of a scenario.

use thiserror::Error;

use super::kind::Kind;
use crate::range::NOT_BELOW_0;

/// Why a fault cannot be played.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum InvalidFault {
    /// There is no such kind.
    #[error("no such kind; expected one of {}", Kind::ALL.map(Kind::name).join(", "))]
    UnknownKind,
    /// The kind does not take this parameter.
    #[error("{} takes no {name}{}", kind.name(), but(*kind))]
    UnknownParameter {
        /// The kind.
        kind: Kind,
        /// The parameter.
        name: String,
    },
    /// A parameter is no number.
    #[error("{name} must be a number, not {found}")]
    NotANumber {
        /// The parameter.
        name: String,
        /// What the file has.
        found: String,
    },
    /// A parameter is out of range.
    #[error("{name} must be a number from {least} to {greatest}, not {found}")]
    OutOfRange {
        /// The parameter.
        name: String,
        /// Least value.
        least: f64,
        /// Greatest value.
        greatest: f64,
        /// What the file has.
        found: f64,
    },
    /// A time is negative or too great.
    #[error("{name} must be {NOT_BELOW_0}")]
    Time {
        /// The field.
        name: &'static str,
    },
    /// The number of the run is 0.
    #[error("run counts from 1")]
    RunZero,
    /// The fault has no onset, or two.
    #[error("expected either at_s, or stage with run and after_s")]
    Onset,
    /// The vehicle cannot play it.
    #[error("this vehicle cannot play it: {0}")]
    Unplayable(&'static str),
}

/// What a kind takes instead.
fn but(kind: Kind) -> String {
    let names: Vec<&str> = kind.parameters().iter().map(|p| p.name).collect();
    match names.is_empty() {
        true => String::new(),
        false => format!(", but {}", names.join(" and ")),
    }
}

/// Why random faults cannot be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum InvalidRandom {
    /// The interval of time is empty or out of range.
    #[error("to_s must be a number above from_s, up to 1e9, and from_s not below 0")]
    Interval,
    /// There are too many.
    #[error("count must be at most {most}")]
    Count {
        /// The greatest number.
        most: u32,
    },
    /// The list of kinds is empty.
    #[error("kinds must name at least one kind")]
    NoKinds,
}
