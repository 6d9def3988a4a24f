//! How often each channel of a log brings something new.

use seatrial_core::Sample;

/// Changes that tell the pace of a channel: fewer may be far apart by chance.
const LEAST_CHANGES: usize = 8;

/// Share of the distances between changes that may be shorter than the pace: a clock's rounding.
const SHORTER: f64 = 0.1;

/// Intervals at which the channels of a log are renewed, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Interval of the rows, s.
    pub row_s: f64,
    /// Interval at which the heading is renewed, s.
    pub heading_s: f64,
    /// Interval at which the rudder is renewed, s; at least that of the rows, and equal to it where the rudder hardly moved.
    pub rudder_s: f64,
}

impl Pace {
    /// The pace of a channel is the distance between its changes that nine of ten reach. `None` for fewer than two samples.
    ///
    /// A logger writes the latest value of a slow channel beside a fast one, and when it changed in between nobody knows.
    pub fn of(samples: &[Sample<f64>]) -> Option<Self> {
        let times: Vec<f64> = samples.iter().map(|s| s.time_s).collect();
        let row_s = low(times.windows(2).map(|t| t[1] - t[0]).collect(), 0.5)?;
        let renewed = |value: fn(&Sample<f64>) -> f64| {
            let changes: Vec<f64> = (samples.windows(2))
                .filter(|pair| value(&pair[0]) != value(&pair[1]))
                .map(|pair| pair[1].time_s)
                .collect();
            let apart: Vec<f64> = changes.windows(2).map(|t| t[1] - t[0]).collect();
            // A relay's few angles are no channel's pace.
            match apart.len().min(different(samples.iter().map(value))) < LEAST_CHANGES {
                true => row_s,
                false => low(apart, SHORTER).unwrap_or(row_s).max(row_s),
            }
        };
        Some(Self {
            row_s,
            heading_s: renewed(|s| s.heading_rad),
            rudder_s: renewed(|s| s.rudder_rad),
        })
    }

    /// The larger of the intervals of heading and rudder, s.
    pub fn slowest_s(&self) -> f64 {
        self.heading_s.max(self.rudder_s)
    }
}

/// How many different values there are; counted up to [`LEAST_CHANGES`].
fn different(values: impl Iterator<Item = f64>) -> usize {
    let mut seen: Vec<f64> = Vec::with_capacity(LEAST_CHANGES);
    for value in values {
        if seen.len() < LEAST_CHANGES && !seen.contains(&value) {
            seen.push(value);
        }
    }
    seen.len()
}

/// The value that this share of them is below.
fn low(mut values: Vec<f64>, share: f64) -> Option<f64> {
    let place = (share * values.len() as f64) as usize;
    (place < values.len()).then(|| *values.select_nth_unstable_by(place, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(rudder_rows: u32, heading_rows: u32) -> Vec<Sample<f64>> {
        let held = |k: u32, rows: u32| f64::from(k / rows * rows).sin();
        (0..400)
            .map(|k| Sample {
                time_s: 0.05 * f64::from(k),
                heading_rad: held(k, heading_rows),
                rudder_rad: held(k, rudder_rows),
                ..Sample::default()
            })
            .collect()
    }

    #[test]
    fn exact_a_held_channel_shows_its_pace() {
        for (rudder, heading) in [(1, 1), (2, 1), (20, 1), (1, 8)] {
            let pace = Pace::of(&log(rudder, heading)).unwrap();
            let expected = [0.05, 0.05 * f64::from(heading), 0.05 * f64::from(rudder)];
            for (found, expected) in
                [pace.row_s, pace.heading_s, pace.rudder_s].iter().zip(expected)
            {
                // The clock's rounding.
                assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            }
        }
    }

    #[test]
    fn exact_a_rudder_that_hardly_moves_tells_no_pace() {
        let mut samples = log(1, 1);
        for (k, sample) in samples.iter_mut().enumerate() {
            sample.rudder_rad = if (100..140).contains(&k) { 0.26 } else { 0.0 };
        }
        // The rows' own.
        assert!((Pace::of(&samples).unwrap().rudder_s - 0.05).abs() < 1e-9);
    }
}
