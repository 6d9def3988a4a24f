//! What the samples of a training tell of the log itself.

use seatrial_core::Sample;

/// The smallest change of heading from one sample to the next: the step in which a compass reads, or
/// very little.
pub fn smallest_heading_step_rad(samples: &[Sample<f64>]) -> Option<f64> {
    samples
        .windows(2)
        .map(|pair| (pair[1].heading_rad - pair[0].heading_rad).abs())
        .filter(|step| *step > 0.0)
        .reduce(f64::min)
}

/// Mean speed of the first and of the last quarter of the samples that tell it, m/s.
pub fn surge_speeds_m_s(samples: &[Sample<f64>]) -> Option<[f64; 2]> {
    let speeds: Vec<f64> = samples
        .iter()
        .filter_map(|s| s.surge_speed_m_s.filter(|speed| *speed > 0.0))
        .collect();
    let quarter = speeds.len() / 4;
    let mean = |part: &[f64]| part.iter().sum::<f64>() / quarter as f64;
    (quarter > 0).then(|| {
        [
            mean(&speeds[..quarter]),
            mean(&speeds[speeds.len() - quarter..]),
        ]
    })
}

/// The median interval and the one that one in twenty exceeds, s.
pub fn usual_and_long_interval_s(samples: &[Sample<f64>]) -> Option<[f64; 2]> {
    let mut intervals: Vec<f64> = samples
        .windows(2)
        .map(|pair| pair[1].time_s - pair[0].time_s)
        .filter(|interval| *interval > 0.0)
        .collect();
    intervals.sort_by(f64::total_cmp);
    let at = |share: f64| {
        intervals
            .get((share * intervals.len() as f64) as usize)
            .copied()
    };
    Some([at(0.5)?, at(0.95)?])
}
