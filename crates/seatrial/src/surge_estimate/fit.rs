//! The speeds of a trial, played and fitted.

use nalgebra::{DMatrix, DVector};

/// Correlation of the residuals that the covariance allows for, s.
const CORRELATION_S: f64 = 2.0;
/// Iterations of the fit.
const MOST_ITERATIONS: usize = 40;
/// Change of a parameter for a derivative, which is that to larger values: a lag is not below 0.
const DIFFERENCE: f64 = 1e-5;
/// Damping of a step that would make the fit worse, and the most of it.
const DAMPING: f64 = 1e-6;
const MOST_DAMPING: f64 = 1e8;
/// Drag lengths, m, and lags, s, that a fit begins with: the best of them.
const FIRST_LENGTHS_M: [f64; 9] = [1.0, 2.5, 6.0, 15.0, 40.0, 100.0, 300.0, 1000.0, 3000.0];
const FIRST_LAGS_S: [f64; 3] = [0.0, 0.5, 2.0];

/// An instant of a part of the record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instant {
    pub time_s: f64,
    pub surge_speed_m_s: f64,
    pub yaw_rate_rad_s: f64,
}

/// A part of the record at one thrust, from the change to it on.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Its thrust and the one before, as places in the list of thrusts.
    pub thrust: usize,
    pub before: usize,
    /// Instants before the first doublet.
    pub settling: usize,
    pub instants: Vec<Instant>,
}

/// The parameters of a fit: the steady speed of each thrust, ln l, the lag, d, the first speed of each part.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    values: DVector<f64>,
    thrusts: usize,
}

impl Parameters {
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
    fn free(&self, varied: Varied) -> Vec<usize> {
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
pub(super) struct Varied {
    pub length: bool,
    pub lag: bool,
    pub turning_drag: bool,
}

/// What a fit found.
pub(super) struct Fitted {
    pub parameters: Parameters,
    pub rms_residual_m_s: f64,
    /// Place of each varied parameter in the covariance.
    varied: Vec<usize>,
    covariance: DMatrix<f64>,
}

impl Fitted {
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

/// The fit of all parts; `None` where they do not determine what is varied. A lag that would fall below 0 is 0, with the
/// uncertainty of one that may be more.
pub(super) fn fitted(parts: &[Part], steady_m_s: &[f64], varied: Varied) -> Option<Fitted> {
    let observed = observed(parts);
    let beginning = beginning(parts, steady_m_s, varied);
    let free = beginning.free(varied);
    if observed.len() <= 2 * free.len() {
        return None;
    }
    let mut found = descended(parts, &observed, beginning.clone(), &free)?;
    if found.0.lag_s() <= 0.0 {
        let without_lag = Varied {
            lag: false,
            ..varied
        };
        let mut at_0 = beginning;
        at_0.values[steady_m_s.len() + 1] = 0.0;
        let free = at_0.free(without_lag);
        found = descended(parts, &observed, at_0, &free)?;
    }
    let (parameters, residual) = found;
    let jacobian = jacobian(parts, &parameters, &free);
    let covariance = covariance(parts, &jacobian, &residual)?;
    let freedom = (observed.len() - free.len()) as f64;
    Some(Fitted {
        rms_residual_m_s: (residual.norm_squared() / freedom).sqrt(),
        parameters,
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
    let lag = parameters.thrusts + 1;
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
            next.values[lag] = next.values[lag].max(0.0);
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
fn beginning(parts: &[Part], steady_m_s: &[f64], varied: Varied) -> Parameters {
    let first = parts.iter().map(|part| {
        let count = part.instants.len().min(5);
        let sum: f64 = part.instants[..count]
            .iter()
            .map(|at| at.surge_speed_m_s)
            .sum();
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
    let speeds: Vec<f64> = parts
        .iter()
        .flat_map(|part| part.instants.iter().map(|at| at.surge_speed_m_s))
        .collect();
    DVector::from_vec(speeds)
}

/// The speeds that the parameters give, by the midpoint rule.
fn played(parts: &[Part], parameters: &Parameters) -> DVector<f64> {
    let (length_m, lag_s) = (parameters.length_m(), parameters.lag_s());
    let turning_drag_m = parameters.turning_drag_m();
    let mut speeds = Vec::new();
    for (k, part) in parts.iter().enumerate() {
        let steady_m_s = parameters.values[part.thrust];
        let change_m_s = parameters.values[part.before] - steady_m_s;
        let mut speed_m_s = parameters.values[parameters.thrusts + 3 + k];
        speeds.push(speed_m_s);
        let start_s = part.instants[0].time_s;
        for pair in part.instants.windows(2) {
            let interval_s = pair[1].time_s - pair[0].time_s;
            let left = left_s(pair[0].time_s - start_s, interval_s, lag_s) / interval_s;
            let towards_m_s = steady_m_s + change_m_s * left;
            let turned = 0.5 * (pair[0].yaw_rate_rad_s.powi(2) + pair[1].yaw_rate_rad_s.powi(2));
            let acceleration = |speed_m_s: f64| {
                (towards_m_s * towards_m_s.abs() - speed_m_s * speed_m_s.abs()) / length_m
                    - turning_drag_m * turned
            };
            let halfway_m_s = speed_m_s + 0.5 * interval_s * acceleration(speed_m_s);
            speed_m_s += interval_s * acceleration(halfway_m_s);
            speeds.push(speed_m_s);
        }
    }
    DVector::from_vec(speeds)
}

/// The integral of e^{-t/lag} over an interval from a time on: also a lag far below the interval has its effect.
fn left_s(from_s: f64, interval_s: f64, lag_s: f64) -> f64 {
    match lag_s > 0.0 {
        true => -lag_s * libm::exp(-from_s / lag_s) * libm::expm1(-interval_s / lag_s),
        false => 0.0,
    }
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

/// (J'J)^-1 J'R J (J'J)^-1 with R the autocovariance of the residuals within a part, the same for all parts, falling linearly to 0
/// at [`CORRELATION_S`]: right for noise that is correlated over less.
fn covariance(
    parts: &[Part],
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
) -> Option<DMatrix<f64>> {
    let count = jacobian.ncols();
    let inverse = jacobian.tr_mul(jacobian).cholesky()?.inverse();
    let spans = spans(parts);
    let (lasts_s, steps) = parts.iter().fold((0.0, 0), |(time_s, steps), part| {
        let [first, last] = [part.instants.first(), part.instants.last()];
        let lasts_s = last.zip(first).map_or(0.0, |(b, a)| b.time_s - a.time_s);
        (time_s + lasts_s, steps + part.instants.len() - 1)
    });
    let lags = (CORRELATION_S * steps as f64 / lasts_s) as usize;
    let mut middle = DMatrix::zeros(count, count);
    for lag in 0..=lags {
        let (mut products, mut pairs) = (0.0, 0);
        let mut jacobians = DMatrix::zeros(count, count);
        for (from, rows) in spans.iter().filter(|(_, rows)| *rows > lag) {
            let [late, early] = [from + lag, *from];
            let rows = rows - lag;
            products += residual.rows(late, rows).dot(&residual.rows(early, rows));
            pairs += rows;
            jacobians += jacobian
                .rows(late, rows)
                .tr_mul(&jacobian.rows(early, rows));
        }
        if pairs == 0 {
            break;
        }
        let weight = 1.0 - lag as f64 / (lags + 1) as f64;
        let autocovariance = weight * products / pairs as f64;
        middle += autocovariance * &jacobians;
        if lag > 0 {
            middle += autocovariance * jacobians.transpose();
        }
    }
    let rows = residual.len() as f64;
    Some(rows / (rows - count as f64) * &inverse * middle * &inverse)
}

/// First row and number of rows of each part.
fn spans(parts: &[Part]) -> Vec<(usize, usize)> {
    let mut from = 0;
    let span = |part: &Part| {
        let rows = part.instants.len();
        from += rows;
        (from - rows, rows)
    };
    parts.iter().map(span).collect()
}
