//! What a trial would tell of the surge, before it is run.
//!
//! ```text
//! V = s^2 (J'J)^-1
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | V | covariance of steady speeds, ln l, lag, d and the first speed of each part | |
//! | J | derivatives by them of the speeds that are expected, as the fit of a record has them | |
//! | s | noise of the speed | m/s |
//!
//! Source: the Cramer-Rao bound of least squares, S. Kay, Fundamentals of Statistical Signal Processing: Estimation Theory, 1993, 3.9. The
//! expected speeds are those of the fit's own form with d = 0, which is varied all the same: the estimate of a record varies it
//! where it is significant. Valid for white noise; what the form lacks is not in it. A plan of two speeds takes some 2 ms.

use seatrial_core::Sample;
use serde::Serialize;

use super::fit::{FreeParameters, Parameters, expected_errors, played};
use super::parts::{Instant, Part};
use super::{CHANGE, WIDEST, changes_thrust};
use crate::propagation::NORMAL_95;

/// Deviations of the noise by which a change of speed must exceed what counts as one: one reading decides it.
const CHANGE_DEVIATIONS: f64 = 2.0;

/// A run of a trial that is expected.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpectedRun {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// The steady speed at it, m/s.
    pub surge_speed_m_s: f64,
    /// Samples before the first doublet.
    pub settling: usize,
    /// All samples; their times and yaw rates count.
    pub samples: Vec<Sample<f64>>,
}

/// What is believed of a vehicle's surge before its trial.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SurgeBelief {
    /// Drag length l, m.
    pub drag_length_m: f64,
    /// Lag of the thrust, s.
    pub thrust_lag_s: f64,
    /// Noise of the speed that each sample has, m/s.
    pub noise_m_s: f64,
}

/// What a trial will tell of drag length and lag. Absent: it tells nothing of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ExpectedSurge {
    /// The 95 % interval of the drag length, as a factor to either side.
    pub drag_length_factor_95: Option<f64>,
    /// Half width of the 95 % interval of the lag, s.
    pub thrust_lag_half_width_95_s: Option<f64>,
}

impl ExpectedSurge {
    /// What these runs will tell, the first from this speed on, m/s.
    pub fn of(runs: &[ExpectedRun], first_m_s: f64, belief: &SurgeBelief) -> Self {
        let (parts, steady_m_s) = parts_of(runs);
        let surge = [belief.drag_length_m, belief.thrust_lag_s];
        let parameters = Parameters::believed(&parts, &steady_m_s, first_m_s, surge);
        let speeds = played(&parts, &parameters);
        let mut from = 0;
        let has_change = parts.iter().any(|part| {
            let (first, steady) = (speeds[from], steady_m_s[part.thrust]);
            from += part.instants.len();
            let least = CHANGE * steady.abs() + CHANGE_DEVIATIONS * belief.noise_m_s;
            (first - steady).abs() > least
        });
        let varied = FreeParameters {
            length: true,
            lag: changes_thrust(&parts),
            turning_drag: parts.iter().any(|part| part.instants.len() > part.settling),
        };
        let found = has_change
            .then(|| expected_errors(&parts, &parameters, varied, belief.noise_m_s))
            .flatten();
        let [length, lag_s] = found.unwrap_or_default();
        Self {
            drag_length_factor_95: length.map(|error| libm::exp(NORMAL_95 * error)),
            thrust_lag_half_width_95_s: lag_s.map(|error| NORMAL_95 * error),
        }
    }

    /// Will drag length and lag count as identified?
    pub fn is_identified(&self) -> bool {
        self.thrust_lag_half_width_95_s.is_some()
            && self.drag_length_factor_95.is_some_and(|factor| factor < WIDEST)
    }

    /// The wider of both.
    ///
    /// ```
    /// use seatrial::motions::surge::ExpectedSurge;
    ///
    /// let of = |factor, half_width_s| ExpectedSurge {
    ///     drag_length_factor_95: Some(factor),
    ///     thrust_lag_half_width_95_s: half_width_s,
    /// };
    /// assert_eq!(of(1.1, Some(0.2)).wider(of(1.3, Some(0.1))), of(1.3, Some(0.2)));
    /// // What one of them does not tell is not told.
    /// assert!(!of(1.1, Some(0.2)).wider(of(1.1, None)).is_identified());
    /// ```
    pub fn wider(self, other: Self) -> Self {
        let wider = |a: Option<f64>, b: Option<f64>| Some(f64::max(a?, b?));
        Self {
            drag_length_factor_95: wider(self.drag_length_factor_95, other.drag_length_factor_95),
            thrust_lag_half_width_95_s: wider(
                self.thrust_lag_half_width_95_s,
                other.thrust_lag_half_width_95_s,
            ),
        }
    }
}

/// The parts of the fit, and the steady speeds of their thrusts.
fn parts_of(runs: &[ExpectedRun]) -> (Vec<Part>, Vec<f64>) {
    let mut thrusts: Vec<(f64, f64)> = Vec::new();
    for run in runs {
        if thrusts.iter().all(|(thrust, _)| *thrust != run.thrust) {
            thrusts.push((run.thrust, run.surge_speed_m_s));
        }
    }
    let place = |thrust: f64| thrusts.iter().position(|(other, _)| *other == thrust);
    let mut before = None;
    let parts = runs
        .iter()
        .filter(|run| run.samples.len() > 1)
        .filter_map(|run| {
            let thrust = place(run.thrust)?;
            let instants = run.samples.iter().map(|sample| Instant {
                time_s: sample.time_s,
                surge_speed_m_s: sample.surge_speed_m_s.unwrap_or(run.surge_speed_m_s),
                yaw_rate_rad_s: sample.yaw_rate_rad_s.unwrap_or_default(),
            });
            Some(Part {
                thrust,
                before: before.replace(thrust).unwrap_or(thrust),
                settling: run.settling,
                yaw_rate_variance: 0.0,
                instants: instants.collect(),
            })
        })
        .collect();
    (parts, thrusts.iter().map(|(_, speed)| *speed).collect())
}
