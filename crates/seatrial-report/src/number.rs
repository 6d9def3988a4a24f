//! Numbers as a person reads them.

use std::fmt::Write;

use seatrial::identification::Reason;

/// What stands for a missing value.
pub(super) const MISSING: &str = "–";

/// A number with so many decimals, a true minus sign and no negative zero.
pub(super) fn decimals(value: f64, count: usize) -> String {
    if !value.is_finite() {
        return MISSING.to_owned();
    }
    let text = format!("{value:.count$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|b| matches!(b, b'0' | b'.')) => digits.to_owned(),
        Some(digits) => format!("−{digits}"),
        None => text,
    }
}

/// A number that may be missing.
pub(super) fn decimals_or_missing(value: Option<f64>, count: usize) -> String {
    value.map_or_else(|| MISSING.to_owned(), |value| decimals(value, count))
}

/// A number with so many significant digits, never as a power of ten.
pub(super) fn significant(value: f64, digits: i32) -> String {
    let magnitude = value.abs().log10().floor();
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

/// The texts of several reasons in one.
pub(super) fn joined(reasons: &[Reason]) -> String {
    let texts: Vec<String> = reasons
        .iter()
        .map(|reason| spoken(reason.text.trim_end_matches('.')))
        .collect();
    texts.join("; also: ")
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
        assert_eq!(significant(f64::INFINITY, 3), MISSING);
    }

    #[test]
    fn exact_markup_is_escaped() {
        assert_eq!(escaped("a<b>\"&'"), "a&#60;b&#62;&#34;&#38;&#39;");
    }
}
