//! What a small wiggle of the rudder shows.

use seatrial_core::Sample;

/// Mean of a quantity over the later half of the samples, by when the vehicle follows; where it is not known it does not count; 0 where it never is.
pub fn late_mean(samples: &[Sample<f64>], of: impl Fn(&Sample<f64>) -> f64) -> f64 {
    let late = samples[samples.len() / 2..].iter().map(of);
    let (sum, count) = late
        .filter(|value| value.is_finite())
        .fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / f64::max(count, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_what_is_not_known_does_not_count() {
        let samples = [9.0, 9.0, 1.0, f64::NAN, 2.0].map(|rudder_rad| Sample {
            rudder_rad,
            ..Sample::default()
        });
        let rudder = |sample: &Sample<f64>| sample.rudder_rad;
        assert_eq!(late_mean(&samples, rudder), 1.5);
        assert_eq!(late_mean(&[], rudder), 0.0);
    }
}
