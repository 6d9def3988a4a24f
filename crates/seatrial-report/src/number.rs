//! Numbers as a person reads them.

use std::fmt::Write;

use seatrial::identification::Reason;
use seatrial::words::{self, r2_text, three_figures, with_decimals};
use seatrial_core::RudderUnit;

/// How many of the unit that a rudder is shown in one is, and its sign.
pub(super) fn rudder_unit(unit: RudderUnit) -> (f64, &'static str) {
    match unit {
        RudderUnit::Rad => (1_f64.to_degrees(), "°"),
        RudderUnit::FullRudder => unit.for_people(),
    }
}

/// What stands for a missing value.
pub(super) const MISSING: &str = "–";

/// A number with so many decimals and a true minus sign.
pub(super) fn decimals(value: f64, count: usize) -> String {
    if !value.is_finite() {
        return MISSING.to_owned();
    }
    with_decimals(value, count).replacen('-', "−", 1)
}

/// R^2 to two places.
pub(super) fn r2(value: Option<f64>) -> String {
    value.map_or_else(|| MISSING.to_owned(), |value| r2_text(Some(value)).replacen('-', "−", 1))
}

/// A number that may be missing.
pub(super) fn decimals_or_missing(value: Option<f64>, count: usize) -> String {
    value.map_or_else(|| MISSING.to_owned(), |value| decimals(value, count))
}

/// A number with so many significant digits; a tiny one as a power of ten.
pub(super) fn significant(value: f64, digits: i32) -> String {
    if value != 0.0 && value.abs() < 1e-6 {
        return three_figures(value).replace('-', "−");
    }
    let magnitude = libm::log10(value.abs()).floor();
    let count = if magnitude.is_finite() {
        (digits - 1 - magnitude as i32).clamp(0, 8)
    } else {
        digits - 1
    };
    decimals(value, count as usize)
}

/// Text made safe for HTML elements and attributes.
pub(super) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        let _ = match c {
            '&' | '<' | '>' | '"' | '\'' => write!(safe, "&#{};", c as u32),
            other => write!(safe, "{other}"),
        };
    }
    safe
}

/// A fraction in per cent.
pub(super) fn percent(fraction: f64) -> String {
    format!("{} %", decimals(100.0 * fraction, 0))
}

/// Text for people with its powers raised.
pub(super) fn spoken(text: &str) -> String {
    text.replace("^2", "²")
}

/// Text as a sentence, its powers raised.
pub(super) fn sentence(text: &str) -> String {
    words::sentence(&spoken(text))
}

/// The causes of several reasons in one.
pub(super) fn joined(reasons: &[Reason]) -> String {
    let causes: Vec<String> = reasons.iter().map(|reason| sentence(&reason.text)).collect();
    causes.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_numbers_as_people_read_them() {
        assert_eq!(decimals(-1.066, 2), "−1.07");
        assert_eq!(decimals(-0.001, 2), "0.00");
        assert_eq!(decimals(f64::NAN, 2), MISSING);
        assert_eq!(significant(0.0123456, 3), "0.0123");
        assert_eq!(significant(-123.4, 2), "−123");
        assert_eq!(significant(0.0, 3), "0.00");
        assert_eq!(significant(-1.2e-8, 3), "−1.20e−8");
        assert_eq!(significant(f64::INFINITY, 3), MISSING);
    }

    #[test]
    fn exact_markup_is_escaped() {
        assert_eq!(escaped("a<b>\"&'"), "a&#60;b&#62;&#34;&#38;&#39;");
    }
}
