//! The derivative of a sampled signal by local polynomials: the measured yaw rate of Fig. 15.

use nalgebra::{DMatrix, DVector};

/// A Savitzky-Golay derivative filter.
///
/// At each sample a polynomial in time is fitted by least squares to the `2 half_window + 1` samples
/// around it, and its derivative is taken there. Near the ends the window is the first or last full
/// one, so the polynomial is read off its centre (scipy's `mode="interp"`). Times enter as they are:
/// the interval need not be constant.
///
/// Source: Savitzky and Golay, Analytical Chemistry 36 (1964).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SavitzkyGolay {
    half_window: usize,
    order: usize,
}

/// Why there is no filter or no derivative.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoDerivative {
    /// The polynomial must have a slope and fewer coefficients than the window has samples.
    #[error(
        "order {order} with {window} samples: the order must be at least 1 and under the number of samples"
    )]
    Order {
        /// Order of the polynomial.
        order: usize,
        /// Samples in a window.
        window: usize,
    },
    /// The record is shorter than a window.
    #[error("{found} samples, a window needs {window}")]
    TooShort {
        /// Samples given.
        found: usize,
        /// Samples in a window.
        window: usize,
    },
    /// As many times as values are needed.
    #[error("{times} times for {values} values")]
    Lengths {
        /// Times given.
        times: usize,
        /// Values given.
        values: usize,
    },
    /// Time must increase and everything be finite.
    #[error("sample {index} (from 0): not finite, or time does not increase")]
    Sample {
        /// Which sample.
        index: usize,
    },
}

impl SavitzkyGolay {
    /// A filter with polynomials of this order over `2 half_window + 1` samples.
    pub fn new(half_window: usize, order: usize) -> Result<Self, NoDerivative> {
        let filter = Self { half_window, order };
        let window = filter.window();
        if order < 1 || order >= window {
            return Err(NoDerivative::Order { order, window });
        }
        Ok(filter)
    }

    fn window(self) -> usize {
        2 * self.half_window + 1
    }

    /// The derivative at every sample, in units of the value per second.
    pub fn derivative(self, times_s: &[f64], values: &[f64]) -> Result<Vec<f64>, NoDerivative> {
        let window = self.window();
        if times_s.len() != values.len() {
            return Err(NoDerivative::Lengths {
                times: times_s.len(),
                values: values.len(),
            });
        }
        if values.len() < window {
            return Err(NoDerivative::TooShort {
                found: values.len(),
                window,
            });
        }
        let finite = |i: &usize| times_s[*i].is_finite() && values[*i].is_finite();
        let increases = |i: &usize| *i == 0 || times_s[*i] > times_s[*i - 1];
        if let Some(index) = (0..values.len()).find(|i| !finite(i) || !increases(i)) {
            return Err(NoDerivative::Sample { index });
        }
        let slope = |i: usize| {
            let first = i
                .saturating_sub(self.half_window)
                .min(values.len() - window);
            self.slope_at(
                times_s[i],
                &times_s[first..first + window],
                &values[first..first + window],
            )
        };
        Ok((0..values.len()).map(slope).collect())
    }

    /// The slope at `time_s` of the polynomial through a window, in times scaled to its length.
    fn slope_at(self, time_s: f64, times_s: &[f64], values: &[f64]) -> f64 {
        let length = times_s[times_s.len() - 1] - times_s[0];
        let powers = DMatrix::from_fn(times_s.len(), self.order + 1, |row, column| {
            ((times_s[row] - time_s) / length).powi(column as i32)
        });
        let mut right_hand_side = DVector::from_row_slice(values);
        let qr = powers.qr();
        qr.q_tr_mul(&mut right_hand_side);
        let coefficients = qr
            .r()
            .solve_upper_triangular(&right_hand_side.rows(0, self.order + 1).into_owned());
        // Increasing times make the columns independent, so that there is a solution.
        coefficients.map_or(f64::NAN, |c| c[1] / length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// scipy.signal.savgol_filter(v, 9, 3, deriv=1, delta=0.05, mode="interp") with
    /// v = sin(0.3 k) + 0.1 cos(17 k), k = 0..30.
    #[test]
    fn val_scipy_savgol_filter() {
        let values: Vec<f64> = (0..30)
            .map(f64::from)
            .map(|k| (0.3 * k).sin() + 0.1 * (17.0 * k).cos())
            .collect();
        let times: Vec<f64> = (0..30).map(|k| 7.0 + 0.05 * f64::from(k)).collect();
        let filter = SavitzkyGolay::new(4, 3).unwrap();
        let found = filter.derivative(&times, &values).unwrap();
        for (k, expected) in [
            (0, 4.585657638882445),
            (1, 4.784703962750279),
            (4, 2.6267179982608067),
            (15, -0.9968048373327485),
            (26, 0.668472078246673),
            (29, -7.208480107347115),
        ] {
            // Rounding of the times, 7 * 1e-16 of 0.05 s, times the size of the slope.
            assert!((found[k] - expected).abs() < 1e-11, "{k}: {}", found[k]);
        }
    }

    /// A polynomial of the filter's order is differentiated exactly, at uneven times and at the ends.
    #[test]
    fn exact_polynomial_at_uneven_times() {
        let times: Vec<f64> = (0..40)
            .map(f64::from)
            .map(|k| 0.05 * k + 0.02 * (5.0 * k).sin())
            .collect();
        let values: Vec<f64> = times
            .iter()
            .map(|t| 1.0 - 2.0 * t + 0.7 * t.powi(3))
            .collect();
        let filter = SavitzkyGolay::new(5, 3).unwrap();
        let found = filter.derivative(&times, &values).unwrap();
        for (t, slope) in times.iter().zip(found) {
            // Rounding of values of order 5 over a window of half a second.
            assert!((slope - (-2.0 + 2.1 * t * t)).abs() < 1e-11);
        }
    }

    #[test]
    fn exact_refusals_have_reasons() {
        assert!(matches!(
            SavitzkyGolay::new(1, 3),
            Err(NoDerivative::Order { .. })
        ));
        assert!(SavitzkyGolay::new(1, 0).is_err());
        let filter = SavitzkyGolay::new(1, 1).unwrap();
        assert!(matches!(
            filter.derivative(&[0.0, 1.0], &[0.0, 1.0]),
            Err(NoDerivative::TooShort { .. })
        ));
        assert!(matches!(
            filter.derivative(&[0.0, 1.0], &[0.0]),
            Err(NoDerivative::Lengths { .. })
        ));
        assert_eq!(
            filter.derivative(&[0.0, 1.0, 1.0], &[0.0; 3]),
            Err(NoDerivative::Sample { index: 2 })
        );
        assert_eq!(
            filter.derivative(&[0.0, 1.0, 2.0], &[0.0, f64::NAN, 0.0]),
            Err(NoDerivative::Sample { index: 1 })
        );
    }
}
