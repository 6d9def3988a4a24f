//! Recursive least squares.

use core::array::from_fn;

use crate::Real;

/// How fast old samples lose weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forgetting<T> {
    /// mu, by which the weight of every sample is multiplied when the next one comes, in (0, 1]; 1 forgets nothing.
    pub factor: T,
    /// No more is forgotten than keeps the trace of the covariance within this.
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
/// Without excitation a forgetting factor would blow P up, and so would, slowly, roundings in `f32`. Here mu is the larger
/// of the forgetting factor and trace(P)/`trace_limit`, so that trace(P) never exceeds the limit. Regressors or observations so large that the update overflows are ignored.
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
    ///
    /// ```
    /// use seatrial_core::RecursiveLeastSquares;
    ///
    /// let least_squares = RecursiveLeastSquares::<f64, 2>::new(100.0);
    /// assert_eq!(least_squares.covariance(), [[100.0, 0.0], [0.0, 100.0]]);
    /// ```
    pub fn new(initial_covariance: T) -> Self {
        let mut factors = [[T::ZERO; N]; N];
        for (i, row) in factors.iter_mut().enumerate() {
            row[i] = initial_covariance;
        }
        Self { theta: [T::ZERO; N], factors }
    }

    /// Theta, in the order of the regressor.
    pub fn theta(&self) -> [T; N] {
        self.theta
    }

    /// P = U D U^T.
    pub fn covariance(&self) -> [[T; N]; N] {
        // Optimising for size the compiler does not see that indices are below N, and would leave a panic path.
        let factor = |i: usize, j: usize| {
            let row = self.factors.get(i);
            *row.and_then(|row| row.get(j)).unwrap_or(&T::ZERO)
        };
        let unit = |i: usize, j: usize| if i == j { T::ONE } else { factor(i, j) };
        from_fn(|i| {
            from_fn(|j| {
                let (first, last) = (i.min(j), i.max(j));
                (last..N).map(|k| unit(first, k) * factor(k, k) * unit(last, k)).sum()
            })
        })
    }

    /// Forgets the first parameter, as if nothing but its variance were known of it.
    ///
    /// ```
    /// use seatrial_core::{Forgetting, RecursiveLeastSquares};
    ///
    /// let mut least_squares = RecursiveLeastSquares::<f64, 1>::new(1e6);
    /// least_squares.update([1.0], 3.0, Forgetting { factor: 1.0, trace_limit: 1e9 });
    /// least_squares.reset_first(4.0);
    /// assert_eq!((least_squares.theta(), least_squares.covariance()), ([0.0], [[4.0]]));
    /// ```
    pub fn reset_first(&mut self, variance: T) {
        if let (Some(theta), Some(row)) = (self.theta.first_mut(), self.factors.first_mut()) {
            *theta = T::ZERO;
            *row = [T::ZERO; N];
            row[0] = variance;
        }
    }

    /// Learns from one sample; returns whether it could (it ignores one that overflows).
    ///
    /// ```
    /// use seatrial_core::{Forgetting, RecursiveLeastSquares};
    ///
    /// let mut least_squares = RecursiveLeastSquares::<f64, 2>::new(1e6);
    /// let forgetting = Forgetting { factor: 1.0, trace_limit: 1e9 };
    /// // The line y = 1 + 2 x through three points.
    /// for x in [0.0, 1.0, 2.0] {
    ///     assert!(least_squares.update([1.0, x], 1.0 + 2.0 * x, forgetting));
    /// }
    /// assert!((least_squares.theta()[1] - 2.0).abs() < 1e-5);
    /// // What overflows is ignored.
    /// assert!(!least_squares.update([1.0, 1e300], 0.0, forgetting));
    /// ```
    pub fn update(&mut self, regressor: [T; N], observation: T, forgetting: Forgetting<T>) -> bool {
        let mu = self.weight(forgetting);
        self.learn(0, &regressor, observation, mu)
    }

    /// [`update`](Self::update), bit for bit, while the first parameter has no variance ([`reset_first`](Self::reset_first)) and the first
    /// regressor is 0.
    #[inline]
    pub(crate) fn update_without_first(
        &mut self,
        regressor: &[T; N],
        observation: T,
        forgetting: Forgetting<T>,
    ) -> bool {
        let mu = self.weight(forgetting);
        // What the first row takes from the others is a product with 0, which stays 0 while the other factor is finite: f/alpha is, where
        // alpha >= mu >= 1.
        match mu >= T::ONE {
            true => self.learn(1, regressor, observation, mu),
            false => self.learn(0, regressor, observation, mu),
        }
    }

    /// Bierman's update of the parameters from `first` on; those before have no variance and their regressors are 0.
    #[expect(clippy::needless_range_loop, reason = "iterators that skip take a quarter more time")]
    #[inline]
    fn learn(&mut self, first: usize, regressor: &[T; N], observation: T, mu: T) -> bool {
        let growth = T::ONE / mu;
        let mut factors = self.factors;
        let mut gain = [T::ZERO; N];
        let (mut alpha, mut inverse) = (mu, growth);
        for j in first..N {
            let mut f = regressor[j];
            for i in first..j {
                f += factors[i][j] * regressor[i];
            }
            let g = factors[j][j] * f;
            let p = f * inverse;
            let next = alpha + f * g;
            inverse = T::ONE / next;
            factors[j][j] = factors[j][j] * growth * (alpha * inverse);
            for i in first..j {
                let u = factors[i][j];
                factors[i][j] = u - gain[i] * p;
                gain[i] += u * g;
            }
            gain[j] = g;
            alpha = next;
        }

        let mut innovation = observation;
        for j in first..N {
            innovation -= regressor[j] * self.theta[j];
        }
        let step = innovation * inverse;
        if !(alpha.is_finite() && step.is_finite()) {
            return false;
        }
        for j in first..N {
            self.theta[j] += gain[j] * step;
        }
        self.factors = factors;
        true
    }

    /// mu, or what keeps the trace within its limit.
    #[inline]
    fn weight(&self, forgetting: Forgetting<T>) -> T {
        let trace = self.trace();
        if trace > forgetting.trace_limit * forgetting.factor {
            trace / forgetting.trace_limit
        } else {
            forgetting.factor
        }
    }

    #[inline]
    fn trace(&self) -> T {
        let mut trace = T::ZERO;
        for j in 0..N {
            let mut above = T::ZERO;
            for i in 0..j {
                above += self.factors[i][j] * self.factors[i][j];
            }
            trace += self.factors[j][j] * (T::ONE + above);
        }
        trace
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEEP_ALL: Forgetting<f64> = Forgetting { factor: 1.0, trace_limit: 3e6 };

    /// The textbook recursion on the full matrix, in f64 where it can still be trusted.
    #[test]
    fn exact_equals_the_printed_recursion_corrected() {
        let mut recursion = RecursiveLeastSquares::<f64, 3>::new(100.0);
        let mut theta = [0.0; 3];
        let mut p = [[100.0, 0.0, 0.0], [0.0, 100.0, 0.0], [0.0, 0.0, 100.0]];
        let mu = 0.98;
        for k in 0..200 {
            let t = f64::from(k) * 0.1;
            let phi = [t.sin(), (1.7 * t).cos(), 1.0];
            let y = -1.07 * phi[0] + 1.08 * phi[1] + 0.012 + 0.01 * (31.0 * t).sin();
            let p_phi: [f64; 3] = from_fn(|i| (0..3).map(|j| p[i][j] * phi[j]).sum());
            let scale = mu + (0..3).map(|i| phi[i] * p_phi[i]).sum::<f64>();
            let e = y - (0..3).map(|i| phi[i] * theta[i]).sum::<f64>();
            theta = from_fn(|i| theta[i] + p_phi[i] * e / scale);
            p = from_fn(|i| from_fn(|j| (p[i][j] - p_phi[i] * p_phi[j] / scale) / mu));
            let forgetting = Forgetting { factor: mu, trace_limit: 1e9 };
            assert!(recursion.update(phi, y, forgetting));
        }
        // 200 updates of a well conditioned problem.
        let close =
            |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(close(&recursion.theta(), &theta));
        for (found, expected) in recursion.covariance().iter().zip(&p) {
            assert!(close(found, expected));
        }
    }

    /// Ten million samples of a vehicle on a straight course, whose regressors never change.
    fn idle<T: Real>(factor: f64) {
        let limit = T::of(3e6);
        let forgetting = Forgetting { factor: T::of(factor), trace_limit: limit };
        let mut recursion = RecursiveLeastSquares::<T, 3>::new(T::of(1e6));
        let phi = [T::of(0.001), T::of(-0.011), T::ONE];
        for _ in 0..10_000_000 {
            let _ = recursion.update(phi, T::of(0.002), forgetting);
        }
        let p = recursion.covariance();
        let trace = p[0][0] + p[1][1] + p[2][2];
        // The limit, and the rounding of a sum of three.
        assert!(trace <= limit * (T::ONE + T::of(4.0) * T::EPSILON), "{trace}");
        assert!(recursion.theta().iter().all(|theta| theta.is_finite()));
        assert!(p[0][0] > T::ZERO && p[1][1] > T::ZERO && p[2][2] > T::ZERO);
        // It still learns: one strong sample in the direction that was never excited.
        let before = recursion.theta()[0];
        assert!(recursion.update([T::ONE, T::ZERO, T::ZERO], before + T::ONE, forgetting));
        assert!((recursion.theta()[0] - before - T::ONE).abs() < T::of(1e-3));
    }

    #[test]
    fn prop_covariance_is_bounded_over_ten_million_idle_samples_f64() {
        idle::<f64>(1.0);
        idle::<f64>(0.95);
    }

    #[test]
    fn prop_covariance_is_bounded_over_ten_million_idle_samples_f32() {
        idle::<f32>(1.0);
        idle::<f32>(0.95);
    }

    #[test]
    fn exact_what_overflows_is_ignored() {
        let mut recursion = RecursiveLeastSquares::<f32, 3>::new(1e6);
        let keep = Forgetting { factor: 1.0, trace_limit: 3e6 };
        let _ = recursion.update([0.1, 0.2, 1.0], 0.3, keep);
        let before = recursion;
        for (phi, y) in
            [([1e30, 0.0, 1.0], 0.0), ([0.1, 0.2, 1.0], f32::INFINITY), ([f32::NAN, 0.2, 1.0], 0.0)]
        {
            assert!(!recursion.update(phi, y, keep));
            assert_eq!(recursion, before);
        }
    }

    /// Without its first parameter the recursion is that of the others.
    #[test]
    fn exact_a_first_parameter_of_no_variance_is_not_there() {
        let mut with = RecursiveLeastSquares::<f64, 3>::new(50.0);
        let mut without = RecursiveLeastSquares::<f64, 2>::new(50.0);
        with.reset_first(0.0);
        for k in 0..30 {
            let x = f64::from(k).sin();
            let _ = with.update([0.7 * x, x, 1.0], 3.0 * x - 0.2, KEEP_ALL);
            let _ = without.update([x, 1.0], 3.0 * x - 0.2, KEEP_ALL);
        }
        assert_eq!(with.theta()[1..], without.theta());
        assert_eq!(with.theta()[0], 0.0);
    }
}
