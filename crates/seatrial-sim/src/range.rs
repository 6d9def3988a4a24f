//! The ranges of numbers that configurations hold.

use crate::config_error::{ConfigError, invalid};

/// Numbers beyond it, to either side, belong to no vehicle, and overflow in products.
const LARGEST: f64 = 1e9;

const POSITIVE_NUMBER: &str = "a number from 1e-9 to 1e9";
pub(crate) const NOT_BELOW_0: &str = "a number from 0 to 1e9";

pub(crate) fn positive(value: f64) -> bool {
    (1e-9..=LARGEST).contains(&value)
}

pub(crate) fn not_negative(value: f64) -> bool {
    (0.0..=LARGEST).contains(&value)
}

/// To either side of 0.
pub(crate) fn a_number(value: f64) -> bool {
    value.abs() <= LARGEST
}

/// Refuses a field that does not hold.
pub(crate) fn check(
    field: &str,
    found: f64,
    holds: bool,
    requirement: impl Into<String>,
) -> Result<(), ConfigError> {
    match holds {
        true => Ok(()),
        false => Err(invalid(field, requirement, found)),
    }
}

pub(crate) fn check_positive(field: &str, found: f64) -> Result<(), ConfigError> {
    check(field, found, positive(found), POSITIVE_NUMBER)
}

pub(crate) fn check_not_negative(field: &str, found: f64) -> Result<(), ConfigError> {
    check(field, found, not_negative(found), NOT_BELOW_0)
}

pub(crate) fn check_number(field: &str, found: f64) -> Result<(), ConfigError> {
    check(field, found, a_number(found), "a number")
}

/// Refuses a field that lies outside a range; the unit says what it is.
pub(crate) fn check_within(
    field: &str,
    found: Option<f64>,
    [low, high]: [f64; 2],
    unit: &str,
    absent: &str,
) -> Result<(), ConfigError> {
    let what = match unit {
        "s" => "a time",
        "m" => "a length",
        "rad" => "an angle",
        "rad/s" => "a rate",
        _ => "a number",
    };
    let holds = found.is_none_or(|found| (low..=high).contains(&found));
    // A right angle to the digits that people read.
    let [from, to] = [low, high].map(|end| (1e4 * end).round() / 1e4);
    let requirement = format!("{absent}{what} from {from} to {to} {unit}");
    check(field, found.unwrap_or(low), holds, requirement.trim_end())
}

/// [`check_within`] of a field that is called as it is written.
macro_rules! within {
    ($field:expr, $low:expr, $high:expr, $unit:expr) => {
        crate::range::check_within(stringify!($field), Some($field), [$low, $high], $unit, "")
    };
}

/// [`within`] of what may be absent.
macro_rules! within_if_given {
    ($field:expr, $low:expr, $high:expr, $unit:expr) => {
        crate::range::check_within(stringify!($field), $field, [$low, $high], $unit, "absent or ")
    };
}

pub(crate) use {within, within_if_given};
