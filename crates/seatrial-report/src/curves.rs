//! What samples give to draw: curves over time, headings without the jump at the wrap.

use std::f64::consts::TAU;

use seatrial_core::{Real, Sample};

use seatrial::log::SavitzkyGolay;

/// Samples that a simulation can be compared with, the heading unwrapped.
pub(super) fn usable(samples: &[Sample<f64>]) -> Vec<Sample<f64>> {
    let mut usable: Vec<Sample<f64>> = Vec::with_capacity(samples.len());
    for sample in samples {
        let later = usable.last().is_none_or(|last| sample.time_s > last.time_s);
        if later && sample.heading_rad.is_finite() && sample.rudder_rad.is_finite() {
            usable.push(*sample);
        }
    }
    unwrapped(&usable)
}

/// Samples with the jumps of the heading at the wrap taken out, their mean between 0 and
/// a full turn.
pub(super) fn unwrapped(samples: &[Sample<f64>]) -> Vec<Sample<f64>> {
    let mut last: Option<[f64; 2]> = None;
    let headings = samples.iter().map(|sample| {
        let heading_rad = last.map_or(sample.heading_rad, |[unwrapped, raw]| {
            unwrapped + (sample.heading_rad - raw).wrapped()
        });
        if heading_rad.is_finite() {
            last = Some([heading_rad, sample.heading_rad]);
        }
        heading_rad
    });
    let headings: Vec<f64> = headings.collect();
    let finite = || headings.iter().filter(|heading| heading.is_finite());
    let mean = finite().sum::<f64>() / finite().count().max(1) as f64;
    let turns = TAU * (mean / TAU).floor();
    let smooth = samples.iter().zip(&headings);
    smooth.map(|(sample, heading)| Sample { heading_rad: heading - turns, ..*sample }).collect()
}

/// A value of every sample over the time since the origin; not a number where it was not measured.
pub(super) fn series(
    samples: &[Sample<f64>],
    origin_s: f64,
    value: impl Fn(&Sample<f64>) -> Option<f64>,
) -> Vec<[f64; 2]> {
    let point = |s: &Sample<f64>| [s.time_s - origin_s, value(s).unwrap_or(f64::NAN)];
    samples.iter().map(point).collect()
}

/// Radians in degrees.
pub(super) fn degrees(value: Option<f64>) -> Option<f64> {
    value.map(f64::to_degrees)
}

/// The yaw rate in deg/s and its name: as measured or, where it was not, the slope of parabolas
/// over 11 samples of heading (Fig. 15).
pub(super) fn yaw_rate(samples: &[Sample<f64>], origin_s: f64) -> (Vec<[f64; 2]>, &'static str) {
    let measured = series(samples, origin_s, |s| degrees(s.yaw_rate_rad_s));
    if present(&measured) {
        return (measured, "measured");
    }
    let usable = usable(samples);
    let times: Vec<f64> = usable.iter().map(|s| s.time_s).collect();
    let headings: Vec<f64> = usable.iter().map(|s| s.heading_rad).collect();
    let rates = SavitzkyGolay::new(5, 2).and_then(|f| f.derivative(&times, &headings));
    let points = times.into_iter().zip(rates.unwrap_or_default());
    let points = points.map(|(t, rate)| [t - origin_s, rate.to_degrees()]);
    (points.collect(), "from heading")
}

/// Is there anything finite to draw?
pub(super) fn present(points: &[[f64; 2]]) -> bool {
    points.iter().any(|point| point[1].is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_headings_across_the_wrap_are_one_line() {
        let degrees = [179.0, -179.0, f64::NAN, 178.0, 181.0 - 360.0];
        let samples = degrees
            .map(|heading: f64| Sample { heading_rad: heading.to_radians(), ..Sample::default() });
        let unwrapped = unwrapped(&samples);
        let found = unwrapped.iter().map(|s| s.heading_rad.to_degrees().round());
        let found: Vec<f64> = found.filter(|heading| heading.is_finite()).collect();
        assert_eq!(found, [179.0, 181.0, 178.0, 181.0]);
    }
}
