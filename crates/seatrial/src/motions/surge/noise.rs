//! What noise makes of a fit whose form is not exactly that of the vehicle.
//!
//! ```text
//! V   = H^-1 (s^2 J'J + s_r^2 G'G) H^-1        white noise
//! V   = H^-1 J'R J H^-1                        noise that is correlated
//! H   = J'J - sum of e_i f_i''                 half the second derivatives of the sum of squares
//! s^2 = mean of (x_i - 3 x_i-1 + 3 x_i-2 - x_i-3)^2/20
//! v   = sum of (e_i - e_i-1)^2 / sum of (e_i - mean)^2
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | V | covariance of the parameters | |
//! | f, e, J | played speeds, residuals, derivatives of f by the parameters | m/s |
//! | s | noise of the speed, from third differences of e | m/s |
//! | s_r | noise of a measured yaw rate, from third differences of it | rad/s |
//! | G | J carried back through the linearised speed to each yaw rate | |
//! | v | von Neumann's ratio over the later half of each settling stage: 2 for white noise, with variance 4/n | 1 |
//! | R | autocovariance of e within a part, falling linearly to 0 at 2 s | |
//!
//! The residuals hold noise, which differs from trial to trial, and what the form lacks, which the next trial repeats: rudder drag and
//! drift in a turn, above all. Only the noise moves the answer about the best fit of the form, so only it belongs into V. Differences of
//! third order tell it from what varies over seconds. Where the form lacks something, H is not J'J: also
//! residuals of a twentieth of the noise change the interval of l by a third where l and the lag exchange for each other.
//!
//! Sources: covariance about the best fit of a form that is not exact, H. White, Consequences and detection of misspecified nonlinear
//! regression models, J. Am. Stat. Assoc. 76 (1981) 419-433; noise from differences, T. Gasser, L. Sroka, C. Jennen-Steinmetz,
//! Residual variance and residual pattern in nonlinear regression, Biometrika 73 (1986) 625-633; the ratio, J. von Neumann, Ann. Math.
//! Stat. 12 (1941) 367-395; R, W. Newey, K. West, Econometrica 55 (1987) 703-708.
//!
//! Valid for noise of speed and yaw rate that is independent from reading to reading; a reading that is held over several samples counts
//! once. Where v is below 2 by more than chance makes in one of a thousand trials (waves, a speed that was filtered), R takes over: it counts
//! what the form lacks as noise, so intervals are then rather too wide than too narrow, for noise correlated over less than 2 s. An error of
//! a yaw rate that is the model's is in neither. A fit with H takes some 0.14 s for a trial of five speeds at 20 Hz.

use nalgebra::{DMatrix, DVector, RowDVector};

use super::parts::{Part, spans};

/// Correlation of the residuals that R allows for, s.
const CORRELATION_S: f64 = 2.0;
/// 99.9 % point of the standard normal distribution.
const NORMAL_99_9: f64 = 3.090_232;
/// Sum of the squared weights of a third difference.
const THIRD_DIFFERENCE: f64 = 20.0;

/// How a speed follows from the one before it and from the yaw rates at the ends of the interval.
pub(super) struct Slope {
    pub of_speed: f64,
    pub of_yaw_rates: [f64; 2],
}

/// The noise of the speeds of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noise {
    /// Variance that independent samples would have, (m/s)^2.
    pub variance: f64,
    pub is_white: bool,
}

impl Noise {
    pub fn of(parts: &[Part], residual: &DVector<f64>) -> Self {
        let series: Vec<Vec<f64>> = spans(parts)
            .iter()
            .zip(parts)
            .map(|((from, rows), part)| {
                let held = part.instants.iter().map(|at| at.surge_speed_m_s);
                let residuals = residual.rows(*from, *rows);
                once(held, residuals.iter().copied())
            })
            .collect();
        let read: usize = series.iter().map(Vec::len).sum();
        let variance = difference_variance(&series) * residual.len() as f64 / read.max(1) as f64;
        Self { variance, is_white: is_white(parts, &series) }
    }

    /// V, from H^-1.
    pub fn covariance(
        &self,
        parts: &[Part],
        jacobian: &DMatrix<f64>,
        residual: &DVector<f64>,
        bread: &DMatrix<f64>,
        slopes: &[Vec<Slope>],
    ) -> DMatrix<f64> {
        let middle = match self.is_white {
            true => {
                self.variance * jacobian.tr_mul(jacobian) + of_yaw_rates(parts, jacobian, slopes)
            }
            false => of_residuals(parts, jacobian, residual),
        };
        bread * middle * bread
    }
}

/// Variance of the noise of a measured yaw rate, (rad/s)^2.
pub(super) fn yaw_rate_variance(series: &[Vec<f64>]) -> f64 {
    let all: usize = series.iter().map(Vec::len).sum();
    let series: Vec<Vec<f64>> =
        series.iter().map(|x| once(x.iter().copied(), x.iter().copied())).collect();
    let read: usize = series.iter().map(Vec::len).sum();
    difference_variance(&series) * all as f64 / read.max(1) as f64
}

/// Of what is held over several samples, the first.
fn once(held: impl Iterator<Item = f64>, values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut last = None;
    held.zip(values)
        .filter(|(reading, _)| last.replace(*reading) != Some(*reading))
        .map(|(_, value)| value)
        .collect()
}

fn difference_variance(series: &[Vec<f64>]) -> f64 {
    let differences: Vec<f64> = series
        .iter()
        .flat_map(|x| x.windows(4))
        .map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0])
        .collect();
    let squares: f64 = differences.iter().map(|d| d * d).sum();
    squares / (THIRD_DIFFERENCE * differences.len().max(1) as f64)
}

/// Is von Neumann's ratio over the later halves of the settling stages that of white noise?
fn is_white(parts: &[Part], series: &[Vec<f64>]) -> bool {
    let (mut differences, mut squares, mut count) = (0.0, 0.0, 0.0);
    for (part, x) in parts.iter().zip(series) {
        let settling = part.settling * x.len() / part.instants.len().max(1);
        let late = &x[settling / 2..settling];
        let mean = late.iter().sum::<f64>() / late.len().max(1) as f64;
        differences += late.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
        squares += late.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
        count += late.len().saturating_sub(1) as f64;
    }
    differences >= (2.0 - 2.0 * NORMAL_99_9 / f64::max(count, 1.0).sqrt()) * squares
}

/// s_r^2 G'G: what the noise of the yaw rates makes of J'e.
fn of_yaw_rates(parts: &[Part], jacobian: &DMatrix<f64>, slopes: &[Vec<Slope>]) -> DMatrix<f64> {
    let count = jacobian.ncols();
    let mut sum = DMatrix::zeros(count, count);
    for ((part, slopes), (from, rows)) in parts.iter().zip(slopes).zip(spans(parts)) {
        // What a change of the speed at an instant makes of J'f from there on.
        let mut follows: RowDVector<f64> = RowDVector::zeros(count);
        for k in (0..rows).rev() {
            let mut by_yaw_rate: RowDVector<f64> = RowDVector::zeros(count);
            let mut here = jacobian.row(from + k).into_owned();
            if let Some(slope) = slopes.get(k) {
                by_yaw_rate += slope.of_yaw_rates[0] * &follows;
                here += slope.of_speed * &follows;
            }
            if let Some(slope) = k.checked_sub(1).and_then(|before| slopes.get(before)) {
                by_yaw_rate += slope.of_yaw_rates[1] * &here;
            }
            sum += part.yaw_rate_variance * by_yaw_rate.transpose() * &by_yaw_rate;
            follows = here;
        }
    }
    sum
}

/// J'R J.
fn of_residuals(parts: &[Part], jacobian: &DMatrix<f64>, residual: &DVector<f64>) -> DMatrix<f64> {
    let count = jacobian.ncols();
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
            jacobians += jacobian.rows(late, rows).tr_mul(&jacobian.rows(early, rows));
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
    rows / (rows - count as f64) * middle
}
