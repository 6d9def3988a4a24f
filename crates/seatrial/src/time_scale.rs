//! The pole of the state variable filter from the data, without a constant in seconds.

use std::fmt;

use seatrial_core::YawModel;
use serde::{Deserialize, Serialize};

use crate::figures::three_figures;

/// lambda over the vehicle's own |a22|: at the paper's vehicle this is lambda 1.5 rad/s, where the
/// recursive instrumental variable has its best efficiency.
const LAMBDA_OVER_DAMPING: f64 = 1.5;

/// The filter must be slow against the sampling: beyond lambda h = 0.3 the hold on the heading biases
/// the estimate.
const LARGEST_LAMBDA_TIMES_INTERVAL: f64 = 0.3;

/// The filter must forget within the record: it needs some six time constants for that.
const SMALLEST_LAMBDA_TIMES_DURATION: f64 = 6.0;

/// Beyond this factor from the frequency of the rudder there is nothing to be seen.
const LARGEST_FACTOR_FROM_RUDDER: f64 = 5.0;

/// Passes after the first; the change is under a few per cent after two.
const PASSES: usize = 3;

/// What the choice of lambda can go by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeScale {
    /// Median time from one side of the rudder to the other, s.
    pub half_period_s: f64,
    /// Median interval between samples, s.
    pub interval_s: f64,
    /// From the first sample to the last, s.
    pub duration_s: f64,
}

/// A filter pole and the reason for it.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenLambda {
    /// Pole of the state variable filter, rad/s.
    pub lambda_rad_s: f64,
    /// How it was chosen.
    pub because: LambdaReason,
}

/// Why a filter has its pole. Documents hold it in words.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(into = "String", from = "String")]
#[non_exhaustive]
pub enum LambdaReason {
    /// The caller gave it.
    Given,
    /// It is the paper's.
    Paper,
    /// It follows from the doublet of the plan.
    PlansDoublet,
    /// 1.5 |a22| of a first estimate.
    FirstEstimate {
        /// |a22|, 1/s.
        damping_per_s: f64,
        /// The first lambda tried, rad/s.
        rudder_frequency_rad_s: f64,
        /// What kept it from 1.5 |a22|.
        limit: Option<LambdaLimit>,
    },
    /// The rudder's own frequency: no estimate had a damping.
    RudderFrequency {
        /// The frequency, rad/s.
        rudder_frequency_rad_s: f64,
        /// What kept lambda from it.
        limit: Option<LambdaLimit>,
    },
    /// A reason read from a document, in its words.
    Recorded(String),
}

/// What keeps lambda from the vehicle's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LambdaLimit {
    /// The largest that sampling and rudder allow.
    Largest(TimeScale),
    /// The smallest that record and rudder allow.
    Smallest(TimeScale),
}

impl fmt::Display for LambdaLimit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Largest(scale) => write!(
                f,
                ", the largest that the sample interval of {} s and the rudder's half period of {} s allow",
                three_figures(scale.interval_s),
                three_figures(scale.half_period_s)
            ),
            Self::Smallest(scale) => write!(
                f,
                ", the smallest that the record of {} s and the rudder's half period of {} s allow",
                three_figures(scale.duration_s),
                three_figures(scale.half_period_s)
            ),
        }
    }
}

impl fmt::Display for LambdaReason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let text = |limit: &Option<LambdaLimit>| limit.map_or_else(String::new, |l| l.to_string());
        match self {
            Self::Given => f.write_str("given"),
            Self::Paper => f.write_str("the paper's"),
            Self::PlansDoublet => f.write_str("from the plan's doublet"),
            Self::FirstEstimate { damping_per_s, rudder_frequency_rad_s, limit } => write!(
                f,
                "1.5 times |a22| = {} 1/s of a first estimate{}; begun at the rudder's own {} rad/s",
                three_figures(*damping_per_s),
                text(limit),
                three_figures(*rudder_frequency_rad_s)
            ),
            Self::RudderFrequency { rudder_frequency_rad_s, limit } => write!(
                f,
                "the rudder's own frequency, {} rad/s{}; a first estimate had no damping to go by",
                three_figures(*rudder_frequency_rad_s),
                text(limit)
            ),
            Self::Recorded(text) => f.write_str(text),
        }
    }
}

impl From<String> for LambdaReason {
    fn from(text: String) -> Self {
        let plain = [Self::Given, Self::Paper, Self::PlansDoublet];
        let known = plain.into_iter().find(|reason| reason.to_string() == text);
        known.unwrap_or(Self::Recorded(text))
    }
}

impl From<LambdaReason> for String {
    fn from(reason: LambdaReason) -> Self {
        reason.to_string()
    }
}

/// Two reasons are equal where they read the same, since a document keeps their words only.
impl PartialEq for LambdaReason {
    fn eq(&self, other: &Self) -> bool {
        self.to_string() == other.to_string()
    }
}

impl ChosenLambda {
    /// Time constant 1/|a22| of the vehicle by the choice, s.
    ///
    /// ```
    /// use seatrial::log::{ChosenLambda, LambdaReason};
    ///
    /// let chosen = ChosenLambda { lambda_rad_s: 0.3, because: LambdaReason::Given };
    /// // 1.5 over lambda.
    /// assert!((chosen.time_constant_s() - 5.0).abs() < 1e-12);
    /// ```
    pub fn time_constant_s(&self) -> f64 {
        LAMBDA_OVER_DAMPING / self.lambda_rad_s
    }
}

impl TimeScale {
    /// Chooses lambda: first the frequency of the rudder, pi over the half period, then 1.5 |a22| of
    /// the model that `estimate` finds with the lambda before, three times.
    ///
    /// ```
    /// use seatrial::log::TimeScale;
    /// use seatrial_core::YawModel;
    ///
    /// let scale = TimeScale { half_period_s: 2.0, interval_s: 0.05, duration_s: 16.0 };
    /// // 1.5 |a22| of what every estimate finds.
    /// let chosen = scale.choose_lambda(|_| Some(YawModel::from_theta([-1.0, 1.0, 0.0])));
    /// assert!((chosen.lambda_rad_s - 1.5).abs() < 1e-12);
    /// // Without any, the frequency of the rudder: pi over 2 s.
    /// assert!((scale.choose_lambda(|_| None).lambda_rad_s - 1.571).abs() < 1e-3);
    /// ```
    pub fn choose_lambda(
        &self,
        mut estimate: impl FnMut(f64) -> Option<YawModel<f64>>,
    ) -> ChosenLambda {
        let rudder_frequency = std::f64::consts::PI / self.half_period_s;
        let largest = (LARGEST_LAMBDA_TIMES_INTERVAL / self.interval_s)
            .min(rudder_frequency * LARGEST_FACTOR_FROM_RUDDER);
        let smallest = (SMALLEST_LAMBDA_TIMES_DURATION / self.duration_s)
            .max(rudder_frequency / LARGEST_FACTOR_FROM_RUDDER)
            .min(largest);
        let mut lambda = rudder_frequency.clamp(smallest, largest);
        let mut damping = None;
        for _ in 0..PASSES {
            let Some(model) = estimate(lambda).filter(|m| m.a22_per_s < 0.0) else {
                break;
            };
            damping = Some(-model.a22_per_s);
            lambda = (-model.a22_per_s * LAMBDA_OVER_DAMPING).clamp(smallest, largest);
        }
        let limit = if lambda == largest {
            Some(LambdaLimit::Largest(*self))
        } else {
            (lambda == smallest).then_some(LambdaLimit::Smallest(*self))
        };
        let because = match damping {
            Some(damping_per_s) => LambdaReason::FirstEstimate {
                damping_per_s,
                rudder_frequency_rad_s: rudder_frequency,
                limit,
            },
            None => {
                LambdaReason::RudderFrequency { rudder_frequency_rad_s: rudder_frequency, limit }
            }
        };
        ChosenLambda { lambda_rad_s: lambda, because }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vehicle(time_constant_s: f64) -> TimeScale {
        TimeScale {
            half_period_s: 2.0 * time_constant_s,
            interval_s: 0.05 * time_constant_s,
            duration_s: 16.5 * time_constant_s,
        }
    }

    #[test]
    fn prop_lambda_scales_with_the_vehicle() {
        for time_constant_s in [0.25, 0.93, 11.0, 100.0] {
            let a22 = -1.0 / time_constant_s;
            let chosen = vehicle(time_constant_s)
                .choose_lambda(|_| Some(YawModel::from_theta([a22, 1.0, 0.0])));
            // Products of the same few numbers.
            assert!((chosen.lambda_rad_s * time_constant_s - 1.5).abs() < 1e-12);
        }
    }

    #[test]
    fn prop_lambda_stays_within_its_limits() {
        let scale = vehicle(1.0);
        let of = |a22: f64| scale.choose_lambda(|_| Some(YawModel::from_theta([a22, 1.0, 0.0])));
        // 0.3 / 0.05 s, and 6 / 16.5 s.
        assert_eq!(of(-100.0).lambda_rad_s, 0.3 / 0.05);
        assert_eq!(of(-1e-4).lambda_rad_s, 6.0 / 16.5);
        assert!(of(-100.0).because.to_string().contains("largest"));
        assert!(of(-1e-4).because.to_string().contains("smallest"));
    }

    #[test]
    fn prop_lambda_without_an_estimate_is_the_rudder_frequency() {
        let chosen = vehicle(1.0).choose_lambda(|_| None);
        assert_eq!(chosen.lambda_rad_s, std::f64::consts::PI / 2.0);
        assert!(chosen.because.to_string().contains("rudder"));
    }
}
