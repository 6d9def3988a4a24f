//! Numbers as people read them in messages.

/// A number to three significant figures.
pub fn three_figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = 2 - value.abs().log10().floor().clamp(-6.0, 2.0) as i32;
    format!("{value:.*}", digits.max(0) as usize)
}

/// An angle in degrees to three significant figures.
pub(crate) fn degrees(angle_rad: f64) -> String {
    three_figures(angle_rad.to_degrees())
}

/// A share in whole per cent.
pub(crate) fn percent(share: f64) -> String {
    format!("{:.0}", 100.0 * share)
}

/// R^2 to two places, or that it is not known.
pub(crate) fn r2_text(r2: Option<f64>) -> String {
    r2.map_or_else(|| "not known".into(), |r2| format!("{r2:.2}"))
}
