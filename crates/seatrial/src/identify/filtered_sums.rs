//! Filtering and batch least squares in one pass over evenly sampled arrays.

use seatrial_core::YawModel;
use seatrial_core::estimator::InvalidSetting;
use seatrial_core::fixed_rate::FixedRateSettings;

use crate::sums::Accumulator;

/// The least squares solution (34) of a long, evenly sampled record.
///
/// ```text
/// Theta = (sum phi phi^T)^-1 sum phi psi''_f,   phi = [psi'_f, delta_f, 1]       (32)-(34)
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | psi | `heading_rad`, unwrapped | rad |
/// | delta | `rudder_rad` | rad |
/// | h | `interval_s` | s |
/// | lambda | `lambda_rad_s` | rad/s |
///
/// Source: (16)-(34) with filters from zero state and both signals held between samples, as `--as-paper` has them, on
/// increments from the first heading. For records of a million samples, of which it keeps nine sums ([`crate::sums`]): no guard, no rejected
/// samples, no interval, no verdict. The sums square the condition number, which is 10 to 1000 for a vehicle that was
/// excited: at least half of the digits of f64 are left. `None` where nothing excites the vehicle or a number is not finite.
pub fn filtered_least_squares(
    interval_s: f64,
    heading_rad: &[f64],
    rudder_rad: &[f64],
    lambda_rad_s: f64,
) -> Result<Option<YawModel<f64>>, InvalidSetting> {
    let mut accumulator = Accumulator::new(&FixedRateSettings {
        lambda_rad_s,
        ..FixedRateSettings::paper(interval_s)
    })?;
    accumulator.extend(heading_rad, rudder_rad);
    Ok(accumulator.sums().model(f64::INFINITY))
}
