//! A stretch of record without a gap, as the likelihood compares it.

use seatrial_core::Sample;

use crate::record_series::RecordSeries;

/// Parts of an interval over which the rudder is a mean, and at most where the gear is not linear and where a stroke begins matters.
pub const PARTS: usize = 3;
const MOST_PARTS: usize = 12;

/// Headings at their times, and the integral of the command.
#[derive(Clone, Debug)]
pub struct Leg {
    /// Times of the comparisons, s, from the first sample.
    pub time_s: Vec<f64>,
    /// Headings of the comparisons, rad, unwrapped, from the first.
    pub heading_rad: Vec<f64>,
    /// Times at which the command changes, s.
    change_s: Vec<f64>,
    /// Integral of the command up to these times, rad s.
    integral: Vec<f64>,
    /// The first and the last command, rad.
    ends_rad: [f64; 2],
    /// Samples of a comparison.
    block: usize,
}

impl Leg {
    /// Means of `block` samples each. The command is kept whole: thinning the heading never thins the rudder.
    ///
    /// `samples` are finite and increase in time; headings may be wrapped.
    pub fn new(samples: &[Sample<f64>], block: usize) -> Self {
        let block = block.max(1);
        let series = RecordSeries::new(samples, 1);
        let start_s = samples.first().map_or(0.0, |s| s.time_s);
        let time_s: Vec<f64> = samples.iter().map(|s| s.time_s - start_s).collect();
        let means = |of: &[f64]| -> Vec<f64> {
            let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
            of.chunks_exact(block).map(mean).collect()
        };
        let mut total = 0.0;
        let integral = std::iter::once(0.0)
            .chain(
                time_s
                    .windows(2)
                    .zip(&series.rudder_rad)
                    .map(|(t, rudder)| {
                        total += (t[1] - t[0]) * rudder;
                        total
                    }),
            )
            .collect();
        let rudder = |sample: Option<&f64>| sample.copied().unwrap_or(0.0);
        Self {
            block,
            heading_rad: means(&series.heading_rad),
            integral,
            ends_rad: [
                rudder(series.rudder_rad.first()),
                rudder(series.rudder_rad.last()),
            ],
            change_s: time_s.clone(),
            time_s: means(&time_s),
        }
    }

    /// Number of comparisons.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Has the leg no comparison?
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// From the first to the last comparison, s.
    pub fn duration_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Parts of an interval at which the record of the rudder is fine enough for a gear that is not linear.
    pub fn fine_parts(&self) -> usize {
        self.block.clamp(PARTS, MOST_PARTS)
    }

    /// Mean command over so many parts of each interval between comparisons, rad, where it acts `shift_s` later than recorded.
    pub fn commands(&self, shift_s: f64, parts: usize) -> Vec<f64> {
        let mut commands = Vec::with_capacity(parts * self.len());
        let mut at = 0;
        let mut upto = |time_s: f64| {
            while at + 1 < self.change_s.len() && self.change_s[at + 1] <= time_s {
                at += 1;
            }
            self.integral_near(at, time_s)
        };
        let Some(first) = self.time_s.first() else {
            return commands;
        };
        let mut before = upto(first - shift_s);
        for pair in self.time_s.windows(2) {
            let part_s = (pair[1] - pair[0]) / parts as f64;
            for part in 1..=parts {
                let now = upto(pair[0] + part as f64 * part_s - shift_s);
                commands.push((now - before) / part_s);
                before = now;
            }
        }
        commands
    }

    /// Angles over parts of the intervals between comparisons, averaged over as long as the headings of a comparison are.
    ///
    /// A mean of `block` samples in a row has the spread of one over sqrt(1 - 1/block^2) of their interval. Without it a step of the rudder is
    /// compared with a heading that turns half a block before: a22 of a slow gear was wrong by 2.5 % where a block was half the time constant.
    pub fn averaged(&self, angles_rad: Vec<f64>, parts: usize) -> Vec<f64> {
        let block = self.block as f64;
        let width = (1.0 - 1.0 / (block * block)).sqrt() * parts as f64;
        let Some(last) = angles_rad.len().checked_sub(1).filter(|_| width > 0.0) else {
            return angles_rad;
        };
        let (mut once, mut twice) = (0.0, 0.0);
        let integrals: Vec<[f64; 2]> = (angles_rad.iter())
            .map(|angle| {
                let before = [once, twice];
                twice += once + 0.5 * angle;
                once += angle;
                before
            })
            .collect();
        // The second integral of the angle, which stays as it is before the first part and after the last.
        let upto = |at: f64| {
            let part = (at.max(0.0) as usize).min(last);
            let since = at - part as f64;
            let [once, twice] = integrals[part];
            twice + since * (once + 0.5 * since * angles_rad[part])
        };
        let about = |at: usize| upto(at as f64 + 0.5 * width) - upto(at as f64 - 0.5 * width);
        (0..=last)
            .map(|part| (about(part + 1) - about(part)) / width)
            .collect()
    }

    /// Integral of the command up to a time at or after change `at`, rad s.
    fn integral_near(&self, at: usize, time_s: f64) -> f64 {
        let (Some(change_s), Some(integral)) = (self.change_s.get(at), self.integral.get(at))
        else {
            return 0.0;
        };
        let since_s = time_s - change_s;
        let slope = match (self.change_s.get(at + 1), self.integral.get(at + 1)) {
            _ if since_s < 0.0 => self.ends_rad[0],
            (Some(next_s), Some(next)) => (next - integral) / (next_s - change_s),
            _ => self.ends_rad[1],
        };
        integral + slope * since_s
    }

    /// Standard deviation of the heading, rad.
    pub fn heading_deviation_rad(&self) -> f64 {
        deviation(&self.heading_rad)
    }

    /// Slopes of the heading between comparisons, rad/s.
    pub fn slopes_rad_s(&self) -> Vec<f64> {
        (self.heading_rad.windows(2).zip(self.time_s.windows(2)))
            .map(|(psi, t)| (psi[1] - psi[0]) / (t[1] - t[0]))
            .collect()
    }
}

/// Standard deviation of values; 0 where there are none.
pub fn deviation(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::filter::{Start, angles, innovations};
    use super::super::steering_model::{SteeringModel, SteeringState};
    use super::*;

    /// Blocks of half the time constant, a gear that is slower than a block, and no noise: the true vehicle explains the means of headings.
    #[test]
    fn exact_means_of_headings_follow_means_of_the_rudder() {
        let model = SteeringModel {
            a22_per_s: -0.1,
            b2_per_s2: 0.01,
            rate_limit_rad_s: Some(0.04),
            ..SteeringModel::default()
        };
        let rudder_rad = |row: usize| match row / 60 {
            0 => 0.0,
            strokes if strokes % 2 == 1 => 0.6,
            _ => -0.6,
        };
        let mut samples: Vec<Sample<f64>> = (0..600)
            .map(|row| Sample {
                time_s: 0.5 * row as f64,
                rudder_rad: rudder_rad(row),
                ..Sample::default()
            })
            .collect();
        let states = model.simulate(&samples, SteeringState::default());
        for (sample, state) in samples.iter_mut().zip(states) {
            sample.heading_rad = state.heading_rad;
        }
        let leg = Leg::new(&samples, 10);
        let (vehicle, range) = (model.vehicle(), [0, leg.len()]);
        let angles = angles(&leg, &vehicle);
        let errors = innovations(&leg, range, &vehicle, &Start::default(), None, &angles);
        let most = errors.iter().fold(0.0, |most: f64, e| most.max(e.abs()));
        // The turn accelerates by 0.006 rad/s^2: instants in the place of means are off by a 24th of that times 25 s^2, 6e-3 rad.
        assert!(most < 1e-4, "{most}");
    }
}
