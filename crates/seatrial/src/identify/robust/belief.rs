//! What is believed of lag, shift and the first rudder before a record is seen.

use super::normal::above_zero;
use super::record::{A22, B2, DELAY, FIRST, LAG2, PARAMETERS, Point, Record};
use super::symmetric::{Factorisation, invert};

/// Mean lag of a rudder, in time constants of its vehicle.
const USUAL_LAG: f64 = 0.3;

/// Standard deviation of the shift between record and rudder, in sample intervals: a record may be the mean of the rudder
/// between two rows, its last value, or one held until the next.
const SHIFT_INTERVALS: f64 = 0.5;

/// Standard deviation of the first rudder's distance from its record, in amplitudes of the rudder.
const FIRST_AMPLITUDES: f64 = 0.3;

/// A record that the parameters explain whole leaves no less.
const LEAST_SQUARE: f64 = 1e-12;

/// log(2 pi).
pub const LOG_TAU: f64 = 1.837_877_066_409_345_3;

/// The normal equations of data and beliefs around a point.
#[derive(Clone, Debug)]
pub struct Equations {
    /// Second derivatives of minus the log posterior.
    pub information: [[f64; PARAMETERS]; PARAMETERS],
    /// Derivatives of the log posterior.
    pub right: [f64; PARAMETERS],
    /// Minus twice the log posterior at the point, less the constants.
    pub square: f64,
    /// Log of the constants of the beliefs.
    pub log_constant: f64,
}

impl Equations {
    /// Adds the beliefs of a rudder that may lag.
    ///
    /// ```text
    /// s ~ (T_u + 1.25 sigma)^-1 exp(-s+/T_u - s-^2/(2 sigma^2))     v | s ~ N(s+^2, 4 s+^2 sigma^2 + 2 sigma^4), v >= 0
    /// b2 delta_f ~ N(0, (0.3 |b2| A)^2)
    /// ```
    ///
    /// | symbol | meaning |
    /// |---|---|
    /// | s, s+, s- | delay T_l + tau, its positive and its negative part |
    /// | v | T_l^2 |
    /// | T_u | usual lag, 0.3 of the vehicle's time constant, no less than a sample interval |
    /// | sigma | standard deviation of the shift tau, half a sample interval |
    /// | delta_f, A | the first rudder's distance from its record; the rudder's amplitude |
    ///
    /// It is what an exponential T_l and a normal tau give, to second order in sigma.
    pub fn believe_in_lag(&mut self, record: &Record, point: &Point) {
        let p = &point.0;
        let rate = record.rate_scale(p[A22]);
        let usual_s = (USUAL_LAG / rate).max(record.interval_s);
        let shift_s = SHIFT_INTERVALS * record.timing_s;
        let late_s = p[DELAY].max(0.0);
        let of_v_s2 = ((2.0 * late_s * shift_s).powi(2) + 2.0 * shift_s.powi(4)).sqrt();
        let of_first = (FIRST_AMPLITUDES * record.amplitude_rad * p[B2].abs()).max(1e-30);
        if p[DELAY] > 0.0 {
            self.square += 2.0 * p[DELAY] / usual_s;
            self.right[DELAY] -= 1.0 / usual_s;
            if usual_s > record.interval_s {
                self.right[A22] -= p[DELAY] / USUAL_LAG * p[A22].signum();
            }
        } else {
            self.add(&[(DELAY, 1.0 / shift_s)], -p[DELAY] / shift_s);
        }
        let of_lag = [(LAG2, 1.0 / of_v_s2), (DELAY, -2.0 * late_s / of_v_s2)];
        self.add(&of_lag, (late_s * late_s - p[LAG2]) / of_v_s2);
        self.add(&[(FIRST, 1.0 / of_first)], -p[FIRST] / of_first);
        self.log_constant -= LOG_TAU
            + libm::log(of_first)
            + libm::log(of_v_s2)
            + above_zero(late_s * late_s / of_v_s2).log_probability
            + libm::log(usual_s + 1.25 * shift_s);
    }

    /// Holds the lag, the shift and the first rudder's distance at 0.
    pub fn believe_in_none(&mut self) {
        for held in [FIRST, DELAY, LAG2] {
            for other in 0..PARAMETERS {
                self.information[held][other] = 0.0;
                self.information[other][held] = 0.0;
            }
            self.information[held][held] = 1.0;
            self.right[held] = 0.0;
        }
    }

    /// One equation with normal residual of standard deviation 1.
    fn add(&mut self, row: &[(usize, f64)], residual: f64) {
        self.square += residual * residual;
        for (i, of_i) in row {
            self.right[*i] += of_i * residual;
            for (j, of_j) in row {
                self.information[*i][*j] += of_i * of_j;
            }
        }
    }

    /// Minus twice the log posterior at the best point, less the constants. `None` where the record does not determine the parameters.
    pub fn best_square(&self) -> Option<f64> {
        let explained = Factorisation::of(&self.information)?.square_of(&self.right);
        Some((self.square - explained).max(LEAST_SQUARE))
    }

    /// Change to the best point, covariance, log determinant of the information, and the square there. `None` where the
    /// record does not determine the parameters.
    pub fn solve(&self) -> Option<Solution> {
        let (covariance, log_determinant) = invert(&self.information)?;
        let change: [f64; PARAMETERS] = core::array::from_fn(|i| {
            covariance[i].iter().zip(&self.right).map(|(c, r)| c * r).sum()
        });
        let explained: f64 = change.iter().zip(&self.right).map(|(c, r)| c * r).sum();
        Some(Solution {
            change,
            covariance,
            log_determinant,
            square: (self.square - explained).max(LEAST_SQUARE),
        })
    }
}

/// What [`Equations::solve`] finds.
#[derive(Clone, Copy, Debug)]
pub struct Solution {
    /// Change of the parameters from the point to the best one.
    pub change: [f64; PARAMETERS],
    /// Covariance of the parameters.
    pub covariance: [[f64; PARAMETERS]; PARAMETERS],
    /// Logarithm of the determinant of the information.
    pub log_determinant: f64,
    /// Minus twice the log posterior at the best point, less the constants.
    pub square: f64,
}
