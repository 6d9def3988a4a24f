//! The derivative of a sampled signal by local polynomials: the measured yaw rate of Fig. 15.

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
#[non_exhaustive]
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
        let mut known: Option<Weights> = None;
        let slope = |i: usize| {
            let first = i
                .saturating_sub(self.half_window)
                .min(values.len() - window);
            let times_s = Offsets {
                times_s: &times_s[first..first + window],
                centre: i - first,
            };
            let weights = match known.take().filter(|known| known.are_of(&times_s)) {
                Some(weights) => weights,
                None => self.weights(&times_s),
            };
            let slope = weights.slope(&values[first..first + window]);
            known = Some(weights);
            slope
        };
        Ok((0..values.len()).map(slope).collect())
    }

    /// The weights of the slope of the polynomial through a window, by polynomials that are orthogonal over its times x:
    ///
    /// ```text
    /// p_0 = 1,  p_k+1 = (x - alpha_k) p_k - beta_k p_k-1,  alpha_k = sum x p_k^2 / n_k,  beta_k = n_k / n_k-1,  n_k = sum p_k^2
    /// w_j = sum_k p_k'(0) p_k(x_j) / n_k
    /// ```
    ///
    /// x is scaled to the window's length and 0 where the slope is asked for. Source: Forsythe, J. SIAM 5 (1957).
    fn weights(self, times_s: &Offsets) -> Weights {
        let offsets_s: Vec<f64> = times_s.all().collect();
        let length_s = times_s.length_s();
        let x: Vec<f64> = offsets_s.iter().map(|offset| offset / length_s).collect();
        let mut of_values = vec![0.0; x.len()];
        let (mut before, mut here) = (vec![0.0; x.len()], vec![1.0; x.len()]);
        let (mut norm_before, mut norm) = (1.0, x.len() as f64);
        // Value and slope where the slope is asked for, of the polynomial before and of this one.
        let (mut at_before, mut at) = ([0.0; 2], [1.0, 0.0]);
        for power in 0..self.order {
            let alpha = x.iter().zip(&here).map(|(x, p)| x * p * p).sum::<f64>() / norm;
            let beta = if power == 0 { 0.0 } else { norm / norm_before };
            for (x, (before, here)) in x.iter().zip(before.iter_mut().zip(&mut here)) {
                let next = (x - alpha) * *here - beta * *before;
                *before = std::mem::replace(here, next);
            }
            let [value, slope] = at;
            let next = [
                -alpha * value - beta * at_before[0],
                value - alpha * slope - beta * at_before[1],
            ];
            (at_before, at) = (at, next);
            (norm_before, norm) = (norm, here.iter().map(|p| p * p).sum());
            let share = at[1] / (norm * length_s);
            for (weight, p) in of_values.iter_mut().zip(&here) {
                *weight += share * p;
            }
        }
        Weights {
            offsets_s,
            length_s,
            of_values,
        }
    }
}

/// The times of a window.
struct Offsets<'a> {
    times_s: &'a [f64],
    /// Where among them the slope is asked for.
    centre: usize,
}

impl Offsets<'_> {
    fn length_s(&self) -> f64 {
        self.times_s[self.times_s.len() - 1] - self.times_s[0]
    }

    /// From where the slope is asked for, s.
    fn all(&self) -> impl Iterator<Item = f64> {
        let centre_s = self.times_s[self.centre];
        self.times_s.iter().map(move |time_s| time_s - centre_s)
    }
}

/// What each value of a window adds to the slope.
struct Weights {
    offsets_s: Vec<f64>,
    length_s: f64,
    of_values: Vec<f64>,
}

impl Weights {
    /// Times of an even clock differ by their rounding.
    const SAME_SHARE: f64 = 1e-9;

    fn are_of(&self, times_s: &Offsets) -> bool {
        let same_s = Self::SAME_SHARE * self.length_s;
        let mut pairs = self.offsets_s.iter().zip(times_s.all());
        pairs.all(|(known_s, offset_s)| (known_s - offset_s).abs() <= same_s)
    }

    fn slope(&self, values: &[f64]) -> f64 {
        let terms = self.of_values.iter().zip(values);
        terms.map(|(weight, value)| weight * value).sum()
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
