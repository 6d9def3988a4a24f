//! Output error: the pitch model whose free simulation is closest to the record.

use nalgebra::{DMatrix, DVector};
use seatrial_core::{DivingSample, PitchModel, PitchState};
use serde::{Deserialize, Serialize};

use super::simulate;
use crate::propagation::NORMAL_95;

/// Most iterations of the search.
const ITERATIONS: usize = 60;
/// Parameters: a, m, b, c and the initial pitch and pitch rate.
const PARAMETERS: usize = 6;
/// Samples at the start whose mean is the first guess of the initial pitch.
const FIRST_SAMPLES: usize = 10;

/// A pitch model fitted to a record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// The model.
    pub model: PitchModel<f64>,
    /// 95 % intervals of a, m, b and c.
    pub interval_95: [[f64; 2]; 4],
    /// Standard deviation of what is left, rad.
    pub residual_rad: f64,
    /// Samples that one independent sample is worth, from the residual's correlation; 1 for white noise.
    pub samples_per_independent: f64,
}

/// Least squares of the free simulation, by Levenberg-Marquardt from a first model.
///
/// ```text
/// min over (a, m, b, c, theta0, q0) of sum (theta_k - theta_sim,k)^2
/// cov = kappa sigma^2 (J^T J)^-1,   kappa = 1 + 2 sum_j rho_j
/// ```
///
/// kappa, from the residual's autocorrelation rho up to where it first reaches 0, allows for
/// what the model leaves unexplained: heave, a servo, depth control. First order, and for a residual that is small
/// beside the pitch. The elevator after the doublet is that of the depth controller, which acts on measured
/// pitch: it carries the noise of the pitch sensor, which this neglects.
pub fn fit(samples: &[DivingSample<f64>], first: &PitchModel<f64>) -> Option<Fit> {
    let measured = DVector::from_iterator(samples.len(), samples.iter().map(|s| s.pitch_rad));
    let first_pitches = samples.iter().take(FIRST_SAMPLES).map(|s| s.pitch_rad);
    let start_rad = first_pitches.sum::<f64>() / FIRST_SAMPLES as f64;
    let starts = [first.theta(), [-1.0, -0.3, 1.0, 0.0]]
        .map(|theta| [theta[0], theta[1], theta[2], theta[3], start_rad, 0.0]);
    let (at, cost) = starts
        .into_iter()
        .filter_map(|start| search(samples, &measured, start))
        .min_by(|one, other| one.1.total_cmp(&other.1))?;
    let residual = &measured - simulated(samples, &at);
    let degrees = (samples.len() - PARAMETERS) as f64;
    let variance = cost / degrees;
    let jacobian = sensitivities(samples, &at);
    let covariance = (jacobian.transpose() * &jacobian).try_inverse()?;
    let kappa = samples_per_independent(residual.as_slice());
    let interval = |i: usize| {
        let half_width = NORMAL_95 * (kappa * variance * covariance[(i, i)]).sqrt();
        [at[i] - half_width, at[i] + half_width]
    };
    let interval_95 = [0, 1, 2, 3].map(interval);
    let finite = interval_95.iter().flatten().all(|bound| bound.is_finite());
    finite.then_some(Fit {
        model: model_of(&at),
        interval_95,
        residual_rad: variance.sqrt(),
        samples_per_independent: kappa,
    })
}

/// R^2 of a model's pitch on validation data, with its offset and the start estimated again.
pub(super) fn r2(samples: &[DivingSample<f64>], model: &PitchModel<f64>) -> Option<f64> {
    let measured = DVector::from_iterator(samples.len(), samples.iter().map(|s| s.pitch_rad));
    let [a, m, b, c] = model.theta();
    let start = [a, m, b, c, measured[0], 0.0];
    let zero = simulated(samples, &start);
    // Pitch is linear in offset and start.
    let all = sensitivities(samples, &start);
    let free = all.columns(3, 3).into_owned();
    let normal = (free.transpose() * &free).try_inverse()?;
    let residual = &measured - zero;
    let left = &residual - &free * (normal * (free.transpose() * &residual));
    let spread = measured.add_scalar(-measured.mean());
    Some(1.0 - left.norm_squared() / spread.norm_squared())
}

type Parameters = [f64; PARAMETERS];

fn model_of(at: &Parameters) -> PitchModel<f64> {
    PitchModel::from_theta([at[0], at[1], at[2], at[3]])
}

fn simulated(samples: &[DivingSample<f64>], at: &Parameters) -> DVector<f64> {
    let start = PitchState {
        pitch_rad: at[4],
        pitch_rate_rad_s: at[5],
    };
    DVector::from_vec(simulate(&model_of(at), start, samples))
}

/// d theta_sim / d parameter, by central differences.
fn sensitivities(samples: &[DivingSample<f64>], at: &Parameters) -> DMatrix<f64> {
    let columns = (0..PARAMETERS).map(|i| {
        let step = 1e-5 * at[i].abs().max(0.1);
        let shifted = |by: f64| {
            let mut moved = *at;
            moved[i] += by;
            simulated(samples, &moved)
        };
        (shifted(step) - shifted(-step)) / (2.0 * step)
    });
    DMatrix::from_columns(&columns.collect::<Vec<_>>())
}

fn search(
    samples: &[DivingSample<f64>],
    measured: &DVector<f64>,
    start: Parameters,
) -> Option<(Parameters, f64)> {
    let cost_of = |at: &Parameters| (measured - simulated(samples, at)).norm_squared();
    let mut at = start;
    let mut cost = cost_of(&at);
    let mut damping = 1e-2;
    for _ in 0..ITERATIONS {
        let jacobian = sensitivities(samples, &at);
        let gradient = jacobian.transpose() * (measured - simulated(samples, &at));
        let mut normal = jacobian.transpose() * &jacobian;
        for i in 0..PARAMETERS {
            normal[(i, i)] *= 1.0 + damping;
        }
        let step = normal.try_inverse()? * gradient;
        let mut tried = at;
        for (value, change) in tried.iter_mut().zip(step.iter()) {
            *value += change;
        }
        let tried_cost = cost_of(&tried);
        if tried_cost < cost {
            let gained = (cost - tried_cost) / cost;
            (at, cost) = (tried, tried_cost);
            damping *= 0.1;
            if gained < 1e-10 {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e8 {
                break;
            }
        }
    }
    cost.is_finite().then_some((at, cost))
}

fn samples_per_independent(residual: &[f64]) -> f64 {
    let total: f64 = residual.iter().map(|e| e * e).sum();
    let correlation = |lag: usize| -> f64 {
        let pairs = residual.iter().zip(&residual[lag..]);
        pairs.map(|(a, b)| a * b).sum::<f64>() / total
    };
    let positive = (1..residual.len() / 4)
        .map(correlation)
        .take_while(|rho| *rho > 0.0);
    1.0 + 2.0 * positive.sum::<f64>()
}
