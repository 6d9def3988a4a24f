//! The ranges of numbers that configurations hold.

/// Numbers beyond it, to either side, belong to no vehicle, and overflow in products.
const LARGEST: f64 = 1e9;

pub(crate) const POSITIVE_NUMBER: &str = "a number from 1e-9 to 1e9";
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
