//! What steps are foreseen to come out as, with intervals.

use seatrial_core::{CascadeSettings, YawModel};
use serde::Serialize;

use super::boat::{Boat, StepTest};
use super::evidence::Evidence;
use super::response::{Response, scatter_rad};
use crate::draw::Draw;

/// Boats that are drawn.
const DRAWS: u64 = 40;
/// Standard deviation of what a rudder is late by, as a share of it, and where it is prompt, s.
const LATE: f64 = 0.15;
const LATE_S: f64 = 0.02;

/// What steps are foreseen to come out as: the middle of the boats that the evidence allows, and where 95 % of them are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Foreseen {
    /// Overshoot, a fraction of the step.
    pub overshoot: Range,
    /// Settling time, s; a boat that does not settle counts as the whole time.
    pub settling_s: Range,
    /// Rudder activity, full deflections per second.
    pub activity_per_s: Range,
    /// Oscillation, a fraction of the step.
    pub oscillation: Range,
    /// The share of boats that settle.
    pub settled: f64,
}

/// A middle and the range of 95 %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Range {
    /// Median.
    pub middle: f64,
    /// 2.5 %.
    pub low: f64,
    /// 97.5 %.
    pub high: f64,
}

impl Range {
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        // The next of n values is below the k-th with probability k/(n + 1).
        let at = |share: f64| {
            let place = (share * (values.len() + 1) as f64).round() as usize;
            let last = values.len().saturating_sub(1);
            values.get(place.saturating_sub(1).min(last)).copied().unwrap_or(f64::NAN)
        };
        Self { middle: at(0.5), low: at(0.025), high: at(0.975) }
    }
}

/// What these settings are foreseen to make of a test.
///
/// ```
/// use seatrial::gains::commission::{Evidence, StepTest, foresee};
/// use seatrial_core::{CascadeSettings, YawModel};
///
/// let evidence = Evidence {
///     model: YawModel::from_theta([-1.0, 1.0, 0.0]),
///     covariance: [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-6]],
///     lag_s: 0.0,
///     delay_s: 0.0,
///     rate_noise_rad_s: 0.0,
///     heading_noise_rad: 0.0,
///     disturbance_rad_s2: 0.0,
///     loop_interval_s: 0.05,
///     steering_taken: 0.0,
/// };
/// let settings =
///     CascadeSettings { angle_gain_per_s: 0.4, feed_forward_s: 1.0, ..CascadeSettings::default() };
/// let test = StepTest {
///     step_rad: 0.5,
///     settle_s: 5.0,
///     hold_s: 20.0,
///     sample_interval_s: 0.1,
///     loop_interval_s: 0.05,
/// };
/// // Known well and calm: every boat settles.
/// assert_eq!(foresee(&evidence, &settings, &test, 0.0).settled, 1.0);
/// ```
pub fn foresee(
    evidence: &Evidence,
    settings: &CascadeSettings<f64>,
    test: &StepTest,
    smoothing_s: f64,
) -> Foreseen {
    let mut draw = Draw::new(1);
    let responses: Vec<Response> = (0..DRAWS)
        .filter_map(|seed| {
            let boat = drawn(evidence, &mut draw);
            let legs = test.simulate(&boat, settings, seed);
            let scatter_rad = scatter_rad(&legs, smoothing_s)?;
            Response::measure(&legs, test.step_rad, smoothing_s, scatter_rad)
        })
        .collect();
    let range = |of: &dyn Fn(&Response) -> f64| Range::of(responses.iter().map(of).collect());
    let settled = responses.iter().filter(|r| r.settling_s.is_some()).count();
    Foreseen {
        overshoot: range(&|r| r.overshoot),
        settling_s: range(&|r| r.settling_s.unwrap_or(test.hold_s)),
        activity_per_s: range(&|r| r.activity_per_s),
        oscillation: range(&|r| r.oscillation),
        settled: settled as f64 / responses.len().max(1) as f64,
    }
}

/// A boat that the evidence allows.
fn drawn(evidence: &Evidence, draw: &mut Draw) -> Boat {
    let [of_a22, of_b] = evidence.deviations();
    let correlation = match of_a22 * of_b > 0.0 {
        true => (evidence.covariance[0][1] / (of_a22 * of_b)).clamp(-1.0, 1.0),
        false => 0.0,
    };
    let (first, second) = (draw.normal(), draw.normal());
    let along = correlation * first + (1.0 - correlation * correlation).sqrt() * second;
    let late_s = evidence.lag_s + evidence.delay_s;
    let later_s = (LATE * late_s).max(LATE_S) * draw.normal();
    let boat = evidence.noisy_boat();
    Boat {
        model: YawModel {
            a22_per_s: (boat.model.a22_per_s + of_a22 * first).min(-1e-3),
            b2_per_s2: (boat.model.b2_per_s2 + of_b * along).max(1e-6),
            ..boat.model
        },
        lag_s: (boat.lag_s + later_s).max(0.0),
        disturbance_rad_s2: evidence.disturbance_rad_s2,
        ..boat
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_range_is_where_the_boats_are() {
        let range = Range::of((0..=40).map(f64::from).collect());
        assert_eq!((range.low, range.middle, range.high), (0.0, 20.0, 40.0));
    }
}
