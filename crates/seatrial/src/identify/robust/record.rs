//! A record made ready for the robust estimate.

use super::even::{EvenResponses, OFF_THE_GRID, held_until};
use super::response::{Dynamics, responses};
use crate::record::even_interval_s;

/// Comparisons per time constant of the vehicle: more tell nothing new.
const COMPARISONS_PER_TIME_CONSTANT: f64 = 30.0;

/// Believed standard deviation of the time of a heading, in sample intervals.
const TIMING_INTERVALS: f64 = 0.02;

/// Times, unwrapped headings from the first, and the rudder of a record.
#[derive(Clone, Debug)]
pub struct Record {
    /// Increasing, s.
    pub time_s: Vec<f64>,
    /// Unwrapped, from the first, rad.
    pub heading_rad: Vec<f64>,
    /// As recorded, rad.
    pub rudder_rad: Vec<f64>,
    /// The usual sample interval, s.
    pub interval_s: f64,
    /// Interval to which the time of a rudder's movement is known, s: no less than the sample interval.
    pub timing_s: f64,
    /// Lag and shift of the rudder together, s, where they are known from elsewhere.
    pub known_delay_s: Option<f64>,
    /// Half of the rudder's range, rad.
    pub amplitude_rad: f64,
    /// Least standard deviation of a heading's error, rad.
    pub floor_rad: f64,
    /// The sample interval, s, where all are the same.
    even_s: Option<f64>,
    held_until: Vec<usize>,
}

/// Parameters, in the order of every vector and matrix of this folder.
///
/// | index | parameter | unit |
/// |---|---|---|
/// | `B2` | b2 | 1/s^2 |
/// | `C0` | C0 | rad/s^2 |
/// | `HEADING`, `RATE` | psi0, r0, at the first sample | rad, rad/s |
/// | `FIRST` | b2 times the first rudder's distance from its record | rad/s^2 |
/// | `A22` | a22 | 1/s |
/// | `DELAY` | s = T_l + tau, lag and shift of the rudder together | s |
/// | `LAG2` | v = T_l^2 | s^2 |
pub const PARAMETERS: usize = 8;
/// b2.
pub const B2: usize = 0;
/// C0.
pub const C0: usize = 1;
/// psi0.
pub const HEADING: usize = 2;
/// r0.
pub const RATE: usize = 3;
/// b2 times the first rudder's distance from its record.
pub const FIRST: usize = 4;
/// a22.
pub const A22: usize = 5;
/// s = T_l + tau.
pub const DELAY: usize = 6;
/// v = T_l^2.
pub const LAG2: usize = 7;

/// A vehicle and its state at the first sample.
///
/// The delay s and v = T_l^2 in place of lag and shift: to first order a record shows only their sum, to second order
/// the square of the lag, so that derivatives exist at T_l = 0 too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point(pub [f64; PARAMETERS]);

impl Point {
    /// A vehicle of this damping at rest behind a rudder of this lag, without a shift.
    pub fn lagging(a22_per_s: f64, lag_s: f64) -> Self {
        let mut point = Self([0.0; PARAMETERS]);
        point.0[A22] = a22_per_s;
        point.0[DELAY] = lag_s;
        point.0[LAG2] = lag_s * lag_s;
        point
    }

    /// Dynamics alone.
    pub fn dynamics(&self) -> Dynamics {
        let lag_s = self.0[LAG2].max(0.0).sqrt();
        Dynamics { a22_per_s: self.0[A22], lag_s, shift_s: self.0[DELAY] - lag_s }
    }
}

impl Record {
    /// `time_s` increases, everything is finite, headings are unwrapped; there are at least two samples. `resolution_rad` is
    /// the smallest step of the heading, 0 where unknown.
    pub fn new(
        time_s: Vec<f64>,
        heading_rad: Vec<f64>,
        rudder_rad: Vec<f64>,
        resolution_rad: f64,
    ) -> Self {
        let mut intervals: Vec<f64> = time_s.windows(2).map(|t| t[1] - t[0]).collect();
        intervals.sort_by(f64::total_cmp);
        let interval_s = intervals.get(intervals.len() / 2).copied().unwrap_or(0.0);
        let (low, high) =
            rudder_rad.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), rudder| {
                (low.min(*rudder), high.max(*rudder))
            });
        let steps = heading_rad.windows(2).zip(time_s.windows(2));
        let squares = steps.map(|(psi, t)| ((psi[1] - psi[0]) / (t[1] - t[0])).powi(2));
        let rate_rad_s = (squares.sum::<f64>() / heading_rad.len() as f64).sqrt();
        let timing_rad = TIMING_INTERVALS * interval_s * rate_rad_s;
        Self {
            even_s: even_interval_s(&time_s, OFF_THE_GRID),
            held_until: held_until(&rudder_rad),
            time_s,
            heading_rad,
            rudder_rad,
            interval_s,
            timing_s: interval_s,
            known_delay_s: None,
            amplitude_rad: 0.5 * (high - low),
            floor_rad: libm::hypot(timing_rad, resolution_rad / 12_f64.sqrt()).max(1e-12),
        }
    }

    /// With a channel that is renewed at such intervals only, s.
    pub fn timed_to(self, timing_s: f64) -> Self {
        Self { timing_s: timing_s.max(self.interval_s), ..self }
    }

    /// The record with a lag and shift of the rudder that are known from elsewhere, s.
    pub fn delayed_by(self, known_delay_s: Option<f64>) -> Self {
        Self { known_delay_s, ..self }
    }

    /// With another rudder at the same times, rad.
    pub fn with_rudder(&self, rudder_rad: Vec<f64>) -> Self {
        Self { held_until: held_until(&rudder_rad), rudder_rad, ..self.clone() }
    }

    /// Length, s.
    pub fn duration_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// |a22|, but no slower than what the record can show, 1/s.
    pub fn rate_scale(&self, a22_per_s: f64) -> f64 {
        a22_per_s.abs().max(2.0 / self.duration_s())
    }

    /// Samples that make one comparison for a vehicle of this damping.
    pub fn block(&self, a22_per_s: f64) -> usize {
        let per_time_constant = 1.0 / (self.rate_scale(a22_per_s) * self.interval_s);
        let most = self.time_s.len() / 60;
        ((per_time_constant / COMPARISONS_PER_TIME_CONSTANT) as usize).clamp(1, most.max(1))
    }

    /// [`responses`] of this record.
    pub fn responses(&self, dynamics: &Dynamics) -> Vec<[f64; 5]> {
        responses(&self.time_s, &self.rudder_rad, dynamics)
    }

    /// Means of [`responses`] over each comparison of `block` samples, of several dynamics side by side.
    pub fn mean_responses<const L: usize, T>(
        &self,
        dynamics: &[Dynamics; L],
        block: usize,
        mut of_comparison: impl FnMut(usize, &[[f64; L]; 5]) -> T,
    ) -> Vec<T> {
        let count = self.time_s.len() / block;
        if let Some(interval_s) = self.even_s {
            let (rudder_rad, held) = (&self.rudder_rad, &self.held_until);
            let mut even = EvenResponses::new(rudder_rad, held, interval_s, block, dynamics);
            return (0..count).map(|k| of_comparison(k, &even.means())).collect();
        }
        let each = dynamics.map(|of_lane| self.responses(&of_lane));
        let share = 1.0 / block as f64;
        (0..count)
            .map(|k| {
                let mut means = [[0.0; L]; 5];
                for (lane, rows) in each.iter().enumerate() {
                    for row in &rows[k * block..(k + 1) * block] {
                        for (mean, response) in means.iter_mut().zip(row) {
                            mean[lane] += share * response;
                        }
                    }
                }
                of_comparison(k, &means)
            })
            .collect()
    }

    /// Means over each comparison of `block` samples of the response to b2 of another rudder at the same times.
    pub fn mean_rudder_responses(
        &self,
        rudder_rad: &[f64],
        dynamics: &Dynamics,
        block: usize,
    ) -> Vec<f64> {
        let count = self.time_s.len() / block;
        if let Some(interval_s) = self.even_s {
            let held = held_until(rudder_rad);
            let mut even = EvenResponses::new(rudder_rad, &held, interval_s, block, &[*dynamics]);
            return (0..count).map(|_| even.mean_of_the_rudder()[0]).collect();
        }
        responses(&self.time_s, rudder_rad, dynamics)
            .chunks_exact(block)
            .map(|rows| rows.iter().map(|row| row[B2]).sum::<f64>() / block as f64)
            .collect()
    }

    /// Simulated headings, rad.
    pub fn simulate(&self, point: &Point) -> Vec<f64> {
        let responses = self.responses(&point.dynamics());
        responses.iter().map(|row| explained(row, point)).collect()
    }
}

/// The heading that the linear parameters give, rad.
pub fn explained(responses: &[f64; 5], point: &Point) -> f64 {
    responses.iter().zip(&point.0).map(|(r, p)| r * p).sum()
}

/// a22, b2, C0 of all parameters.
pub fn three(covariance: &[[f64; PARAMETERS]; PARAMETERS]) -> [[f64; 3]; 3] {
    const THETA: [usize; 3] = [A22, B2, C0];
    THETA.map(|i| THETA.map(|j| covariance[i][j]))
}
