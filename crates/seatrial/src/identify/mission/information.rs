//! What a fit of an ordinary log leaves uncertain: Fisher's information of the innovations, and the scatter of blocks.

use nalgebra::{DMatrix, DVector, Matrix4};

use super::columns::{COLUMNS, Point, combined, each_innovation};
use super::fit::{Fit, Problem, belief};
use crate::likelihood::fit::log_determinant;
use crate::likelihood::hypothesis::Parameter;

/// Parts of the record whose scatter tells how uncertain the estimate is.
const BLOCKS: usize = 12;

/// Student's 95 % for twelve blocks over that of a normal deviate, squared.
const STUDENT: f64 = 1.26;

/// d, b, c, the delay, and the log of the steady turn.
const ROWS: usize = 5;
const LOG_GAIN: usize = 4;

/// What a fit leaves uncertain.
#[derive(Clone, Debug)]
pub struct Uncertainty {
    /// Covariance of [d, b, c, shift + lag].
    pub covariance: Matrix4<f64>,
    /// Variance of the log of the steady turn per rudder at the rudder's amplitude.
    pub log_gain_variance: f64,
    /// Log evidence.
    pub log_evidence: f64,
}

impl Problem<'_> {
    /// What a fit leaves uncertain: the inverse information of the innovations, or wider where the scatter of the blocks asks for it.
    ///
    /// ```text
    /// H = sum J' J / s^2,   cov = inv(H),   sandwich = inv(H) (sum g_k g_k') inv(H),   g_k = sum over a block of J' e / s^2
    /// ```
    pub(super) fn uncertainty(&self, fit: &Fit) -> Option<Uncertainty> {
        let derivatives = self.derivatives(fit);
        let factor = derivatives.information().cholesky()?;
        let log_determinant = log_determinant(&factor);
        let linear = if self.has_gyro { 3.0 } else { 2.0 };
        let of_linear = fit.linear_log_determinant - linear * libm::log(fit.variance_rad2);
        let inverse = factor.inverse();
        let scores: Vec<DVector<f64>> = (0..BLOCKS).map(|k| derivatives.score(k, BLOCKS)).collect();
        let mean = scores.iter().sum::<DVector<f64>>() / BLOCKS as f64;
        let scatter =
            scores.iter().map(|g| (g - &mean) * (g - &mean).transpose()).sum::<DMatrix<f64>>()
                * (BLOCKS as f64 / (BLOCKS as f64 - 1.0));
        // Symmetric, and by dot products, whose bits are the same on every machine.
        let sandwich = inverse.tr_mul(&scatter.tr_mul(&inverse));
        let columns = self.rows(fit, &derivatives.unknowns).transpose();
        let of = |covariance: &DMatrix<f64>| columns.tr_mul(&covariance.tr_mul(&columns));
        let (own, other) = (of(&inverse), of(&sandwich));
        let times: Vec<f64> = (0..ROWS)
            .map(|i| (STUDENT * other[(i, i)] / own[(i, i)].max(f64::MIN_POSITIVE)).max(1.0).sqrt())
            .collect();
        let widened = |i: usize, j: usize| own[(i, j)] * times[i] * times[j];
        let is_of_some = |p: &Parameter| {
            !matches!(
                p,
                Parameter::Shift | Parameter::GyroNoise | Parameter::Sea | Parameter::SpeedLate
            )
        };
        let of_some = self.free(fit.hypothesis).into_iter().filter(is_of_some);
        let priors: f64 = of_some.filter_map(|p| p.row().prior_deviation).map(libm::log).sum();
        Some(Uncertainty {
            covariance: Matrix4::from_fn(widened),
            log_gain_variance: widened(LOG_GAIN, LOG_GAIN),
            // The cost has the linear parameters' determinant already.
            log_evidence: -fit.cost - 0.5 * (log_determinant - of_linear) - priors,
        })
    }

    /// Slopes of d, b, c, the delay and the log of the steady turn with the parameters.
    fn rows(&self, fit: &Fit, all: &[Unknown]) -> DMatrix<f64> {
        let rate = self.scale.rate_per_s;
        let amplitude_rad = self.scale.rudder_rad;
        let here = fit.log_gain(amplitude_rad);
        let of_gain = |unknown: Unknown| {
            const STEP: f64 = 1e-4;
            let mut there = fit.clone();
            let step = match unknown {
                Unknown::Own(parameter) => {
                    let mut x = fit.x.clone();
                    x[parameter as usize] += STEP;
                    there.point = self.point(fit.hypothesis, &x);
                    STEP
                }
                Unknown::Linear(j) => {
                    let step = STEP * fit.linear[0].abs();
                    there.linear[j] += step;
                    step
                }
            };
            (there.log_gain(amplitude_rad) - here) / step
        };
        let of_gain: Vec<f64> = all.iter().map(|unknown| of_gain(*unknown)).collect();
        DMatrix::from_fn(ROWS, all.len() + 1, |row, i| match (row, all.get(i).copied()) {
            (LOG_GAIN, Some(_)) => of_gain[i],
            (0, Some(Unknown::Own(Parameter::Damping))) => rate,
            (1, Some(Unknown::Linear(0))) | (2, Some(Unknown::Linear(1))) => 1.0,
            (3, Some(Unknown::Own(Parameter::Shift))) => 1.0 / rate,
            (3, Some(Unknown::Own(Parameter::Lag))) => fit.point.vehicle.lag_s,
            _ => 0.0,
        })
    }

    /// Derivatives of the innovations of a fit.
    pub(super) fn derivatives(&self, fit: &Fit) -> Derivatives {
        const STEP: f64 = 1e-3;
        const HALF: f64 = core::f64::consts::FRAC_1_SQRT_2;
        let own = self.free(fit.hypothesis);
        let here = self.columns(&fit.point);
        let weights: Vec<f64> = (here.iter())
            .map(|(_, variance)| 1.0 / (variance * fit.variance_rad2).sqrt())
            .collect();
        let weighted = |of: &dyn Fn(usize) -> f64| DVector::from_fn(here.len(), |i, _| of(i));
        let error = |e: &[f64; COLUMNS]| combined(e, &fit.linear);
        let errors = weighted(&|i| weights[i] * error(&here[i].0));
        let (mut of_errors, mut of_logs) = (Vec::new(), Vec::new());
        for parameter in &own {
            let mut x = fit.x.clone();
            x[*parameter as usize] += STEP;
            let there = self.columns(&self.point(fit.hypothesis, &x));
            of_errors
                .push(weighted(&|k| weights[k] * (error(&there[k].0) - error(&here[k].0)) / STEP));
            of_logs.push(weighted(&|k| HALF * libm::log(there[k].1 / here[k].1) / STEP));
        }
        let linear = if self.has_gyro { 3 } else { 2 };
        for j in 0..linear {
            of_errors.push(weighted(&|k| weights[k] * here[k].0[j + 1]));
            of_logs.push(DVector::zeros(here.len()));
        }
        // The variance of the heading noise.
        of_errors.push(DVector::zeros(here.len()));
        of_logs.push(DVector::from_element(here.len(), HALF));
        let unknowns: Vec<Unknown> = (own.iter().map(|parameter| Unknown::Own(*parameter)))
            .chain((0..linear).map(Unknown::Linear))
            .collect();
        let mut prior = DVector::zeros(of_errors.len());
        let mut prior_slope = DVector::zeros(of_errors.len());
        for (k, parameter) in own.iter().enumerate() {
            if let Some([mean, deviation]) = belief(*parameter) {
                prior[k] = libm::pow(deviation, -2.0);
                prior_slope[k] = (fit.x[*parameter as usize] - mean) * prior[k];
            }
        }
        Derivatives {
            unknowns,
            excess: errors.map(|e| HALF * (1.0 - e * e)),
            errors,
            of_errors: DMatrix::from_columns(&of_errors),
            of_logs: DMatrix::from_columns(&of_logs),
            prior,
            prior_slope,
        }
    }

    /// The columns of each innovation and its relative variance.
    fn columns(&self, point: &Point) -> Vec<([f64; COLUMNS], f64)> {
        let mut columns = Vec::with_capacity(2 * self.legs.len());
        each_innovation(self.legs, point, self.scale.yaw_rate_rad_s, |e, variance| {
            columns.push((*e, variance));
        });
        columns
    }
}

#[derive(Clone, Copy, Debug)]
enum Unknown {
    Own(Parameter),
    Linear(usize),
}

/// Innovations over their deviations, and derivatives of them and of the logs of their variances.
pub(super) struct Derivatives {
    unknowns: Vec<Unknown>,
    errors: DVector<f64>,
    excess: DVector<f64>,
    of_errors: DMatrix<f64>,
    of_logs: DMatrix<f64>,
    prior: DVector<f64>,
    prior_slope: DVector<f64>,
}

impl Derivatives {
    /// Fisher's information of the parameters and of the log of the noise's variance, with the priors.
    pub(super) fn information(&self) -> DMatrix<f64> {
        self.of_errors.tr_mul(&self.of_errors)
            + self.of_logs.tr_mul(&self.of_logs)
            + DMatrix::from_diagonal(&self.prior)
    }

    /// Slope of minus log likelihood and priors.
    pub(super) fn slope(&self) -> DVector<f64> {
        self.score(0, 1) + &self.prior_slope
    }

    /// Slope of minus log likelihood over one of several blocks.
    fn score(&self, block: usize, blocks: usize) -> DVector<f64> {
        let [from, to] = [block, block + 1].map(|k| k * self.errors.len() / blocks);
        let rows = |matrix: &DMatrix<f64>, of: &DVector<f64>| {
            matrix.rows(from, to - from).tr_mul(&of.rows(from, to - from))
        };
        rows(&self.of_errors, &self.errors) + rows(&self.of_logs, &self.excess)
    }
}
