//! Models of one hull at several turn rates: how its damping grows with the yaw rate.
//!
//! ```text
//! r' = a22_0 r + a_rr |r| r + b2 delta + C0                 a hull with cross-flow damping
//! a22(A) = a22_0 + 8/(3 pi) a_rr A                          what a first-order model sees of it
//! A = 3 pi/8 E|r|^3 / E r^2                                 the amplitude of a record
//! (p - p_i)^T C_i^-1 (p - p_i), summed over i, least        p_i = [a22_i, b2_i], p = [a22(A_i), b2]
//! chi^2 of 2 n - 3 degrees of freedom
//! ```
//!
//! | symbol | identifier | unit |
//! |---|---|---|
//! | A | `yaw_rate_amplitude_rad_s` | rad/s |
//! | a22_0 | `a22_at_rest_per_s` | 1/s |
//! | a_rr | `quadratic_per_rad` | 1/rad |
//! | b2 | `b2_per_s2` | 1/s^2 |
//! | C_i | `covariance` | those of its model |
//! | chi^2 | `chi_squared` | 1 |
//! | n | `models` | 1 |
//!
//! E f(r) r / E r^2 is the linear gain that misses f(r) least in the mean square (A. Gelb, W. E. Vander Velde, *Multiple-Input
//! Describing Functions and Nonlinear System Design*, McGraw-Hill 1968). For f = |r| r it is E|r|^3 / E r^2, of a sine of amplitude A
//! 8/(3 pi) A: that is what A stands for here, whatever the yaw rate's shape, and a rest before a manoeuvre does not lower it.
//! Zig-zags of several amplitudes were read like this by N. H. Norrbin (*On the Design and Analysis of the Zig-Zag Test on Base of
//! Quasi-Linear Frequency Response*, SSPA report B 104-3, 1963).
//!
//! Valid for one speed, within the amplitudes that were seen, for manoeuvres of like shape. Where chi^2 is beyond what 95 % allow, the
//! models differ by more than amplitude explains: the covariance is then multiplied by chi^2 per degree of freedom and the intervals
//! are Student's. Amplitudes that are all alike, within [`LEAST_SPREAD`], tell no a_rr; one model is then fitted to all.
//!
//! The models' covariances hold what their records share, too: what is not known of the rudder's timing, and the error of a
//! first-order model. Repeats of one condition therefore differ less than chi^2 allows, and it finds a contradiction late rather than
//! early.
//!
//! The quadratic damping of [`likelihood`](crate::likelihood) is of one record; here there are several first-order models.

mod fit;
#[cfg(test)]
mod tests;
mod words;

use core::f64::consts::PI;

use seatrial_core::{Sample, YawModel};
use serde::Serialize;

use crate::identification::{EstimateMethod, Refined};
use crate::identify::validation::derived_yaw_rate;

/// The largest amplitude is at least so many times the least where they tell a_rr.
pub const LEAST_SPREAD: f64 = 1.2;

/// A first-order model and the turn rate that it was seen at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenModel {
    /// Amplitude of the yaw rate, rad/s.
    pub yaw_rate_amplitude_rad_s: f64,
    /// a22, 1/s.
    pub a22_per_s: f64,
    /// b2, 1/s^2 for each unit of the rudder.
    pub b2_per_s2: f64,
    /// Covariance of [a22, b2].
    pub covariance: [[f64; 2]; 2],
}

impl SeenModel {
    /// A refined model seen at this amplitude.
    pub fn of(refined: &Refined, yaw_rate_amplitude_rad_s: f64) -> Self {
        let [[aa, ab, _], [ba, bb, _], _] = refined.covariance;
        Self {
            yaw_rate_amplitude_rad_s,
            a22_per_s: refined.model.a22_per_s,
            b2_per_s2: refined.model.b2_per_s2,
            covariance: [[aa, ab], [ba, bb]],
        }
    }
}

/// What the models say together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Finding {
    /// Damping grows with the turn rate.
    Grows,
    /// Damping falls with the turn rate.
    Falls,
    /// One model serves all of them, within their intervals.
    Agree,
    /// They differ by more than amplitude explains.
    Differ,
}

/// A value with its 95 % interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ValueInterval {
    /// The value.
    pub value: f64,
    /// Its interval.
    pub interval_95: [f64; 2],
}

impl ValueInterval {
    /// Is zero outside the interval?
    pub fn excludes_zero(&self) -> bool {
        let [low, high] = self.interval_95;
        low > 0.0 || high < 0.0
    }
}

/// The quasi-linear model over the amplitude of the yaw rate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OverAmplitude {
    /// What the models say together.
    pub finding: Finding,
    /// How many models.
    pub models: usize,
    /// Least and greatest amplitude of the yaw rate, rad/s.
    pub seen_rad_s: [f64; 2],
    /// a22_0, 1/s: at no turn rate, or at every one where there is no a_rr.
    pub a22_at_rest_per_s: ValueInterval,
    /// a_rr, 1/rad. `None` where the amplitudes are alike.
    pub quadratic_per_rad: Option<ValueInterval>,
    /// b2, 1/s^2 for each unit of the rudder.
    pub b2_per_s2: ValueInterval,
    /// Quasi-linear a22 at the least and the greatest amplitude, 1/s.
    pub a22_at_seen_per_s: [ValueInterval; 2],
    /// Sum of the squared differences, each in its standard deviations.
    pub chi_squared: f64,
    /// Within which it is 95 times in 100.
    pub chi_squared_95: [f64; 2],
    /// Differences less parameters.
    pub degrees_of_freedom: usize,
    /// Covariance of [a22_0, a_rr, b2], widened where chi^2 asks for it.
    #[serde(skip)]
    covariance: [[f64; 3]; 3],
    /// Half the width of a 95 % interval in standard deviations.
    #[serde(skip)]
    deviations: f64,
}

/// The amplitude at which a refined model was seen over the parts of a record, rad/s.
///
/// A model of [weighed hypotheses](EstimateMethod::WeighedHypotheses) has the vehicle's steady turn at an angle of the rudder, and its
/// damping is that of this turn: a22 = a22_0 + a_rr |r|, so that A = 3 pi/8 |r|. Any other is seen at [`yaw_rate_amplitude_rad_s`].
pub fn seen_amplitude_rad_s(
    refined: &Refined,
    rudder_amplitude: f64,
    parts: &[&[Sample<f64>]],
) -> Option<f64> {
    let model = refined.model;
    match refined.method {
        EstimateMethod::WeighedHypotheses => {
            Some(3.0 * PI / 8.0 * (model.b2_per_s2 / model.a22_per_s * rudder_amplitude).abs())
        }
        _ => yaw_rate_amplitude_rad_s(model, parts),
    }
}

/// The amplitude of the yaw rate over the parts of a record, rad/s: that of the sine with the same quadratic damping. The yaw rate is the
/// derivative of the heading, smoothed as long as the model's time constant allows. `None` where no part has a rate.
pub fn yaw_rate_amplitude_rad_s(model: YawModel<f64>, parts: &[&[Sample<f64>]]) -> Option<f64> {
    let with_rate = parts.iter().filter_map(|part| derived_yaw_rate(model, part));
    let rates = with_rate.flat_map(|part| part.into_iter().filter_map(|s| s.yaw_rate_rad_s));
    let [squares, cubes] = rates.fold([0.0; 2], |[squares, cubes], rate| {
        let square = rate * rate;
        [squares + square, cubes + square * rate.abs()]
    });
    let amplitude = 3.0 * PI / 8.0 * cubes / squares;
    amplitude.is_finite().then_some(amplitude)
}
