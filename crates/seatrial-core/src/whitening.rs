//! The gains of a Kalman filter that whitens measurements: the only place where a covariance goes on in time and where a measurement corrects it.
//!
//! ```text
//! P <- F P F' + Q                                    to the next measurement z of state k
//! S = P_kk + R,   K = P e_k / S,   P <- P - K S K'
//! e = z - x_k,    x <- x + K e
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | x, P | state and its covariance, [`Covariance`] |
//! | F, Q | transition and process noise of the step, the caller's |
//! | R, S | variances of the measurement's noise and of the innovation e |
//! | K | gain, [`Gain`] |
//!
//! A transition is a function, so that its zeros cost nothing. Numbers are scalars, or several side by side.

use core::ops::{Add, Div, Mul, Sub};

/// What a filter computes with: a number, or several side by side.
pub trait Number:
    Copy + From<f64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
}

impl<T> Number for T where
    T: Copy + From<f64> + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + Div<Output = T>
{
}

/// The symmetric P; what is below its diagonal mirrors what is above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance<T, const STATES: usize>(pub [[T; STATES]; STATES]);

/// How a measurement of one state corrects all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain<T, const STATES: usize> {
    /// K.
    pub gain: [T; STATES],
    /// Variance S of the innovation.
    pub variance: T,
    /// 1/S.
    pub precision: T,
}

impl<T: Number, const STATES: usize> Covariance<T, STATES> {
    /// F P F', without the noise of the process.
    #[inline(always)]
    #[must_use]
    pub fn advanced(&self, transition: impl Fn([T; STATES]) -> [T; STATES]) -> Self {
        let mut columns = self.0;
        for column in &mut columns {
            *column = transition(*column);
        }
        let mut next = self.0;
        for i in 0..STATES {
            let mut row = columns[i];
            for (of_row, column) in row.iter_mut().zip(&columns) {
                *of_row = column[i];
            }
            let row = transition(row);
            for j in i..STATES {
                (next[i][j], next[j][i]) = (row[j], row[j]);
            }
        }
        Self(next)
    }

    /// Takes a measurement of one state with noise of this variance.
    ///
    /// ```
    /// use seatrial_core::whitening::Covariance;
    ///
    /// // Of a heading as uncertain as its measurement half is left, and a yaw rate that goes with it is corrected, too.
    /// let mut p = Covariance([[1.0, 0.5], [0.5, 1.0]]);
    /// let gain = p.measure(0, 1.0);
    /// assert_eq!((gain.gain, gain.variance), ([0.5, 0.25], 2.0));
    /// assert_eq!(p, Covariance([[0.5, 0.25], [0.25, 0.875]]));
    /// ```
    #[inline(always)]
    pub fn measure(&mut self, measured: usize, noise: T) -> Gain<T, STATES> {
        let row = self.0[measured];
        let variance = row[measured] + noise;
        let precision = T::from(1.0) / variance;
        let mut gain = row;
        for of_state in &mut gain {
            *of_state = *of_state * precision;
        }
        let p = &mut self.0;
        for i in 0..STATES {
            for j in i..STATES {
                let left = p[i][j] - gain[i] * row[j];
                (p[i][j], p[j][i]) = (left, left);
            }
        }
        Gain { gain, variance, precision }
    }
}

impl<T: Number, const STATES: usize> Gain<T, STATES> {
    /// Corrects a state by the innovation of the state that was measured.
    #[inline(always)]
    pub fn correct(&self, state: &mut [T; STATES], innovation: T) {
        for (of_state, gain) in state.iter_mut().zip(&self.gain) {
            *of_state = *of_state + *gain * innovation;
        }
    }
}
