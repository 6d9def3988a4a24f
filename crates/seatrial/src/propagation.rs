//! The uncertainty of a model carried through to what is computed from it.

use nalgebra::{Matrix3, Vector3};
use seatrial_core::YawModel;

use crate::draw::Draw;

/// Two-sided 95 % point of the normal distribution: the half width of a 95 % interval in standard deviations.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// The 95 % interval of a quantity computed from a model, by the delta method.
///
/// ```text
/// var f = grad f^T C grad f,   f +- 1.96 sqrt(var f)
/// ```
///
/// with C the covariance of [a22, b2, C0] and the gradient by central differences over a hundredth
/// of each standard deviation. First order: right as long as the quantity is nearly linear over the
/// interval of the parameters. `None` where the quantity does not exist at or next to the estimate.
///
/// ```
/// use seatrial::identification::interval_95;
/// use seatrial_core::YawModel;
///
/// let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
/// let covariance = [[0.0025, 0.0, 0.0], [0.0; 3], [0.0; 3]];
/// // T = -1/a22 with a deviation of 0.05 1/s in a22: 0.05 s in T.
/// let interval = interval_95(&model, &covariance, |model| Some(-1.0 / model.a22_per_s));
/// assert!(interval.is_some_and(|[low, high]| (high - low - 2.0 * 1.96 * 0.05).abs() < 1e-3));
/// ```
pub fn interval_95(
    model: &YawModel<f64>,
    covariance: &[[f64; 3]; 3],
    quantity: impl Fn(&YawModel<f64>) -> Option<f64>,
) -> Option<[f64; 2]> {
    let centre = quantity(model)?;
    let theta = model.theta();
    let mut gradient = [0.0; 3];
    for i in 0..3 {
        let step = 0.01 * covariance[i][i].sqrt();
        if step == 0.0 {
            continue;
        }
        let shifted = |by: f64| {
            let mut theta = theta;
            theta[i] += by;
            quantity(&YawModel::from_theta(theta))
        };
        gradient[i] = (shifted(step)? - shifted(-step)?) / (2.0 * step);
    }
    let variance: f64 = (0..3)
        .flat_map(|i| (0..3).map(move |j| (i, j)))
        .map(|(i, j)| gradient[i] * covariance[i][j] * gradient[j])
        .sum();
    let half_width = NORMAL_95 * variance.sqrt();
    half_width.is_finite().then_some([centre - half_width, centre + half_width])
}

/// The covariance that independent 95 % intervals of a22, b2 and C0 stand for: correlations unknown.
///
/// ```
/// use seatrial::identification::covariance_of_intervals;
///
/// // Half a width of 1.96 deviations.
/// let covariance = covariance_of_intervals([[-1.196, -0.804], [0.9, 1.1], [-0.01, 0.01]]);
/// assert!((covariance[0][0] - 0.01).abs() < 1e-5);
/// assert_eq!(covariance[0][1], 0.0);
/// ```
pub fn covariance_of_intervals(intervals: [[f64; 2]; 3]) -> [[f64; 3]; 3] {
    let mut covariance = [[0.0; 3]; 3];
    for (i, [low, high]) in intervals.into_iter().enumerate() {
        let standard_deviation = (high - low) / (2.0 * NORMAL_95);
        covariance[i][i] = standard_deviation * standard_deviation;
    }
    covariance
}

/// Deviation of ln |K| beyond which how tight a long turn gets is not known.
const MOST_OPEN: f64 = 0.3;

/// The first-order model with the steady turn of the hypotheses that explain its record, and its covariance, by mean and variance of ln |K|,
/// K in 1/s:
///
/// ```text
/// a22 = -|b2|/K,   var a22 = a22^2 (var ln K + var b2/b2^2)
/// ```
///
/// `None` where the hypotheses leave the turn open: a deviation of ln |K| over 0.3.
///
/// ```
/// use seatrial::identification::with_steady_gain;
/// use seatrial_core::YawModel;
///
/// let model = YawModel::from_theta([-1.0, 0.5, 0.0]);
/// let (turning, _) = with_steady_gain(&model, &[[0.0; 3]; 3], [0.8_f64.ln(), 0.0025]).unwrap();
/// assert!((turning.a22_per_s + 0.625).abs() < 1e-12);
/// ```
pub fn with_steady_gain(
    model: &YawModel<f64>,
    covariance: &[[f64; 3]; 3],
    log_gain: [f64; 2],
) -> Option<(YawModel<f64>, [[f64; 3]; 3])> {
    let [mean, variance] = log_gain;
    if variance.is_nan() || variance > MOST_OPEN * MOST_OPEN {
        return None;
    }
    let [_, b2, c0] = model.theta();
    let share = -b2.signum() * libm::exp(-mean);
    let of = covariance;
    let a22_by_b2 = [share * share * of[1][1], share * of[1][1], share * of[1][2]];
    let mut covariance = *of;
    covariance[0] = a22_by_b2;
    covariance[0][0] += (share * b2).powi(2) * variance;
    (covariance[1][0], covariance[2][0]) = (a22_by_b2[1], a22_by_b2[2]);
    Some((YawModel::from_theta([share * b2, b2, c0]), covariance))
}

/// Models that data do not tell apart: ln a22, ln b2 and C0 are drawn from a normal distribution, which is wider on the side of less damping
/// where the 95 % interval is: its end is `least_damped_per_s`, 1/s. Damping keeps its sign: a vehicle that is not course-stable is another
/// hypothesis. `None` where the covariance is none, or the interval leaves no damping.
///
/// ```
/// use seatrial::identification::drawn;
/// use seatrial_core::YawModel;
///
/// let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
/// let covariance = [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 1e-4]];
/// let boats = drawn(&model, &covariance, -0.8, 400).ok_or("an interval that leaves damping")?;
/// // Damping keeps its sign, and 97.5 % of the boats are damped by more than 0.8 1/s.
/// assert!(boats.iter().all(|boat| boat.a22_per_s < 0.0));
/// assert!(boats.iter().filter(|boat| boat.a22_per_s > -0.8).count() < 20);
/// assert_eq!(drawn(&model, &covariance, 0.1, 400), None);
/// # Ok::<(), &str>(())
/// ```
pub fn drawn(
    model: &YawModel<f64>,
    covariance: &[[f64; 3]; 3],
    least_damped_per_s: f64,
    count: usize,
) -> Option<Vec<YawModel<f64>>> {
    let [a22, b2, c0] = model.theta();
    let relative = Matrix3::from_diagonal(&Vector3::new(1.0 / a22, 1.0 / b2, 1.0));
    let covariance = relative * Matrix3::from(*covariance) * relative;
    let less_damped = -libm::log(least_damped_per_s / a22);
    if !less_damped.is_finite() {
        return None;
    }
    // A parameter that is known exactly leaves no factor of Cholesky.
    let least = Matrix3::from_diagonal(&covariance.diagonal().map(|v| 1e-12 * v + 1e-30));
    let factor = (covariance + least).cholesky()?.l();
    let deviation = covariance[(0, 0)].sqrt();
    let wider = match deviation > 0.0 {
        true => (less_damped / (NORMAL_95 * deviation)).max(1.0),
        false => 1.0,
    };
    let mut draw = Draw::new(1);
    let one = |_| {
        let mut by = factor * Vector3::from_fn(|_, _| draw.normal());
        if by[0] < 0.0 {
            by[0] *= wider;
        }
        YawModel::from_theta([a22 * libm::exp(by[0]), b2 * libm::exp(by[1]), c0 + by[2]])
    };
    Some((0..count).map(one).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_linear_quantity_and_round_trip_of_intervals() {
        let model = YawModel::from_theta([-1.0, 2.0, 0.1]);
        let covariance = covariance_of_intervals([[-1.2, -0.8], [1.7, 2.3], [0.0, 0.2]]);
        let interval = interval_95(&model, &covariance, |m| Some(m.b2_per_s2)).unwrap();
        // Rounding of the difference quotient, 1e-16 over a step of 1e-3.
        assert!((interval[0] - 1.7).abs() < 1e-12 && (interval[1] - 2.3).abs() < 1e-12);
        let sum = interval_95(&model, &covariance, |m| Some(m.a22_per_s + m.b2_per_s2)).unwrap();
        let half_width = (0.2_f64.powi(2) + 0.3_f64.powi(2)).sqrt();
        assert!((sum[1] - 1.0 - half_width).abs() < 1e-12);
        assert_eq!(interval_95(&model, &covariance, |_| None), None);
    }

    /// a22 and b2 that err together leave K = -b2/a22 alone.
    #[test]
    fn exact_correlation_counts() {
        let model = YawModel::from_theta([-1.0, 2.0, 0.0]);
        let covariance = [[0.01, -0.02, 0.0], [-0.02, 0.04, 0.0], [0.0; 3]];
        let gain = |m: &YawModel<f64>| m.nomoto().map(|n| n.k_per_s);
        let [low, high] = interval_95(&model, &covariance, gain).unwrap();
        // The difference quotient errs in the second order of the step, 1e-3.
        assert!(high - low < 1e-5);
    }
}
