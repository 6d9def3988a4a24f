//! The pole of the state variable filter from the data, without a constant in seconds.

use seatrial_core::YawModel;

use crate::verdict::three_figures;

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
    /// Median time from one hand of the rudder to the other, s.
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
    /// Why, in words.
    pub because: String,
}

impl ChosenLambda {
    /// Time constant 1/|a22| of the vehicle by the choice, s.
    pub fn time_constant_s(&self) -> f64 {
        LAMBDA_OVER_DAMPING / self.lambda_rad_s
    }
}

impl TimeScale {
    /// Chooses lambda: first the frequency of the rudder, pi over the half period, then 1.5 |a22| of
    /// the model that `estimate` finds with the lambda before, three times.
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
            format!(
                ", the largest that the sample interval of {} s and the rudder's half period of {} s allow",
                three_figures(self.interval_s),
                three_figures(self.half_period_s)
            )
        } else if lambda == smallest {
            format!(
                ", the smallest that the record of {} s and the rudder's half period of {} s allow",
                three_figures(self.duration_s),
                three_figures(self.half_period_s)
            )
        } else {
            String::new()
        };
        let because = match damping {
            Some(damping) => format!(
                "1.5 times |a22| = {} 1/s of a first estimate{limit}; begun at the rudder's own {} rad/s",
                three_figures(damping),
                three_figures(rudder_frequency)
            ),
            None => format!(
                "the rudder's own frequency, {} rad/s{limit}; a first estimate had no damping to go by",
                three_figures(rudder_frequency)
            ),
        };
        ChosenLambda {
            lambda_rad_s: lambda,
            because,
        }
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
        assert!(of(-100.0).because.contains("largest"));
        assert!(of(-1e-4).because.contains("smallest"));
    }

    #[test]
    fn prop_lambda_without_an_estimate_is_the_rudder_frequency() {
        let chosen = vehicle(1.0).choose_lambda(|_| None);
        assert_eq!(chosen.lambda_rad_s, std::f64::consts::PI / 2.0);
        assert!(chosen.because.contains("rudder"));
    }
}
