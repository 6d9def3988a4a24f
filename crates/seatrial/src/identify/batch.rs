//! Batch least squares (34) on the filtered samples.

use seatrial_core::YawModel;

/// The least squares solution of (32)-(34), one row at a time.
///
/// ```text
/// Theta = arg min |Q - Phi Theta|^2                 (34)
/// ```
///
/// | symbol | meaning |
/// |---|---|
/// | Q | filtered yaw acceleration (32), rad/s^2 |
/// | Phi | rows [filtered yaw rate, filtered rudder, 1] (33) |
///
/// The triangular factor of the QR decomposition of [Phi, Q] is kept and every row is rotated into
/// it (Givens), so the numbers are those of the whole matrix at once while memory does not grow, and
/// the condition number is not squared as the normal equations would.
#[derive(Clone, Copy, Debug, Default)]
pub struct BatchLeastSquares {
    /// Upper triangle of [R, Q^T q]; the last row is the root of the residual sum of squares.
    triangle: [[f64; 4]; 4],
}

impl BatchLeastSquares {
    /// Adds a row: Phi_f (15) and the filtered yaw acceleration.
    pub fn add(&mut self, regressor: [f64; 3], yaw_acceleration: f64) {
        let [rate, rudder, one] = regressor;
        let mut row = [rate, rudder, one, yaw_acceleration];
        for k in 0..4 {
            let pivot = self.triangle[k][k];
            let radius = (pivot * pivot + row[k] * row[k]).sqrt();
            if radius == 0.0 {
                continue;
            }
            let inverse = 1.0 / radius;
            let (c, s) = (pivot * inverse, row[k] * inverse);
            for (upper, lower) in self.triangle[k][k..].iter_mut().zip(&mut row[k..]) {
                (*upper, *lower) = (c * *upper + s * *lower, c * *lower - s * *upper);
            }
        }
    }

    /// The solution. `None` where Phi has not full rank: nothing excited the vehicle.
    ///
    /// ```
    /// use seatrial::identify::batch::BatchLeastSquares;
    /// use seatrial_core::YawModel;
    ///
    /// let (truth, mut batch) = (YawModel::from_theta([-1.0, 2.0, 0.1]), BatchLeastSquares::default());
    /// for (yaw_rate, rudder) in [(0.0, 0.2), (0.1, 0.2), (0.2, -0.2)] {
    ///     batch.add([yaw_rate, rudder, 1.0], truth.yaw_acceleration(yaw_rate, rudder));
    /// }
    /// let found = batch.solve().ok_or("three rows of full rank")?;
    /// assert!((found.b2_per_s2 - 2.0).abs() < 1e-9);
    /// assert!(BatchLeastSquares::default().solve().is_none());
    /// # Ok::<(), &str>(())
    /// ```
    pub fn solve(&self) -> Option<YawModel<f64>> {
        let r = &self.triangle;
        let largest = (0..3).map(|k| r[k][k].abs()).fold(0.0, f64::max);
        // A pivot this small beside the others is rounding.
        let threshold = largest * 3.0 * f64::EPSILON;
        let mut theta = [0.0; 3];
        for k in (0..3).rev() {
            if r[k][k].abs() <= threshold {
                return None;
            }
            let known: f64 = (k + 1..3).map(|j| r[k][j] * theta[j]).sum();
            theta[k] = (r[k][3] - known) / r[k][k];
        }
        theta.iter().all(|p| p.is_finite()).then(|| YawModel::from_theta(theta))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_batch_recovers_the_parameters_of_consistent_rows() {
        let truth = [-1.07, 1.08, 0.012];
        let mut batch = BatchLeastSquares::default();
        for k in 0..50 {
            let t = f64::from(k) * 0.1;
            let row = [t.sin(), (1.7 * t).cos(), 1.0];
            batch.add(row, row.iter().zip(truth).map(|(x, p)| x * p).sum());
        }
        let found = batch.solve().unwrap().theta();
        for (a, b) in found.iter().zip(truth) {
            // Rounding of 50 rotations.
            assert!((a - b).abs() < 1e-13, "{found:?}");
        }
    }

    #[test]
    fn prop_batch_without_excitation_has_no_solution() {
        let mut batch = BatchLeastSquares::default();
        assert_eq!(batch.solve(), None);
        for _ in 0..10 {
            batch.add([0.0, 0.1, 1.0], 0.02);
        }
        assert_eq!(batch.solve(), None);
    }
}
