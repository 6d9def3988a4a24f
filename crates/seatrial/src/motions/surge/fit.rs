//! The speeds of a trial, played and fitted.

use nalgebra::{DMatrix, DVector};

use super::noise::{Noise, Slope};
use super::parts::{Instant, Part, spans};

/// Iterations of the fit.
const MOST_ITERATIONS: usize = 40;
/// Change of a parameter for a first and for a second derivative.
const DIFFERENCE: f64 = 1e-5;
const SECOND_DIFFERENCE: f64 = 1e-3;
/// Damping of a step that would make the fit worse, and the most of it.
const DAMPING: f64 = 1e-6;
const MOST_DAMPING: f64 = 1e8;
/// Drag lengths, m, and lags, s, that a fit begins with: the best of them.
const FIRST_LENGTHS_M: [f64; 9] = [1.0, 2.5, 6.0, 15.0, 40.0, 100.0, 300.0, 1000.0, 3000.0];
const FIRST_LAGS_S: [f64; 3] = [0.0, 0.5, 2.0];

/// The parameters of a fit: the steady speed of each thrust, ln l, the lag, d, the first speed of each part.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    values: DVector<f64>,
    thrusts: usize,
}

impl Parameters {
    /// Of steady speeds, l, the lag and d = 0; each part begins with the speed that the one before it ended with.
    pub fn believed(
        parts: &[Part],
        steady_m_s: &[f64],
        first_m_s: f64,
        [length_m, lag_s]: [f64; 2],
    ) -> Self {
        let surge = [libm::log(length_m), lag_s, 0.0];
        let values = steady_m_s.iter().copied().chain(surge);
        let mut values: Vec<f64> = values.chain(parts.iter().map(|_| first_m_s)).collect();
        let thrusts = steady_m_s.len();
        let mut first_m_s = first_m_s;
        for (k, part) in parts.iter().enumerate() {
            values[thrusts + 3 + k] = first_m_s;
            let so_far = Self { values: DVector::from_column_slice(&values), thrusts };
            let last = played_part(part, first_m_s, &so_far).last().copied();
            first_m_s = last.unwrap_or(first_m_s);
        }
        Self { values: DVector::from_vec(values), thrusts }
    }

    pub fn steady_m_s(&self, thrust: usize) -> f64 {
        self.values[thrust]
    }

    pub fn length_m(&self) -> f64 {
        libm::exp(self.values[self.thrusts])
    }

    pub fn lag_s(&self) -> f64 {
        self.values[self.thrusts + 1]
    }

    pub fn turning_drag_m(&self) -> f64 {
        self.values[self.thrusts + 2]
    }

    /// The places of what is varied.
    fn free(&self, varied: FreeParameters) -> Vec<usize> {
        (0..self.values.len())
            .filter(|k| match k.checked_sub(self.thrusts) {
                Some(0) => varied.length,
                Some(1) => varied.lag,
                Some(2) => varied.turning_drag,
                _ => true,
            })
            .collect()
    }
}

/// Which of the parameters a fit varies besides the speeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FreeParameters {
    pub length: bool,
    pub lag: bool,
    pub turning_drag: bool,
}

/// What a fit found.
pub(super) struct SurgeFit {
    pub parameters: Parameters,
    pub rms_residual_m_s: f64,
    pub noise: Noise,
    /// Place of each varied parameter in the covariance.
    varied: Vec<usize>,
    covariance: DMatrix<f64>,
}

impl SurgeFit {
    /// Standard error of ln l.
    pub fn length_error(&self) -> Option<f64> {
        self.error(self.parameters.thrusts)
    }

    /// Standard error of the lag, s.
    pub fn lag_error_s(&self) -> Option<f64> {
        self.error(self.parameters.thrusts + 1)
    }

    /// Standard error of d, m.
    pub fn turning_drag_error_m(&self) -> Option<f64> {
        self.error(self.parameters.thrusts + 2)
    }

    /// Covariance of the steady speeds.
    pub fn steady_covariance(&self) -> DMatrix<f64> {
        let count = self.parameters.thrusts;
        self.covariance.view((0, 0), (count, count)).into_owned()
    }

    fn error(&self, parameter: usize) -> Option<f64> {
        let place = self.varied.iter().position(|k| *k == parameter)?;
        Some(self.covariance[(place, place)].sqrt())
    }
}

/// The fit of all parts; `None` where they do not determine what is varied. A lag may fall below 0, so that noise moves it to either
/// side of a small one.
pub(super) fn fitted(
    parts: &[Part],
    steady_m_s: &[f64],
    varied: FreeParameters,
) -> Option<SurgeFit> {
    let observed = observed(parts);
    let beginning = beginning(parts, steady_m_s, varied);
    let free = beginning.free(varied);
    if observed.len() <= 2 * free.len() {
        return None;
    }
    let (parameters, residual) = descended(parts, &observed, beginning, &free)?;
    let jacobian = jacobian(parts, &parameters, &free);
    let noise = Noise::of(parts, &residual);
    let bread = hessian(parts, &observed, &parameters, &free)
        .cholesky()
        .or_else(|| jacobian.tr_mul(&jacobian).cholesky())?
        .inverse();
    let slopes = slopes(parts, &parameters);
    let covariance = noise.covariance(parts, &jacobian, &residual, &bread, &slopes);
    let freedom = (observed.len() - free.len()) as f64;
    Some(SurgeFit {
        rms_residual_m_s: (residual.norm_squared() / freedom).sqrt(),
        parameters,
        noise,
        varied: free,
        covariance,
    })
}

/// Levenberg's and Marquardt's descent: the parameters and what they leave.
fn descended(
    parts: &[Part],
    observed: &DVector<f64>,
    mut parameters: Parameters,
    free: &[usize],
) -> Option<(Parameters, DVector<f64>)> {
    let mut residual = observed - played(parts, &parameters);
    let mut damping = DAMPING;
    for _ in 0..MOST_ITERATIONS {
        let jacobian = jacobian(parts, &parameters, free);
        let normal = jacobian.tr_mul(&jacobian);
        let gradient = jacobian.tr_mul(&residual);
        let mut has_settled = true;
        while damping < MOST_DAMPING {
            let mut damped = normal.clone();
            for k in 0..free.len() {
                damped[(k, k)] *= 1.0 + damping;
            }
            let step = damped.cholesky()?.solve(&gradient);
            let mut next = parameters.clone();
            for (k, change) in free.iter().zip(step.iter()) {
                next.values[*k] += change;
            }
            let next_residual = observed - played(parts, &next);
            let [before, after] = [&residual, &next_residual].map(|r| r.norm_squared());
            if after <= before {
                has_settled = before - after <= 1e-10 * before;
                (parameters, residual) = (next, next_residual);
                damping = (0.1 * damping).max(DAMPING);
                break;
            }
            damping *= 10.0;
        }
        if has_settled {
            break;
        }
    }
    Some((parameters, residual))
}

/// The parameters that a fit begins with.
fn beginning(parts: &[Part], steady_m_s: &[f64], varied: FreeParameters) -> Parameters {
    let first = parts.iter().map(|part| {
        let count = part.instants.len().min(5);
        let sum: f64 = part.instants[..count].iter().map(|at| at.surge_speed_m_s).sum();
        sum / count as f64
    });
    let values = steady_m_s.iter().copied().chain([0.0; 3]).chain(first);
    let mut best = Parameters {
        values: DVector::from_iterator(steady_m_s.len() + 3 + parts.len(), values),
        thrusts: steady_m_s.len(),
    };
    let observed = observed(parts);
    let mut least = f64::INFINITY;
    for length_m in FIRST_LENGTHS_M {
        for lag_s in FIRST_LAGS_S.iter().filter(|lag| varied.lag || **lag == 0.0) {
            let mut tried = best.clone();
            tried.values[steady_m_s.len()] = libm::log(length_m);
            tried.values[steady_m_s.len() + 1] = *lag_s;
            let squares = (&observed - played(parts, &tried)).norm_squared();
            if squares < least {
                least = squares;
                best = tried;
            }
        }
    }
    best
}

fn observed(parts: &[Part]) -> DVector<f64> {
    let speeds: Vec<f64> =
        parts.iter().flat_map(|part| part.instants.iter().map(|at| at.surge_speed_m_s)).collect();
    DVector::from_vec(speeds)
}

/// The speeds that the parameters give; the thrust does not change its sense.
pub(super) fn played(parts: &[Part], parameters: &Parameters) -> DVector<f64> {
    let first_m_s = parameters.values.iter().skip(parameters.thrusts + 3);
    let of = |(part, first_m_s): (&Part, &f64)| played_part(part, *first_m_s, parameters);
    DVector::from_vec(parts.iter().zip(first_m_s).flat_map(of).collect())
}

/// The speeds of a part from its first on, by the midpoint rule.
fn played_part(part: &Part, first_m_s: f64, parameters: &Parameters) -> Vec<f64> {
    let (length_m, lag_s) = (parameters.length_m(), parameters.lag_s());
    let turning_drag_m = parameters.turning_drag_m();
    let steady_m_s = parameters.values[part.thrust];
    let change_m_s = parameters.values[part.before] - steady_m_s;
    let mut speed_m_s = first_m_s;
    let mut speeds = vec![speed_m_s];
    let start_s = part.instants[0].time_s;
    for pair in part.instants.windows(2) {
        let interval_s = pair[1].time_s - pair[0].time_s;
        // The means of e^{-t/lag} and of its square over the interval, and so that of w |w|.
        let [left, left_squared] = [lag_s, 0.5 * lag_s]
            .map(|lag_s| left_s(pair[0].time_s - start_s, interval_s, lag_s) / interval_s);
        let towards_m2_s2 = steady_m_s.signum()
            * (steady_m_s * (steady_m_s + 2.0 * change_m_s * left)
                + change_m_s * change_m_s * left_squared);
        let turned = 0.5 * (pair[0].yaw_rate_rad_s.powi(2) + pair[1].yaw_rate_rad_s.powi(2))
            - part.yaw_rate_variance;
        let acceleration = |speed_m_s: f64| {
            (towards_m2_s2 - speed_m_s * speed_m_s.abs()) / length_m - turning_drag_m * turned
        };
        let halfway_m_s = speed_m_s + 0.5 * interval_s * acceleration(speed_m_s);
        speed_m_s += interval_s * acceleration(halfway_m_s);
        speeds.push(speed_m_s);
    }
    speeds
}

/// The integral of e^{-t/lag} over an interval from a time on: also a lag far below the interval has its effect. A lag below 0 takes
/// from the first interval what a small one above 0 adds to it.
fn left_s(from_s: f64, interval_s: f64, lag_s: f64) -> f64 {
    match lag_s > 0.0 {
        true => -lag_s * libm::exp(-from_s / lag_s) * libm::expm1(-interval_s / lag_s),
        false if from_s == 0.0 => lag_s,
        false => 0.0,
    }
}

/// Standard errors of ln l and of the lag, s, that noise of this deviation will leave: V = s^2 (J'J)^-1. `None` where the parts do not
/// determine what is varied.
pub(super) fn expected_errors(
    parts: &[Part],
    parameters: &Parameters,
    varied: FreeParameters,
    noise_m_s: f64,
) -> Option<[Option<f64>; 2]> {
    let free = parameters.free(varied);
    let jacobian = jacobian(parts, parameters, &free);
    let normal = jacobian.tr_mul(&jacobian);
    let covariance = noise_m_s * noise_m_s * normal.cholesky()?.inverse();
    let error = |parameter: usize| {
        let place = free.iter().position(|k| *k == parameter)?;
        Some(covariance[(place, place)].sqrt())
    };
    Some([error(parameters.thrusts), error(parameters.thrusts + 1)])
}

fn jacobian(parts: &[Part], parameters: &Parameters, free: &[usize]) -> DMatrix<f64> {
    let here = played(parts, parameters);
    let columns: Vec<DVector<f64>> = free
        .iter()
        .map(|k| {
            let mut moved = parameters.clone();
            moved.values[*k] += DIFFERENCE;
            (played(parts, &moved) - &here) / DIFFERENCE
        })
        .collect();
    DMatrix::from_columns(&columns)
}

/// Half the second derivatives of the sum of squares, J'J - sum of e f'': by central differences of its gradient.
fn hessian(
    parts: &[Part],
    observed: &DVector<f64>,
    parameters: &Parameters,
    free: &[usize],
) -> DMatrix<f64> {
    let gradient = |place: usize, change: f64| {
        let mut moved = parameters.clone();
        moved.values[place] += change;
        let residual = observed - played(parts, &moved);
        -jacobian(parts, &moved, free).tr_mul(&residual)
    };
    let columns: Vec<DVector<f64>> = free
        .iter()
        .map(|k| {
            let [after, before] = [SECOND_DIFFERENCE, -SECOND_DIFFERENCE].map(|h| gradient(*k, h));
            (after - before) / (2.0 * SECOND_DIFFERENCE)
        })
        .collect();
    let hessian = DMatrix::from_columns(&columns);
    0.5 * (&hessian + hessian.transpose())
}

/// How the speed after each interval follows from that before it and from the yaw rates at its ends, linearised.
fn slopes(parts: &[Part], parameters: &Parameters) -> Vec<Vec<Slope>> {
    let played = played(parts, parameters);
    let [length_m, drag_m] = [parameters.length_m(), parameters.turning_drag_m()];
    spans(parts)
        .iter()
        .zip(parts)
        .map(|((from, _), part)| {
            let slope = |(k, pair): (usize, &[Instant])| {
                let interval_s = pair[1].time_s - pair[0].time_s;
                Slope {
                    of_speed: 1.0 - 2.0 * played[from + k].abs() * interval_s / length_m,
                    of_yaw_rates: [0, 1].map(|end| -drag_m * pair[end].yaw_rate_rad_s * interval_s),
                }
            };
            part.instants.windows(2).enumerate().map(slope).collect()
        })
        .collect()
}
