//! The part of a long record that is refined.

use seatrial_core::Sample;

/// Only a segment of this many samples of a longer record is refined: about a second of work.
const MOST_SAMPLES: usize = 10_000;

/// The segment of [`MOST_SAMPLES`] in which the rudder varies most, on a grid of half its length.
pub(crate) fn most_excited(samples: &[Sample<f64>]) -> &[Sample<f64>] {
    let variance = |segment: &[Sample<f64>]| {
        let n = segment.len() as f64;
        let mean = segment.iter().map(|s| s.rudder_rad).sum::<f64>() / n;
        segment.iter().map(|s| (s.rudder_rad - mean).powi(2)).sum::<f64>() / n
    };
    samples
        .windows(MOST_SAMPLES)
        .step_by(MOST_SAMPLES / 2)
        .max_by(|a, b| variance(a).total_cmp(&variance(b)))
        .unwrap_or(samples)
}
