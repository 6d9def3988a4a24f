//! A yaw rate that its instrument gives late, brought back to the time of the heading.

use std::borrow::Cow;

use seatrial_core::Sample;

use super::validation::ValidationData;
use crate::record::Record;

/// The samples with each yaw rate as it is measured `late_s` later; as they are where it is not late.
///
/// Straight between samples. After the last of them, and where one that is needed is not finite, the sample keeps its own.
pub fn with_yaw_rate_in_time(
    samples: &[Sample<f64>],
    late_s: Option<f64>,
) -> Cow<'_, [Sample<f64>]> {
    let Some(late_s) = late_s else {
        return Cow::Borrowed(samples);
    };
    let in_time = |sample: &Sample<f64>| Sample {
        yaw_rate_rad_s: yaw_rate_at(samples, sample.time_s + late_s).or(sample.yaw_rate_rad_s),
        ..*sample
    };
    samples.iter().map(in_time).collect()
}

/// The yaw rate at an instant between two samples.
fn yaw_rate_at(samples: &[Sample<f64>], time_s: f64) -> Option<f64> {
    let after = samples.partition_point(|sample| sample.time_s <= time_s);
    let (before, after) = (samples.get(after.checked_sub(1)?)?, samples.get(after)?);
    let (from, to) = (before.yaw_rate_rad_s?, after.yaw_rate_rad_s?);
    let share = (time_s - before.time_s) / (after.time_s - before.time_s);
    Some(from + share * (to - from)).filter(|rate| rate.is_finite())
}

/// The record of validation data with the yaw rate of their window brought back in time.
pub fn record_in_time<'a>(data: &ValidationData<'a>, late_s: Option<f64>) -> Cow<'a, Record> {
    let Record { rudder_unit, units, .. } = *data.record;
    match with_yaw_rate_in_time(data.record.window(data.window), late_s) {
        Cow::Owned(samples) => Cow::Owned(Record { samples, rudder_unit, units }),
        Cow::Borrowed(_) => Cow::Borrowed(data.record),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(rates: &[f64]) -> Vec<Sample<f64>> {
        (0..)
            .zip(rates)
            .map(|(k, rate)| Sample {
                time_s: f64::from(k) * 0.1,
                yaw_rate_rad_s: Some(*rate),
                ..Sample::default()
            })
            .collect()
    }

    #[test]
    fn exact_a_late_yaw_rate_is_read_later() {
        let samples = samples(&[0.0, 1.0, 2.0, 4.0, f64::NAN, 5.0]);
        let rates = |late_s| -> Vec<Option<f64>> {
            with_yaw_rate_in_time(&samples, late_s).iter().map(|s| s.yaw_rate_rad_s).collect()
        };
        let [a, b, c, d, e, f] = rates(Some(0.05))[..] else { panic!("six samples") };
        for (rate, expected) in [(a, 0.5), (b, 1.5), (c, 3.0), (d, 4.0), (f, 5.0)] {
            assert!((rate.unwrap() - expected).abs() < 1e-9, "{rate:?}");
        }
        assert!(e.unwrap().is_nan());
        assert_eq!(rates(None)[1], Some(1.0));
    }
}
