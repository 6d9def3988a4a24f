//! Over what a model was seen: rudder, headings, speeds and frequencies of its records.

use core::f64::consts::PI;

use seatrial_core::{Sample, YawModel};

use super::validation::heading_range_rad;
use crate::identification::ValidRange;
use crate::record::duration_s;

/// The range of the training record and, where there are any, of validation data. `None` where they have no two samples.
pub fn valid_range(
    records: &[&[Sample<f64>]],
    model: &YawModel<f64>,
    heading_noise_rad: f64,
) -> Option<ValidRange> {
    let samples = || records.iter().copied().flatten();
    let rudder = span(samples().map(|sample| sample.rudder_rad))?;
    let longest = records.iter().copied().max_by_key(|record| record.len())?;
    let duration_s = duration_s(longest);
    if duration_s <= 0.0 {
        return None;
    }
    let interval_s = duration_s / (longest.len() - 1) as f64;
    let amplitude = 0.5 * (rudder[1] - rudder[0]);
    Some(ValidRange {
        rudder,
        heading_amplitude_rad: records
            .iter()
            .map(|record| 0.5 * heading_range_rad(*record))
            .fold(0.0, f64::max),
        surge_speed_m_s: span(samples().filter_map(|sample| sample.surge_speed_m_s)),
        usual_surge_speed_m_s: usual_speed_m_s(samples()),
        band_rad_s: [
            2.0 * PI / duration_s,
            drowned_from_rad_s(model, amplitude, heading_noise_rad).min(PI / interval_s),
        ],
    })
}

/// The middle nine tenths of one speed lie within this share of its median: zig-zags of real hulls slow down by 2 to 44 %, a record in which
/// a hull gathers way or comes to a stop spreads by 98 % or more.
const MOST_SPREAD: f64 = 0.5;

/// The median of the measured speeds, m/s, where they are nearly one.
fn usual_speed_m_s<'a>(samples: impl Iterator<Item = &'a Sample<f64>>) -> Option<f64> {
    let speeds = samples.filter_map(|sample| sample.surge_speed_m_s);
    let mut speeds: Vec<f64> = speeds.filter(|speed| speed.is_finite()).collect();
    speeds.sort_by(f64::total_cmp);
    let at = |share: f64| speeds.get((share * speeds.len() as f64) as usize).copied();
    let [low, median, high] = [at(0.05)?, at(0.5)?, at(0.95)?];
    (median > 0.0 && high - low <= MOST_SPREAD * median).then_some(median)
}

/// Least and greatest finite value.
fn span(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values
        .filter(|value| value.is_finite())
        .map(|value| [value; 2])
        .reduce(|[low, high], [value, _]| [low.min(value), high.max(value)])
}

/// Where the heading's answer to a rudder falls below its noise, rad/s.
///
/// ```text
/// |b2| delta / (w sqrt(w^2 + a22^2)) = sigma
/// ```
fn drowned_from_rad_s(model: &YawModel<f64>, rudder: f64, heading_noise_rad: f64) -> f64 {
    let half_square = 0.5 * model.a22_per_s.powi(2);
    let ratio = model.b2_per_s2 * rudder / heading_noise_rad;
    (libm::hypot(half_square, ratio) - half_square).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial_core::RudderUnit;

    /// 10 s at 10 Hz with a doublet of the rudder and one of the heading.
    fn record(rudder_rad: f64, heading_rad: f64, surge_speed_m_s: f64) -> Vec<Sample<f64>> {
        (0..=100)
            .map(|k| {
                let side = if k < 50 { 1.0 } else { -1.0 };
                Sample {
                    time_s: 0.1 * f64::from(k),
                    heading_rad: side * heading_rad,
                    rudder_rad: side * rudder_rad,
                    surge_speed_m_s: Some(surge_speed_m_s),
                    ..Sample::default()
                }
            })
            .collect()
    }

    #[test]
    fn exact_the_range_is_that_of_all_records() {
        let model = YawModel::from_theta([-3.0, 2.0, 0.0]);
        let [training, validation] = [record(0.2, 0.1, 1.5), record(0.1, 0.3, 1.2)];
        let range = valid_range(&[&training, &validation], &model, 0.02).unwrap();
        assert_eq!(range.rudder, [-0.2, 0.2]);
        assert!((range.heading_amplitude_rad - 0.3).abs() < 1e-12);
        assert_eq!(range.surge_speed_m_s, Some([1.2, 1.5]));
        assert!((range.band_rad_s[0] - 0.2 * PI).abs() < 1e-12);
        // 2 * 0.2 / (4 * sqrt(4^2 + 3^2)) = 0.02
        assert!((range.band_rad_s[1] - 4.0).abs() < 1e-12);
        // Without noise the sample rate is the end: 10 Hz.
        let exact = valid_range(&[&training], &model, 0.0).unwrap();
        assert!((exact.band_rad_s[1] - 10.0 * PI).abs() < 1e-9);
        assert!(valid_range(&[&[], &training[..1]], &model, 0.0).is_none());
    }

    #[test]
    fn exact_a_record_of_one_speed_has_that_speed() {
        let model = YawModel::from_theta([-3.0, 2.0, 0.0]);
        let usual = |speed: fn(f64) -> f64| {
            let mut samples = record(0.2, 0.1, 0.0);
            for sample in &mut samples {
                sample.surge_speed_m_s = Some(speed(sample.time_s));
            }
            let range = valid_range(&[&samples], &model, 0.02).unwrap();
            range.usual_surge_speed_m_s
        };
        // A zig-zag that loses a third of its way, then one that coasts to a stop, and one without way.
        let zigzag = usual(|time_s| 1.2 - 0.4 * (0.1 * time_s)).unwrap();
        assert!((zigzag - 1.0).abs() < 1e-9, "{zigzag}");
        assert_eq!(usual(|time_s| 1.2 * (1.0 - 0.1 * time_s)), None);
        assert_eq!(usual(|_| 0.0), None);
    }

    #[test]
    fn exact_a_use_beyond_the_range_is_reported() {
        let model = YawModel::from_theta([-3.0, 2.0, 0.0]);
        let range = |rudder_rad, heading_rad, speed| {
            valid_range(&[&record(rudder_rad, heading_rad, speed)], &model, 0.02).unwrap()
        };
        let seen = range(0.2, 0.1, 1.5);
        let left = |other| seen.left_by(&other, RudderUnit::Rad).join("; ");
        assert_eq!(left(range(0.23, 0.11, 1.3)), "");
        let beyond = left(range(0.26, 0.13, 1.0));
        for said in ["14.9 deg is beyond", "these data have 7.45", "1.00 to 1.00 m/s"] {
            assert!(beyond.contains(said), "{beyond}");
        }
    }
}
