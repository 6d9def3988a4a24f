//! Numbers as people read them in messages.

/// No number that people read has more significant figures.
const MOST_FIGURES: f64 = 6.0;

/// Sizes between which a number is written without a power of ten.
const PLAIN: std::ops::Range<f64> = 1e-6..1e6;

/// A number to three significant figures.
///
/// ```
/// use seatrial::words::three_figures;
///
/// assert_eq!([1.07, 123.4, 0.01234].map(three_figures), ["1.07", "123", "0.0123"]);
/// assert_eq!(three_figures(1.5e-9), "1.50e-9");
/// ```
pub fn three_figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if !PLAIN.contains(&value.abs()) {
        return format!("{value:.2e}");
    }
    let digits = 2 - libm::log10(value.abs()).floor().clamp(-6.0, 2.0) as i32;
    format!("{value:.*}", digits.max(0) as usize)
}

/// An angle in degrees to three significant figures.
pub(crate) fn degrees(angle_rad: f64) -> String {
    three_figures(angle_rad.to_degrees())
}

/// The names and units of the columns of a heading, `speed [m/s] | gain`; a unit is empty where there is none.
///
/// ```
/// use seatrial::words::named_columns;
///
/// let columns: Vec<_> = named_columns("speed [m/s] | gain").collect();
/// assert_eq!(columns[0], ("speed".to_owned(), "m/s".to_owned()));
/// assert_eq!(columns[1].1, "");
/// ```
pub fn named_columns(heading: &str) -> impl Iterator<Item = (String, String)> {
    heading.split('|').map(str::trim).map(|column| {
        let with_unit = column.strip_suffix(']').and_then(|column| column.split_once('['));
        let (name, unit) = with_unit.unwrap_or((column, ""));
        (name.trim().to_owned(), unit.to_owned())
    })
}

/// A share in whole per cent.
pub(crate) fn percent(share: f64) -> String {
    format!("{:.0}", 100.0 * share)
}

/// R^2 to two places, or that it is not known. One far below 0 says nothing but that.
///
/// ```
/// use seatrial::words::r2_text;
///
/// assert_eq!([Some(0.987), Some(-250.0), None].map(r2_text), ["0.99", "below -10", "not known"]);
/// ```
pub fn r2_text(r2: Option<f64>) -> String {
    match r2 {
        None => "not known".into(),
        Some(r2) if r2 < LOWEST_R2 => format!("below {LOWEST_R2}"),
        Some(r2) => with_decimals(r2, 2),
    }
}

const LOWEST_R2: f64 = -10.0;

/// The decimals of a value with an interval: two significant figures of half its width, as far as no bound then has more
/// than six.
///
/// ```
/// use seatrial::words::decimals_of;
///
/// // Half widths of 0.05 and of 20.
/// assert_eq!(decimals_of([-1.12, -1.02]), 3);
/// assert_eq!(decimals_of([1000.0, 1040.0]), 0);
/// ```
pub fn decimals_of([low, high]: [f64; 2]) -> usize {
    let of_width = 1.0 - libm::log10((0.5 * (high - low)).abs()).floor();
    let most = MOST_FIGURES - 1.0 - libm::log10(low.abs().max(high.abs())).floor();
    let decimals = of_width.min(most);
    if decimals.is_finite() { decimals.clamp(0.0, 9.0) as usize } else { 3 }
}

/// A value with so many decimals, without a minus sign before zero.
///
/// ```
/// use seatrial::words::with_decimals;
///
/// assert_eq!(with_decimals(1.005, 1), "1.0");
/// // Zero has no sign.
/// assert_eq!(with_decimals(-0.004, 2), "0.00");
/// ```
pub fn with_decimals(value: f64, decimals: usize) -> String {
    if value.is_finite() && value != 0.0 && value.abs() >= PLAIN.end {
        return three_figures(value);
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|b| matches!(b, b'0' | b'.')) => digits.into(),
        _ => text,
    }
}

/// The bounds of an interval, `-1.12 to -1.02`, or `1.20e-8 to 1.40e-8`.
///
/// ```
/// use seatrial::words::bounds_text;
///
/// assert_eq!(bounds_text([-1.1234, -1.0021]), "-1.123 to -1.002");
/// assert_eq!(bounds_text([1.2e-8, 1.4e-8]), "1.20e-8 to 1.40e-8");
/// ```
pub fn bounds_text(interval: [f64; 2]) -> String {
    let [low, high] = interval.map(|bound| within(bound, Some(interval)));
    format!("{low} to {high}")
}

/// The power of ten that an interval of tiny numbers is written with.
fn power_of([low, high]: [f64; 2]) -> Option<i32> {
    let largest = low.abs().max(high.abs());
    (largest > f64::MIN_POSITIVE && largest < PLAIN.start)
        .then(|| libm::log10(largest).floor() as i32)
}

/// A value with the decimals that its interval leaves it; to three significant figures without one.
///
/// ```
/// use seatrial::words::within;
///
/// // An interval says how many digits of a value mean something.
/// assert_eq!(within(1.07345, Some([0.97, 1.17])), "1.07");
/// assert_eq!(within(1.07345, None), "1.07");
/// assert_eq!(within(1.07345, Some([1.0732, 1.0737])), "1.07345");
/// ```
pub fn within(value: f64, interval: Option<[f64; 2]>) -> String {
    let Some(interval) = interval else {
        return three_figures(value);
    };
    let Some(power) = power_of(interval) else {
        return with_decimals(value, decimals_of(interval));
    };
    // Divided: a power of ten below the least number is 0.
    let digits = |value: f64| value / 10_f64.powi(power);
    let decimals = decimals_of(interval.map(digits));
    format!("{}e{power}", with_decimals(digits(value), decimals))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_interval_says_how_many_figures_a_number_has() {
        assert_eq!(bounds_text([-0.9712, -0.8783]), "-0.971 to -0.878");
        assert_eq!(within(-0.9081, Some([-0.9712, -0.8783])), "-0.908");
        assert_eq!(bounds_text([0.00412, 0.01338]), "0.0041 to 0.0134");
        assert_eq!(bounds_text([1_234.567_89, 1_234.567_95]), "1234.57 to 1234.57");
        assert_eq!(bounds_text([-0.001, 0.2]), "0.00 to 0.20");
        assert_eq!(within(1.0, Some([1.0, 1.0])), "1.00000");
        assert_eq!(within(0.012_345, None), "0.0123");
        assert_eq!(bounds_text([1.2e-8, 1.4e-8]), "1.20e-8 to 1.40e-8");
        assert_eq!(within(-3.1e-12, Some([-4e-12, -2e-12])), "-3.1e-12");
    }

    #[test]
    fn exact_no_number_is_long() {
        assert_eq!(three_figures(1.234_567e190), "1.23e190");
        assert_eq!(three_figures(3.4e-9), "3.40e-9");
        assert_eq!(three_figures(123_456.0), "123456");
        assert_eq!(r2_text(Some(-1e190)), "below -10");
        assert_eq!(r2_text(Some(-0.004)), "0.00");
        assert_eq!(with_decimals(-0.004, 2), "0.00");
    }
}
