//! The derivative of a sampled signal by local polynomials: the measured yaw rate of Fig. 15.

use std::ops::Range;

use crate::record::even_interval_s;

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
    ///
    /// ```
    /// use seatrial::log::{NoDerivative, SavitzkyGolay};
    ///
    /// // A cubic needs more than three samples.
    /// let error = NoDerivative::Order { order: 3, window: 3 };
    /// assert_eq!(SavitzkyGolay::new(1, 3).err(), Some(error));
    /// ```
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
    ///
    /// ```
    /// use seatrial::log::{NoDerivative, SavitzkyGolay};
    ///
    /// let filter = SavitzkyGolay::new(2, 2)?;
    /// let times_s: Vec<f64> = (0..20).map(|k| 0.1 * f64::from(k)).collect();
    /// let squares: Vec<f64> = times_s.iter().map(|t| t * t).collect();
    /// // Exact for polynomials of its order, at the ends, too.
    /// let slopes = filter.derivative(&times_s, &squares)?;
    /// assert!(slopes.iter().zip(&times_s).all(|(slope, t)| (slope - 2.0 * t).abs() < 1e-9));
    /// let short = filter.derivative(&times_s[..4], &squares[..4]);
    /// assert_eq!(short, Err(NoDerivative::TooShort { found: 4, window: 5 }));
    /// # Ok::<(), NoDerivative>(())
    /// ```
    pub fn derivative(self, times_s: &[f64], values: &[f64]) -> Result<Vec<f64>, NoDerivative> {
        let window = self.window();
        if times_s.len() != values.len() {
            return Err(NoDerivative::Lengths { times: times_s.len(), values: values.len() });
        }
        if values.len() < window {
            return Err(NoDerivative::TooShort { found: values.len(), window });
        }
        let finite = |i: &usize| times_s[*i].is_finite() && values[*i].is_finite();
        let increases = |i: &usize| *i == 0 || times_s[*i] > times_s[*i - 1];
        if let Some(index) = (0..values.len()).find(|i| !finite(i) || !increases(i)) {
            return Err(NoDerivative::Sample { index });
        }
        let polynomials = |first: usize| Polynomials::over(&times_s[first..first + window], self);
        let behind = values.len() - self.half_window;
        let at_the_end = |first: usize, samples: Range<usize>| {
            let fitted = polynomials(first).fitted(&values[first..first + window]);
            samples.map(move |i| fitted.slope(times_s[i]))
        };
        // Two offsets differ by no more than four times what times are off an even grid.
        let off_the_grid = 0.25 * Weights::SAME_SHARE * (window - 1) as f64;
        let is_even = even_interval_s(times_s, off_the_grid).is_some();
        let mut known: Option<Weights> = None;
        let in_the_middle = (self.half_window..behind).map(|i| {
            let first = i - self.half_window;
            let times_s = &times_s[first..first + window];
            let weights = match known.take() {
                Some(known) if is_even || known.are_of(times_s) => known,
                _ => polynomials(first).weights(),
            };
            let slope = weights.slope(&values[first..first + window]);
            known = Some(weights);
            slope
        });
        Ok(at_the_end(0, 0..self.half_window)
            .chain(in_the_middle)
            .chain(at_the_end(values.len() - window, behind..values.len()))
            .collect())
    }
}

/// Polynomials that are orthogonal over the times x of a window:
///
/// ```text
/// p_0 = 1,  p_k+1 = (x - alpha_k) p_k - beta_k p_k-1,  alpha_k = sum x p_k^2 / n_k,  beta_k = n_k / n_k-1,  n_k = sum p_k^2
/// ```
///
/// x is 0 at the window's middle sample and scaled to its length. Source: Forsythe, J. SIAM 5 (1957).
struct Polynomials<'a> {
    times_s: &'a [f64],
    /// p_k at each sample, k = 1 to the order.
    of_order: Vec<Order>,
}

/// A polynomial over its window.
struct Order {
    alpha: f64,
    beta: f64,
    /// n_k.
    norm: f64,
    values: Vec<f64>,
}

impl<'a> Polynomials<'a> {
    fn over(times_s: &'a [f64], filter: SavitzkyGolay) -> Self {
        let length_s = length_s(times_s);
        let x: Vec<f64> = offsets_s(times_s).map(|offset| offset / length_s).collect();
        let mut of_order: Vec<Order> = Vec::with_capacity(filter.order);
        let (mut before, mut here) = (vec![0.0; x.len()], vec![1.0; x.len()]);
        let (mut norm_before, mut norm) = (1.0, x.len() as f64);
        for power in 0..filter.order {
            let alpha = x.iter().zip(&here).map(|(x, p)| x * p * p).sum::<f64>() / norm;
            let beta = if power == 0 { 0.0 } else { norm / norm_before };
            for (x, (before, here)) in x.iter().zip(before.iter_mut().zip(&mut here)) {
                let next = (x - alpha) * *here - beta * *before;
                *before = std::mem::replace(here, next);
            }
            (norm_before, norm) = (norm, here.iter().map(|p| p * p).sum());
            of_order.push(Order { alpha, beta, norm, values: here.clone() });
        }
        Self { times_s, of_order }
    }

    /// The weights of the slope in the middle.
    ///
    /// ```text
    /// w_j = sum_k p_k'(0) p_k(x_j) / n_k
    /// ```
    fn weights(self) -> Weights {
        let length_s = length_s(self.times_s);
        let mut of_values = vec![0.0; self.times_s.len()];
        for (order, slope) in self.of_order.iter().zip(slopes(&self.of_order, 0.0)) {
            let share = slope / (order.norm * length_s);
            for (weight, p) in of_values.iter_mut().zip(&order.values) {
                *weight += share * p;
            }
        }
        Weights { offsets_s: offsets_s(self.times_s).collect(), length_s, of_values }
    }

    /// The polynomial that is nearest to values, but for its mean.
    fn fitted(self, values: &[f64]) -> LocalPolynomial {
        let shares = self.of_order.iter();
        let shares = shares.map(|order| dot(&order.values, values) / order.norm);
        LocalPolynomial {
            middle_s: self.times_s[self.times_s.len() / 2],
            length_s: length_s(self.times_s),
            shares: shares.collect(),
            of_order: self.of_order,
        }
    }
}

/// A polynomial as a sum of orthogonal ones.
struct LocalPolynomial {
    middle_s: f64,
    length_s: f64,
    shares: Vec<f64>,
    of_order: Vec<Order>,
}

impl LocalPolynomial {
    fn slope(&self, time_s: f64) -> f64 {
        let x = (time_s - self.middle_s) / self.length_s;
        let terms = self.shares.iter().zip(slopes(&self.of_order, x));
        terms.map(|(share, slope)| share * slope).sum::<f64>() / self.length_s
    }
}

/// p_k'(x), k = 1 to the order.
fn slopes(of_order: &[Order], x: f64) -> impl Iterator<Item = f64> {
    // Value and slope of the polynomial before and of this one.
    let (mut before, mut here) = ([0.0; 2], [1.0, 0.0]);
    of_order.iter().map(move |order| {
        let [value, slope] = here;
        let next = [
            (x - order.alpha) * value - order.beta * before[0],
            value + (x - order.alpha) * slope - order.beta * before[1],
        ];
        (before, here) = (here, next);
        next[1]
    })
}

fn length_s(times_s: &[f64]) -> f64 {
    times_s[times_s.len() - 1] - times_s[0]
}

/// From the middle sample, s.
fn offsets_s(times_s: &[f64]) -> impl Iterator<Item = f64> {
    let middle_s = times_s[times_s.len() / 2];
    times_s.iter().map(move |time_s| time_s - middle_s)
}

/// What each value of a window adds to the slope in its middle.
struct Weights {
    offsets_s: Vec<f64>,
    length_s: f64,
    of_values: Vec<f64>,
}

impl Weights {
    /// Times of an even clock differ by their rounding.
    const SAME_SHARE: f64 = 1e-9;

    fn are_of(&self, times_s: &[f64]) -> bool {
        let same_s = Self::SAME_SHARE * self.length_s;
        let mut pairs = self.offsets_s.iter().zip(offsets_s(times_s));
        pairs.all(|(known_s, offset_s)| (known_s - offset_s).abs() <= same_s)
    }

    fn slope(&self, values: &[f64]) -> f64 {
        dot(&self.of_values, values)
    }
}

/// The sum of products, in four sums side by side.
fn dot(left: &[f64], right: &[f64]) -> f64 {
    const SUMS: usize = 4;
    let (left, right) = (left.chunks_exact(SUMS), right.chunks_exact(SUMS));
    let rest = left.remainder().iter().zip(right.remainder());
    let mut sums = [0.0; SUMS];
    sums[0] = rest.map(|(left, right)| left * right).sum();
    for (left, right) in left.zip(right) {
        for (sum, (left, right)) in sums.iter_mut().zip(left.iter().zip(right)) {
            *sum += left * right;
        }
    }
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// scipy.signal.savgol_filter(v, 9, 3, deriv=1, delta=0.05, mode="interp") with
    /// v = sin(0.3 k) + 0.1 cos(17 k), k = 0..30.
    #[test]
    fn val_scipy_savgol_filter() {
        let values: Vec<f64> =
            (0..30).map(f64::from).map(|k| (0.3 * k).sin() + 0.1 * (17.0 * k).cos()).collect();
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
        let times: Vec<f64> =
            (0..40).map(f64::from).map(|k| 0.05 * k + 0.02 * (5.0 * k).sin()).collect();
        let values: Vec<f64> = times.iter().map(|t| 1.0 - 2.0 * t + 0.7 * t.powi(3)).collect();
        let filter = SavitzkyGolay::new(5, 3).unwrap();
        let found = filter.derivative(&times, &values).unwrap();
        for (t, slope) in times.iter().zip(found) {
            // Rounding of values of order 5 over a window of half a second.
            assert!((slope - (-2.0 + 2.1 * t * t)).abs() < 1e-11);
        }
    }

    #[test]
    fn exact_refusals_have_reasons() {
        assert!(matches!(SavitzkyGolay::new(1, 3), Err(NoDerivative::Order { .. })));
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
