//! What a file states of a model and its uncertainty, before it is believed.

use seatrial::propagation::NORMAL_95;
use seatrial_core::YawModel;

/// Relative; what numbers lose in a file.
const ROUNDING: f64 = 1e-6;
/// The half width of an interval and 1.96 deviations of one estimate differ by less than this factor, also where neither is of a normal distribution.
const ALIKE: f64 = 10.0;

/// A model with its uncertainty as a document or a schedule file states it.
pub(super) struct Stated {
    pub model: YawModel<f64>,
    /// 95 % intervals of a22, b2 and C0.
    pub intervals: [Option<[f64; 2]>; 3],
    /// Covariance of [a22, b2, C0].
    pub covariance: Option<[[f64; 3]; 3]>,
}

impl Stated {
    /// What is wrong with it, where something is: an interval that does not hold its value would make a gain that allows for
    /// nothing, and a covariance that is none an interval without width.
    pub fn wrong(&self) -> Option<String> {
        let names = ["a22_per_s", "b2_per_s2", "c0_rad_per_s2"];
        let values = self.model.theta();
        for ((name, value), interval) in names.iter().zip(values).zip(self.intervals) {
            let Some([low, high]) = interval else {
                continue;
            };
            if !(low.is_finite() && high.is_finite() && low <= value && value <= high) {
                return Some(format!(
                    "the 95 % interval of {name} is [{low}, {high}]: expected the least and the greatest value, with {value} between them"
                ));
            }
        }
        let covariance = self.covariance?;
        let is_finite = covariance.iter().flatten().all(|entry| entry.is_finite());
        let variances = [covariance[0][0], covariance[1][1], covariance[2][2]];
        let is_correlated = |i: usize, j: usize| {
            let most = (variances[i] * variances[j]).sqrt() * (1.0 + ROUNDING);
            covariance[i][j].abs() <= most && covariance[j][i].abs() <= most
        };
        let is_one = is_finite
            && variances.iter().all(|variance| *variance >= 0.0)
            && [(0, 1), (0, 2), (1, 2)]
                .into_iter()
                .all(|(i, j)| is_correlated(i, j));
        if !is_one {
            return Some(format!(
                "covariance of [a22, b2, C0]: expected finite numbers with variances of at least 0 and correlations within 1, found {covariance:?}"
            ));
        }
        let apart = (0..3).find(|i| !self.belong_together(*i, variances[*i].sqrt()))?;
        Some(format!(
            "the 95 % interval of {} and its variance {} are not of one estimate: take the document as seatrial wrote it",
            names[apart], variances[apart]
        ))
    }

    /// Are an interval and a deviation those of one estimate? That of a22 may reach a damping at which a gain still holds.
    fn belong_together(&self, i: usize, deviation: f64) -> bool {
        let Some([low, high]) = self.intervals[i].filter(|_| deviation > 0.0) else {
            return true;
        };
        let (half, of_deviation) = (0.5 * (high - low), NORMAL_95 * deviation);
        of_deviation <= ALIKE * half && (i == 0 || half <= ALIKE * of_deviation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_an_interval_holds_its_value_and_a_covariance_is_one() {
        let of = |a22: [f64; 2], variance: f64| Stated {
            model: YawModel::from_theta([-1.0, 1.0, 0.0]),
            intervals: [Some(a22), None, None],
            covariance: Some([[variance, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]),
        };
        for (a22, variance) in [
            ([-1.25, -0.75], 0.1),
            ([-1.0, -1.0], 0.0),
            ([-2.5, 0.5], 0.1),
        ] {
            assert_eq!(of(a22, variance).wrong(), None, "{a22:?}");
        }
        // No estimate has both.
        assert!(of([-1.25, -0.75], 1e30).wrong().is_some());
        let (inf, nan) = (f64::INFINITY, f64::NAN);
        let none = [
            [-0.75, -1.25],
            [-0.9, -0.8],
            [-inf, 0.0],
            [-1.5, nan],
            [-1.5, inf],
        ];
        for a22 in none {
            assert!(of(a22, 0.1).wrong().is_some(), "{a22:?}");
        }
        for variance in [-0.1, nan, inf] {
            assert!(of([-1.25, -0.75], variance).wrong().is_some(), "{variance}");
        }
    }
}
