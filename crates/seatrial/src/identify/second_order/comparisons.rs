//! A record in comparisons: means over blocks of samples, and what the rudder does within one.
//!
//! The model goes from half to half of a comparison with the mean rudder of each, because a comparison is no longer than a twentieth of
//! the vehicle's time constant. What the rudder does besides its mean moves the yaw rate by b2 R and the heading by b2 P:
//!
//! ```text
//! R_(j+1) = R_j + (u_j - mean u) h_j,   P_(j+1) = P_j + R_j h_j + (u_j - mean u) h_j^2/2
//! ```
//!
//! Of P and its integral the dynamics make their part of yaw rate and drift.

use std::borrow::Cow;

use seatrial_core::{LostRudder, Real, Sample};

use crate::identify::record_series::mean_rudder_rad;
use crate::record::median_interval_s;
use crate::sway_yaw::model::{LagStep, Rudder};

/// A record, compared block by block, as in [`crate::identify::record_series`].
pub(super) struct Comparisons {
    interval_s: Vec<f64>,
    rudder_rad: Vec<f64>,
    /// Rows of a comparison.
    pub(super) block: usize,
    pub(super) all: Vec<Comparison>,
    /// The rudder within each interval, where it acts at once.
    prompt: Vec<RudderWithin>,
    range_rad: f64,
    /// Were samples lost?
    pub(super) has_gaps: bool,
    pub(super) floor_rad2: f64,
    /// Sway decays at these rates, 1/s.
    pub(super) slowest_sway_per_s: f64,
    pub(super) fastest_sway_per_s: f64,
}

/// The samples of one comparison.
pub(super) struct Comparison {
    /// From its first sample to the first of the next, s.
    pub(super) duration_s: f64,
    /// Mean measured heading, rad.
    pub(super) heading_rad: f64,
    /// What heading and yaw rate at the beginning, and both at the end, give to the mean heading: Hermite's cubic at the samples.
    pub(super) path: [f64; 4],
    /// One sample makes only the first.
    pub(super) halves: [Half; 2],
}

/// A half of a comparison.
#[derive(Clone, Copy, Default)]
pub(super) struct Half {
    /// s
    pub(super) duration_s: f64,
    /// What it adds to the mean heading of the comparison, as [`Comparison::path`].
    pub(super) path: [f64; 4],
}

/// What the rudder does within a comparison: each value and its derivative to the rudder's lag.
#[derive(Clone, Copy, Default)]
pub(super) struct RudderWithin {
    /// Mean angle, rad.
    pub(super) mean: [f64; 2],
    /// P at the end, rad s^2.
    pub(super) to_end: [f64; 2],
    /// Q at the end, the integral of P, rad s^3.
    pub(super) integral: [f64; 2],
    /// Mean of P over the samples, rad s^2.
    pub(super) to_mean: [f64; 2],
    pub(super) halves: [RudderOfHalf; 2],
}

/// What the rudder does within a half of a comparison.
#[derive(Clone, Copy, Default)]
pub(super) struct RudderOfHalf {
    /// Mean angle, rad.
    pub(super) mean_rad: f64,
    /// P at the end, rad s^2.
    pub(super) to_end: f64,
    /// Q at the end, the integral of P, rad s^3.
    pub(super) integral: f64,
    /// What P adds to its mean over the comparison, rad s^2.
    pub(super) to_mean: f64,
}

/// A residual of this share of the heading's range is the integration's own: no order is decided by it.
const FLOOR_SHARE: f64 = 1e-6;

/// A sway that remembers for longer than this share of the record cannot be distinguished from a drifting disturbance, one
/// that forgets within a comparison not from damping.
const LONGEST_MEMORY_SHARE: f64 = 1.0 / 8.0;

impl Comparisons {
    pub(super) fn new(samples: &[Sample<f64>], block: usize) -> Self {
        let mut heading = 0.0;
        let turns = samples
            .windows(2)
            .map(|pair| Real::wrapped(pair[1].heading_rad - pair[0].heading_rad));
        let heading_rad: Vec<f64> = std::iter::once(0.0)
            .chain(turns)
            .map(|turn| {
                heading += turn;
                heading
            })
            .collect();
        let usual_s = median_interval_s(samples).unwrap_or(0.0);
        let is_gap = |pair: &[Sample<f64>]| {
            let interval_s = pair[1].time_s - pair[0].time_s;
            LostRudder::Interpolated.steps(interval_s, usual_s) > 1
        };
        let duration_s = samples.last().map_or(0.0, |s| s.time_s) - samples[0].time_s;
        let interval_s: Vec<f64> = samples
            .windows(2)
            .map(|pair| pair[1].time_s - pair[0].time_s)
            .chain([0.0])
            .collect();
        let range_rad = range(&heading_rad);
        let mut record = Self {
            slowest_sway_per_s: 1.0 / (LONGEST_MEMORY_SHARE * duration_s),
            fastest_sway_per_s: samples.len() as f64 / (block as f64 * duration_s),
            has_gaps: samples.windows(2).any(is_gap),
            floor_rad2: (FLOOR_SHARE * range_rad).powi(2),
            range_rad,
            rudder_rad: mean_rudder_rad(samples, usual_s),
            all: (interval_s
                .chunks_exact(block)
                .zip(heading_rad.chunks_exact(block)))
            .map(|(interval_s, heading_rad)| Comparison::of(interval_s, heading_rad))
            .collect(),
            interval_s,
            block,
            prompt: Vec::new(),
        };
        record.prompt = record.acting_behind(0.0);
        record
    }

    pub(super) fn count(&self) -> usize {
        self.all.len()
    }

    /// Mean rudder of each comparison, rad.
    pub(super) fn rudder_rad(&self) -> Vec<f64> {
        self.rudder_rad
            .chunks_exact(self.block)
            .map(mean_of)
            .collect()
    }

    /// Largest less smallest heading, rad.
    pub(super) fn range_rad(&self) -> f64 {
        self.range_rad
    }

    /// The rudder of each comparison as it acts behind a lag, s.
    pub(super) fn acting(&self, lag_s: f64) -> Cow<'_, [RudderWithin]> {
        match lag_s > 0.0 {
            true => Cow::Owned(self.acting_behind(lag_s)),
            false => Cow::Borrowed(&self.prompt),
        }
    }

    fn acting_behind(&self, lag_s: f64) -> Vec<RudderWithin> {
        let mut rudder = Rudder::at(self.rudder_rad.first().copied().unwrap_or(0.0));
        let mut step = LagStep::over(1.0, lag_s);
        let mut means = vec![[0.0; 2]; self.block];
        let blocks = self.interval_s.chunks_exact(self.block);
        blocks
            .zip(self.rudder_rad.chunks_exact(self.block))
            .map(|(interval_s, commands_rad)| {
                for ((mean, h), command_rad) in means.iter_mut().zip(interval_s).zip(commands_rad) {
                    if *h <= 0.0 {
                        *mean = [0.0; 2];
                        continue;
                    }
                    if *h != step.interval_s {
                        step = LagStep::over(*h, lag_s);
                    }
                    let of_interval = rudder.advance_by(*command_rad, &step);
                    *mean = [of_interval.angle_rad, of_interval.to_lag];
                }
                RudderWithin::of(&means, interval_s)
            })
            .collect()
    }
}

/// The samples of the first half of a comparison.
fn first_half(block: usize) -> usize {
    block.div_ceil(2)
}

impl Comparison {
    fn of(interval_s: &[f64], heading_rad: &[f64]) -> Self {
        let whole = Half::of(interval_s, interval_s.len());
        let (first, second) = interval_s.split_at(first_half(interval_s.len()));
        Self {
            duration_s: whole.duration_s,
            heading_rad: mean_of(heading_rad),
            path: whole.path,
            halves: [first, second].map(|half| Half::of(half, interval_s.len())),
        }
    }
}

impl Half {
    /// The half of a comparison that these intervals make up, as a part of `count` samples.
    fn of(interval_s: &[f64], count: usize) -> Self {
        let duration_s: f64 = interval_s.iter().sum();
        let mut path = [0.0; 4];
        let mut since_s = 0.0;
        for h in interval_s {
            let t = match duration_s > 0.0 {
                true => since_s / duration_s,
                false => 0.0,
            };
            let weights = [
                (1.0 + 2.0 * t) * (1.0 - t) * (1.0 - t),
                duration_s * t * (1.0 - t) * (1.0 - t),
                t * t * (3.0 - 2.0 * t),
                duration_s * t * t * (t - 1.0),
            ];
            for (total, weight) in path.iter_mut().zip(weights) {
                *total += weight / count as f64;
            }
            since_s += h;
        }
        Self { duration_s, path }
    }
}

impl RudderWithin {
    /// The rudder within intervals, from its mean over each of them and the derivative of that.
    fn of(means: &[[f64; 2]], interval_s: &[f64]) -> Self {
        let count = means.len() as f64;
        let within = |of: usize| besides_its_mean(means.iter().map(|mean| mean[of]), interval_s);
        let [angle, to_lag] = [within(0), within(1)];
        let half = |means: &[[f64; 2]], interval_s: &[f64]| {
            let [mean_rad, to_end, integral, sum] =
                besides_its_mean(means.iter().map(|mean| mean[0]), interval_s);
            RudderOfHalf {
                mean_rad,
                to_end,
                integral,
                to_mean: sum / count,
            }
        };
        let (first, second) = means.split_at(first_half(means.len()));
        let (first_s, second_s) = interval_s.split_at(first.len());
        Self {
            mean: [angle[0], to_lag[0]],
            to_end: [angle[1], to_lag[1]],
            integral: [angle[2], to_lag[2]],
            to_mean: [angle[3] / count, to_lag[3] / count],
            halves: [half(first, first_s), half(second, second_s)],
        }
    }
}

/// The mean of the rudder, P and Q at the end, and the sum of P over the samples.
fn besides_its_mean(values: impl Iterator<Item = f64> + Clone, interval_s: &[f64]) -> [f64; 4] {
    let duration_s: f64 = interval_s.iter().sum();
    if duration_s <= 0.0 {
        return [0.0; 4];
    }
    let integral: f64 = values.clone().zip(interval_s).map(|(u, h)| u * h).sum();
    let mean = integral / duration_s;
    let (mut r, mut p, mut q, mut sum) = (0.0, 0.0, 0.0, 0.0);
    for (u, h) in values.zip(interval_s) {
        sum += p;
        let away = u - mean;
        q += h * (p + h * (r / 2.0 + h * away / 6.0));
        p += h * (r + h * away / 2.0);
        r += h * away;
    }
    [mean, p, q, sum]
}

fn mean_of(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn range(values: &[f64]) -> f64 {
    let high = values.iter().copied().fold(f64::MIN, f64::max);
    high - values.iter().copied().fold(f64::MAX, f64::min)
}
