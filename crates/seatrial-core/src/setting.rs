//! What a setting outside its range is answered with.

use core::fmt;

use crate::Real;

/// A setting outside its range. Displays as "`field` must be `requirement`".
///
/// ```
/// use seatrial_core::Settle;
///
/// let error = Settle { at_least_s: -1.0, ..Settle::<f64>::default() }
///     .check()
///     .expect_err("time runs forwards");
/// assert_eq!(error.to_string(), "settle.at_least_s must be a number not below 0");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InvalidSetting {
    /// The field, by its path from the outermost settings: `envelope.area`.
    pub field: &'static str,
    /// What it has to be.
    pub requirement: &'static str,
}

impl fmt::Display for InvalidSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} must be {}", self.field, self.requirement)
    }
}

impl core::error::Error for InvalidSetting {}

/// An error that names the field and what it has to be, unless `holds`.
pub(crate) fn require(
    holds: bool,
    field: &'static str,
    requirement: &'static str,
) -> Result<(), InvalidSetting> {
    holds.then_some(()).ok_or(InvalidSetting { field, requirement })
}

/// Above 0 and finite; false for NaN. Not inlined: a comparison in software floating point takes code at every call.
#[inline(never)]
pub(crate) fn is_positive<T: Real>(value: T) -> bool {
    value > T::ZERO && value <= T::MAX
}
