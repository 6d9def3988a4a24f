//! Recursive least squares.

use core::array::from_fn;

use crate::Real;

/// How fast old samples lose weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forgetting<T> {
    /// Weight of a sample against the next one, in (0, 1]; 1 forgets nothing.
    pub factor: T,
    /// Nothing is forgotten while that would take the trace of the covariance above this.
    pub trace_limit: T,
}

/// Recursive least squares for y = Phi^T Theta.
///
/// ```text
/// e = y - Phi^T Theta
/// K = P Phi / (mu + Phi^T P Phi)
/// Theta <- Theta + K e
/// P <- (I - K Phi^T) P / mu
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | Theta | [`theta`](Self::theta) | the parameters' |
/// | Phi | `regressor` | the regressors' |
/// | y | `observation` | the observation's |
/// | e | innovation | the observation's |
/// | P | [`covariance`](Self::covariance) | parameter^2 per observation^2 |
/// | mu | [`Forgetting::factor`] | 1 |
///
/// Source: the paper's recursion, whose printed update of P holds the scalar K^T Phi, with which it never
/// learns; corrected here. P is kept as U D U^T with U unit upper triangular and D diagonal (Bierman's
/// update), so it is symmetric and positive by construction, also in `f32` from P0 = 1e6 I, where the
/// printed form loses its sign.
///
/// Without excitation a forgetting factor would blow P up. Here a sample is weighted with mu only while
/// trace(P)/mu stays within `trace_limit`, otherwise with 1; as each update lowers the trace, it
/// never exceeds the limit. Regressors or observations so large that the update overflows are ignored.
///
/// Cost for N = 3: about 60 floating-point operations, 3 of them divisions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecursiveLeastSquares<T, const N: usize> {
    theta: [T; N],
    /// U above the diagonal, D on it.
    factors: [[T; N]; N],
}

impl<T: Real, const N: usize> RecursiveLeastSquares<T, N> {
    /// Theta = 0 and P = `initial_covariance` I.
    pub fn new(initial_covariance: T) -> Self {
        let mut factors = [[T::ZERO; N]; N];
        for (i, row) in factors.iter_mut().enumerate() {
            row[i] = initial_covariance;
        }
        Self {
            theta: [T::ZERO; N],
            factors,
        }
    }

    /// The parameter vector.
    pub fn theta(&self) -> [T; N] {
        self.theta
    }

    /// P = U D U^T.
    pub fn covariance(&self) -> [[T; N]; N] {
        let unit = |i: usize, j: usize| if i == j { T::ONE } else { self.factors[i][j] };
        from_fn(|i| {
            from_fn(|j| {
                let (first, last) = (i.min(j), i.max(j));
                (last..N)
                    .map(|k| unit(first, k) * self.factors[k][k] * unit(last, k))
                    .sum()
            })
        })
    }

    /// Learns from one sample; returns whether it could (it ignores one that overflows).
    pub fn update(&mut self, regressor: [T; N], observation: T, forgetting: Forgetting<T>) -> bool {
        let mu = self.weight(forgetting);
        let growth = T::ONE / mu;
        let mut factors = self.factors;
        let mut gain = [T::ZERO; N];
        let (mut alpha, mut inverse) = (mu, growth);
        for j in 0..N {
            let mut f = regressor[j];
            for i in 0..j {
                f += factors[i][j] * regressor[i];
            }
            let g = factors[j][j] * f;
            let p = f * inverse;
            let next = alpha + f * g;
            inverse = T::ONE / next;
            factors[j][j] = factors[j][j] * growth * (alpha * inverse);
            for i in 0..j {
                let u = factors[i][j];
                factors[i][j] = u - gain[i] * p;
                gain[i] += u * g;
            }
            gain[j] = g;
            alpha = next;
        }

        let mut innovation = observation;
        for (phi, theta) in regressor.iter().zip(&self.theta) {
            innovation -= *phi * *theta;
        }
        let step = innovation * inverse;
        if !(alpha.is_finite() && step.is_finite()) {
            return false;
        }
        for (theta, gain) in self.theta.iter_mut().zip(&gain) {
            *theta += *gain * step;
        }
        self.factors = factors;
        true
    }

    fn weight(&self, forgetting: Forgetting<T>) -> T {
        if forgetting.factor < T::ONE && self.trace() <= forgetting.trace_limit * forgetting.factor
        {
            forgetting.factor
        } else {
            T::ONE
        }
    }

    fn trace(&self) -> T {
        (0..N)
            .map(|j| {
                let above: T = (0..j)
                    .map(|i| self.factors[i][j] * self.factors[i][j])
                    .sum();
                self.factors[j][j] * (T::ONE + above)
            })
            .sum()
    }
}
