//! Output error: the pitch model whose free simulation is closest to the record.

use nalgebra::{DMatrix, DVector};
use seatrial_core::{PitchModel, PitchState, Sample};

use crate::identification::{EstimateMethod, Intervals, Refined, Restoring};
use crate::propagation::NORMAL_95;

/// Most iterations of the search.
const ITERATIONS: usize = 60;
/// Parameters: a, m, b, c and the initial pitch and pitch rate.
const PARAMETERS: usize = 6;
/// Samples at the start whose mean is the first guess of the initial pitch.
const FIRST_SAMPLES: usize = 10;

/// A pitch model fitted to a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The model.
    pub model: PitchModel<f64>,
    /// 95 % intervals of a, m, b and c.
    pub interval_95: [[f64; 2]; 4],
    /// Covariance of a, m, b and c.
    pub covariance: [[f64; 4]; 4],
    /// Standard deviation of what is left, rad.
    pub residual_rad: f64,
}

impl Fit {
    /// The estimate of a, b and c.
    pub fn refined(&self) -> Refined {
        const KEPT: [usize; 3] = [0, 2, 3];
        let model = self.model.without_restoring();
        let [a22_per_s, _, b2_per_s2, c0_rad_per_s2] = self.interval_95;
        Refined {
            method: EstimateMethod::OutputError,
            model,
            delta0_rad: model.delta0_rad(),
            interval_95: Intervals {
                a22_per_s,
                b2_per_s2,
                c0_rad_per_s2,
                delta0_rad: self.delta0_interval_rad(),
            },
            covariance: KEPT.map(|row| KEPT.map(|column| self.covariance[row][column])),
            heading_noise_rad: self.residual_rad,
            disturbance_rad_s2: 0.0,
        }
    }

    /// The estimate of m beside that of the online estimator, 1/s^2.
    pub fn restoring(&self, online_per_s2: f64) -> Restoring {
        let [_, interval_95_per_s2, ..] = self.interval_95;
        Restoring { online_per_s2, refined_per_s2: self.model.restoring_per_s2, interval_95_per_s2 }
    }

    /// 95 % of c/b to first order, rad; `None` where b may be 0.
    fn delta0_interval_rad(&self) -> Option<[f64; 2]> {
        if self.authority_may_be_zero() {
            return None;
        }
        let (b, c) = (self.model.authority_per_s2, self.model.offset_rad_per_s2);
        let slopes = [0.0, 0.0, -c / (b * b), 1.0 / b];
        let rows = self.covariance.iter().zip(slopes);
        let variance: f64 = rows
            .map(|(row, left)| {
                row.iter().zip(slopes).map(|(cov, right)| left * cov * right).sum::<f64>()
            })
            .sum();
        let half_width = NORMAL_95 * variance.sqrt();
        Some([c / b - half_width, c / b + half_width])
    }

    /// Does the 95 % interval of b hold 0?
    pub fn authority_may_be_zero(&self) -> bool {
        let [_, _, [low, high], _] = self.interval_95;
        low <= 0.0 && high >= 0.0
    }
}

/// Least squares of the free simulation, by Levenberg-Marquardt from a first model. The heading of the samples is the pitch,
/// their rudder the elevator.
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
///
/// ```
/// use seatrial::Sample;
/// use seatrial::motions::pitch::{fit, simulate};
/// use seatrial_core::{PitchModel, PitchState};
///
/// let rudder_rad = |k| match k {
///     20..60 => 0.15,
///     60..100 => -0.15,
///     _ => 0.0,
/// };
/// let mut samples: Vec<_> = (0..240)
///     .map(|k| Sample { time_s: 0.05 * f64::from(k), rudder_rad: rudder_rad(k), ..Sample::default() })
///     .collect();
/// let truth = PitchModel::from_theta([-1.2, -0.4, 0.8, 0.0]);
/// let pitch_rad = simulate(&truth, PitchState::default(), &samples);
/// for (sample, pitch_rad) in samples.iter_mut().zip(pitch_rad) {
///     sample.heading_rad = (1e4 * pitch_rad).round() / 1e4;
/// }
/// let found = fit(&samples, &PitchModel::from_theta([-1.0, -0.3, 1.0, 0.0])).ok_or("excited")?;
/// assert!((found.model.restoring_per_s2 + 0.4).abs() < 0.01);
/// assert!(!found.authority_may_be_zero());
/// # Ok::<(), &str>(())
/// ```
pub fn fit(samples: &[Sample<f64>], first: &PitchModel<f64>) -> Option<Fit> {
    let measured = DVector::from_iterator(samples.len(), samples.iter().map(|s| s.heading_rad));
    let first_pitches = samples.iter().take(FIRST_SAMPLES).map(|s| s.heading_rad);
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
    let inverse = (jacobian.transpose() * &jacobian).try_inverse()?;
    let kappa = samples_per_independent(residual.as_slice());
    let covariance = [0, 1, 2, 3]
        .map(|row| [0, 1, 2, 3].map(|column| kappa * variance * inverse[(row, column)]));
    let interval = |i: usize| {
        let half_width = NORMAL_95 * covariance[i][i].sqrt();
        [at[i] - half_width, at[i] + half_width]
    };
    let interval_95 = [0, 1, 2, 3].map(interval);
    let finite = interval_95.iter().flatten().all(|bound| bound.is_finite());
    finite.then_some(Fit {
        model: model_of(&at),
        interval_95,
        covariance,
        residual_rad: variance.sqrt(),
    })
}

type Parameters = [f64; PARAMETERS];

fn model_of(at: &Parameters) -> PitchModel<f64> {
    PitchModel::from_theta([at[0], at[1], at[2], at[3]])
}

fn simulated(samples: &[Sample<f64>], at: &Parameters) -> DVector<f64> {
    let start = PitchState { pitch_rad: at[4], pitch_rate_rad_s: at[5] };
    DVector::from_vec(simulate(&model_of(at), start, samples))
}

/// The pitch that a model gives at each sample, from the elevator alone, rad.
///
/// ```
/// use seatrial::Sample;
/// use seatrial::motions::pitch::simulate;
/// use seatrial_core::{PitchModel, PitchState};
///
/// // An elevator of 0.1 rad ends at a pitch of -b delta/m.
/// let samples: Vec<_> = (0..600)
///     .map(|k| Sample { time_s: 0.1 * f64::from(k), rudder_rad: 0.1, ..Sample::default() })
///     .collect();
/// let model = PitchModel::from_theta([-1.2, -0.4, 0.8, 0.0]);
/// let pitch_rad = simulate(&model, PitchState::default(), &samples);
/// assert!((pitch_rad[599] - 0.2).abs() < 1e-6);
/// ```
pub fn simulate(
    model: &PitchModel<f64>,
    start: PitchState<f64>,
    samples: &[Sample<f64>],
) -> Vec<f64> {
    let mut state = start;
    let mut pitches = vec![start.pitch_rad];
    for pair in samples.windows(2) {
        let interval_s = pair[1].time_s - pair[0].time_s;
        state = model.advance(state, pair[0].rudder_rad, interval_s);
        pitches.push(state.pitch_rad);
    }
    pitches
}

/// d theta_sim / d parameter, by central differences.
fn sensitivities(samples: &[Sample<f64>], at: &Parameters) -> DMatrix<f64> {
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
    samples: &[Sample<f64>],
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
    let positive = (1..residual.len() / 4).map(correlation).take_while(|rho| *rho > 0.0);
    1.0 + 2.0 * positive.sum::<f64>()
}
