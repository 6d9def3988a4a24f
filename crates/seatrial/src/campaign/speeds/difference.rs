//! Two campaigns side by side, thrust by thrust.
//!
//! ```text
//! ratio = (B - A) / sqrt(h_A^2 + h_B^2)
//! ```
//!
//! | symbol | identifier | unit |
//! |---|---|---|
//! | A, B | `a`, `b` | that of the parameter |
//! | h | half the width of a 95 % interval | that of the parameter |
//! | ratio | `ratio` | 1 |
//!
//! Independent estimates of one and the same value have |ratio| above 1 once in twenty times, where
//! the intervals are of like shape. Without an interval on both sides there is no ratio.

use serde::Serialize;

use crate::campaign::{Campaign, Run};
use crate::identification::Identification;

/// Two campaigns at every thrust that either accepted a run at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Thrusts at which both have an accepted run.
    pub thrusts: Vec<ThrustDifference>,
    /// Thrusts at which only the first has one.
    pub only_in_a: Vec<f64>,
    /// Thrusts at which only the second has one.
    pub only_in_b: Vec<f64>,
}

/// The models of two runs at one thrust.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ThrustDifference {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Forward speed of both runs, m/s.
    pub surge_speed_m_s: [Option<f64>; 2],
    /// a22, 1/s.
    pub a22_per_s: ParameterDifference,
    /// b2, 1/s^2.
    pub b2_per_s2: ParameterDifference,
    /// C0, rad/s^2.
    pub c0_rad_per_s2: ParameterDifference,
    /// delta0, rad; `None` where either has no rudder authority.
    pub delta0_rad: Option<ParameterDifference>,
}

/// One parameter of two models.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ParameterDifference {
    /// Value of the first.
    pub a: f64,
    /// Value of the second.
    pub b: f64,
    /// B - A.
    pub difference: f64,
    /// The difference in units of the combined interval. `None` where an interval is missing.
    pub ratio: Option<f64>,
}

impl Difference {
    /// Compares the accepted runs of two campaigns.
    pub fn between(a: &Campaign, b: &Campaign) -> Self {
        let (a, b) = (models(a), models(b));
        let thrusts_missing_in = |of: &[Model], other: &[Model]| -> Vec<f64> {
            of.iter()
                .map(|model| model.run.thrust)
                .filter(|thrust| other.iter().all(|model| model.run.thrust != *thrust))
                .collect()
        };
        Self {
            only_in_a: thrusts_missing_in(&a, &b),
            only_in_b: thrusts_missing_in(&b, &a),
            thrusts: a
                .iter()
                .filter_map(|a| {
                    let b = b.iter().find(|b| b.run.thrust == a.run.thrust)?;
                    Some(ThrustDifference::between(a, b))
                })
                .collect(),
        }
    }
}

impl ThrustDifference {
    fn between(a: &Model, b: &Model) -> Self {
        let [a_theta, b_theta] = [a, b].map(|model| model.identification.model().theta());
        let [a_intervals, b_intervals] = [a, b].map(Model::intervals);
        let parameter = |k: usize| {
            ParameterDifference::between(
                (a_theta[k], a_intervals.map(|intervals| intervals[k])),
                (b_theta[k], b_intervals.map(|intervals| intervals[k])),
            )
        };
        Self {
            thrust: a.run.thrust,
            surge_speed_m_s: [a.run.surge_speed_m_s, b.run.surge_speed_m_s],
            a22_per_s: parameter(0),
            b2_per_s2: parameter(1),
            c0_rad_per_s2: parameter(2),
            delta0_rad: a.delta0().zip(b.delta0()).map(|(a, b)| ParameterDifference::between(a, b)),
        }
    }

    /// Each parameter by name.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static str, ParameterDifference)> {
        [
            ("a22", Some(self.a22_per_s)),
            ("b2", Some(self.b2_per_s2)),
            ("C0", Some(self.c0_rad_per_s2)),
            ("delta0", self.delta0_rad),
        ]
        .into_iter()
        .filter_map(|(name, parameter)| Some((name, parameter?)))
    }
}

/// A value and its 95 % interval.
type Estimate = (f64, Option<[f64; 2]>);

impl ParameterDifference {
    fn between((a, a_interval): Estimate, (b, b_interval): Estimate) -> Self {
        let half_width = |[low, high]: [f64; 2]| (high - low) / 2.0;
        let both = a_interval.zip(b_interval);
        let ratio = both.map(|(i, j)| (b - a) / libm::hypot(half_width(i), half_width(j)));
        Self { a, b, difference: b - a, ratio: ratio.filter(|ratio| ratio.is_finite()) }
    }
}

/// A run with a model.
struct Model<'a> {
    run: &'a Run,
    identification: &'a Identification,
}

impl Model<'_> {
    /// Differences of a22, b2 and C0.
    fn intervals(&self) -> Option<[[f64; 2]; 3]> {
        let refined = self.identification.refined.as_ref()?;
        let intervals = refined.interval_95;
        Some([intervals.a22_per_s, intervals.b2_per_s2, intervals.c0_rad_per_s2])
    }

    fn delta0(&self) -> Option<Estimate> {
        let refined = self.identification.refined.as_ref();
        Some((
            self.identification.model().delta0_rad()?,
            refined.and_then(|refined| refined.interval_95.delta0_rad),
        ))
    }
}

fn models(campaign: &Campaign) -> Vec<Model<'_>> {
    campaign
        .accepted_runs()
        .into_iter()
        .filter_map(|run| Some(Model { run, identification: run.identification.as_ref()? }))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_ratio_is_one_where_the_difference_is_the_combined_interval() {
        // 3-4-5: half widths 0.3 and 0.4 combine to 0.5.
        let a = (1.0, Some([0.7, 1.3]));
        let b = (1.5, Some([1.1, 1.9]));
        let difference = ParameterDifference::between(a, b);
        assert_eq!(difference.difference, 0.5);
        // Rounding of the interval ends.
        assert!((difference.ratio.unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(ParameterDifference::between(a, (1.5, None)).ratio, None);
        let point = (1.0, Some([1.0, 1.0]));
        assert_eq!(ParameterDifference::between(point, point).ratio, None);
    }
}
