//! Do validation data by themselves give another model?
//!
//! ```text
//! z = (theta' - theta) / sqrt(P' + P),   |z| and |theta'/theta - 1| beyond their limits
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | theta, P | a22 or b2 of the model that is judged and its variance, 0 where it is not known |
//! | theta', P' | the same estimated from the validation data alone |
//!
//! A good R^2 is compatible with a22 wrong by half; a model that is wrong by more than chance explains is not. A rudder
//! that saturates, or a vehicle that changed between training and validation, shows here, since the two use
//! different amplitudes. What is within the limits is left to the intervals.

use seatrial_core::YawModel;

use crate::figures::three_figures;
use crate::identification::Refined;

/// How certain and how large a difference must be, and of what.
pub(super) struct Limits {
    /// Standard deviations.
    certainty: f64,
    /// As a fraction of the parameter.
    least_difference: f64,
    /// The error that validation data should show, as a fraction of the parameter.
    error_to_show: f64,
    parameters: &'static [Parameter],
}

/// Limits for a model that is given, on data of its own amplitude: 99 % certainty, and an error of 30 % either way.
pub(super) const GIVEN: Limits = Limits {
    certainty: 2.58,
    least_difference: 0.1,
    error_to_show: 0.3 / 1.3,
    parameters: &[Parameter::Damping, Parameter::Authority],
};

/// Limits for a model just trained, on data of another amplitude: 99.9 % certainty, and only of b2, since a22 of a sound hull
/// may depend on the amplitude (the REMUS 100's by a quarter between 15 and 8.6 deg of rudder).
pub(super) const TRAINED: Limits = Limits {
    certainty: 3.29,
    least_difference: 0.3,
    error_to_show: 1.0 / 0.7 - 1.0,
    parameters: &[Parameter::Authority],
};

/// Limits for a rudder that did less per degree at the larger angle of the training, as one that stops at 0.7 of it: 99 % to that side.
pub(super) const STOPPED: Limits = Limits { certainty: 2.33, ..TRAINED };

/// Probability with which such an error should be shown: 99 %, in standard deviations.
const POWER: f64 = 2.33;

/// From a [`weakness`] of this one such error in five is missed.
pub(super) const BLIND: f64 = 1.4;

/// How many times more certain the validation data would have to be to show the error that they should. `None` where they are
/// certain enough.
///
/// ```text
/// (certainty + 2.33) sqrt(P' + P) / (error |theta|),   the largest of all parameters
/// ```
pub(super) fn weakness(
    model: &YawModel<f64>,
    covariance: Option<&[[f64; 3]; 3]>,
    other: &Refined,
    limits: &Limits,
) -> Option<f64> {
    let of = |parameter: &Parameter| {
        let i = parameter.index();
        let variance = other.covariance[i][i] + covariance.map_or(0.0, |c| c[i][i]);
        let error = limits.error_to_show * model.theta()[i].abs();
        (limits.certainty + POWER) * variance.sqrt() / error
    };
    let weakness = limits.parameters.iter().map(of).fold(0.0, f64::max);
    (weakness > 1.0).then_some(weakness)
}

/// A parameter that can be contradicted.
enum Parameter {
    /// a22.
    Damping,
    /// b2.
    Authority,
}

impl Parameter {
    /// Its place in [a22, b2, C0].
    fn index(&self) -> usize {
        match self {
            Self::Damping => 0,
            Self::Authority => 1,
        }
    }
}

/// What contradicts a model, in words.
pub(super) fn contradiction(
    model: &YawModel<f64>,
    covariance: Option<&[[f64; 3]; 3]>,
    other: &Refined,
    limits: &Limits,
) -> Option<String> {
    let found: Vec<String> = limits
        .parameters
        .iter()
        .filter_map(|parameter| {
            let i = parameter.index();
            let (name, unit) = [("a22", "1/s"), ("b2", "1/s^2")][i];
            let (given, own) = (model.theta()[i], other.model.theta()[i]);
            let variance = other.covariance[i][i] + covariance.map_or(0.0, |c| c[i][i]);
            let is_certain = (own - given).abs() > limits.certainty * variance.sqrt();
            let is_large = (own - given).abs() > limits.least_difference * given.abs();
            (is_certain && is_large).then(|| {
                format!(
                    "{name} {} ± {} {unit}, the model has {}",
                    three_figures(own),
                    three_figures(limits.certainty * variance.sqrt()),
                    three_figures(given)
                )
            })
        })
        .collect();
    (!found.is_empty()).then(|| found.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::verdict::tests::refined_at;

    #[test]
    fn exact_a_difference_counts_where_it_is_large_and_certain() {
        let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
        let contradiction = |covariance, other| contradiction(&model, covariance, other, &GIVEN);
        // Half widths of 95 % are this share of each parameter.
        let sharp = refined_at([-1.3, 1.0, 0.0], 0.1);
        let text = contradiction(None, &sharp).unwrap();
        assert!(text.contains("a22 -1.30") && !text.contains("b2"), "{text}");
        let vague = refined_at([-1.3, 1.0, 0.0], 0.5);
        assert_eq!(contradiction(None, &vague), None);
        let near = refined_at([-1.08, 1.08, 0.0], 0.01);
        assert_eq!(contradiction(None, &near), None);
        // 2.58 + 2.33 standard deviations of 0.08/1.96 are 20 %, of 0.5/1.96 they are five times 23 %.
        assert_eq!(weakness(&model, None, &refined_at([-1.0, 1.0, 0.0], 0.08), &GIVEN), None);
        let times = weakness(&model, None, &refined_at([-1.0, 1.0, 0.0], 0.5), &GIVEN).unwrap();
        assert!((times - 4.91 * 0.5 / 1.96 / (0.3 / 1.3)).abs() < 1e-9, "{times}");
        let as_unsure = [[0.04, 0.0, 0.0], [0.0, 0.04, 0.0], [0.0; 3]];
        assert_eq!(contradiction(Some(&as_unsure), &sharp), None);
    }
}
