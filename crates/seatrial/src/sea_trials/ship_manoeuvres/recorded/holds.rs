//! Where a record holds its rudder, and the yaw rate that it reaches there.

use seatrial_core::Sample;

use super::unwrapped_headings_rad;
use crate::line::Line;

/// A rudder is held while it stays within this share of the largest.
const HELD: f64 = 0.015;
/// A hold has at least this many samples, and this share of the longest one.
const LEAST_SAMPLES: usize = 16;
const LEAST_SHARE: f64 = 0.1;
/// A yaw rate is steady where it has less than this share of the largest still to go.
const STEADY: f64 = 0.01;
/// Standard errors that noise explains.
const ERRORS: f64 = 3.0;
/// A rudder within this share of its largest angle is amidships.
const AMIDSHIPS: f64 = 0.1;

/// A part of the record with one rudder angle.
#[derive(Clone, Debug)]
pub(super) struct Hold {
    pub rudder_rad: f64,
    pub from: usize,
    pub to: usize,
    /// When it begins, s.
    pub from_s: f64,
    /// Slopes of the heading over the last three quarters of the hold, rad/s, and their standard errors.
    slopes: [[f64; 2]; 3],
}

impl Hold {
    /// The yaw rate at the end, rad/s.
    pub fn yaw_rate_rad_s(&self) -> f64 {
        self.slopes[2][0]
    }

    /// By how much its yaw rate and that of another hold may differ by noise, rad/s.
    pub fn noise_beside_rad_s(&self, other: &Self) -> f64 {
        ERRORS * libm::hypot(self.slopes[2][1], other.slopes[2][1])
    }

    /// Is the rudder amidships?
    pub fn is_amidships(&self, largest_rad: f64) -> bool {
        self.rudder_rad.abs() <= AMIDSHIPS * largest_rad
    }

    /// Has the yaw rate reached its end? What is left of an exponential follows from the last two of its changes; `largest_rad_s` is the
    /// largest yaw rate of the record.
    pub fn is_steady(&self, largest_rad_s: f64) -> bool {
        let [a, b, c] = self.slopes.map(|slope| slope[0]);
        let noise = ERRORS * libm::hypot(self.slopes[1][1], self.slopes[2][1]);
        let (before, last) = (b - a, c - b);
        let allowed = (STEADY * largest_rad_s).max(noise);
        let ratio = last / before;
        let left = match ratio > 0.0 && ratio < 1.0 {
            true => last * ratio / (1.0 - ratio),
            false => last,
        };
        left.abs() <= allowed && last.abs() <= 2.0 * allowed
    }
}

/// The largest yaw rate that a hold reaches, rad/s.
pub(super) fn largest_rad_s(holds: &[Hold]) -> f64 {
    let rates = holds.iter().map(|hold| hold.yaw_rate_rad_s().abs());
    rates.fold(0.0, f64::max)
}

/// The holds of a record in their order.
pub(super) fn holds(samples: &[Sample<f64>], largest_rad: f64) -> Vec<Hold> {
    let mut spans: Vec<(usize, usize, f64)> = Vec::new();
    let (mut from, mut sum_rad) = (0, 0.0);
    for (k, sample) in samples.iter().enumerate() {
        let mean_rad = sum_rad / (k - from).max(1) as f64;
        if k > from && (sample.rudder_rad - mean_rad).abs() > HELD * largest_rad {
            spans.push((from, k, mean_rad));
            (from, sum_rad) = (k, 0.0);
        }
        sum_rad += sample.rudder_rad;
    }
    let count = samples.len() - from;
    spans.push((from, samples.len(), sum_rad / count.max(1) as f64));
    let lasts_s = |from: usize, to: usize| samples[to - 1].time_s - samples[from].time_s;
    let longest_s = spans
        .iter()
        .filter(|(from, to, _)| from < to)
        .map(|(from, to, _)| lasts_s(*from, *to))
        .fold(0.0, f64::max);
    let headings_rad = unwrapped_headings_rad(samples);
    spans
        .into_iter()
        .filter(|(from, to, _)| to - from >= LEAST_SAMPLES)
        .filter(|(from, to, _)| lasts_s(*from, *to) >= LEAST_SHARE * longest_s)
        .map(|(from, to, rudder_rad)| Hold {
            rudder_rad,
            from,
            to,
            from_s: samples[from].time_s,
            slopes: [1, 2, 3].map(|quarter| {
                let [begin, end] = [quarter, quarter + 1].map(|k| from + k * (to - from) / 4);
                slope(&samples[begin..end], &headings_rad[begin..end])
            }),
        })
        .collect()
}

/// The slope of the heading by least squares and its standard error, rad/s.
fn slope(samples: &[Sample<f64>], headings_rad: &[f64]) -> [f64; 2] {
    let times_s: Vec<f64> = samples.iter().map(|s| s.time_s).collect();
    let Some(line) = Line::through(&times_s, headings_rad) else { return [f64::NAN; 2] };
    let off = |(time_s, heading): (&f64, &f64)| (heading - line.at(*time_s)).powi(2);
    let left: f64 = times_s.iter().zip(headings_rad).map(off).sum();
    let noise_rad = (left / (samples.len() as f64 - 2.0)).sqrt();
    [line.slope, noise_rad * line.slope_error()]
}
