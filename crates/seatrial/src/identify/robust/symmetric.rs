//! Small symmetric systems.

/// A positive definite matrix as L L^T, scaled by its diagonal first.
pub struct Factorisation<const N: usize> {
    /// L, with the reciprocals of its diagonal there.
    lower: [[f64; N]; N],
    /// Reciprocal square roots of the matrix's diagonal.
    scale: [f64; N],
    /// Logarithm of the determinant of the matrix.
    pub log_determinant: f64,
}

impl<const N: usize> Factorisation<N> {
    /// `None` where the matrix is not positive definite; only its elements on and below the diagonal count.
    pub fn of(matrix: &[[f64; N]; N]) -> Option<Self> {
        let roots: [f64; N] = core::array::from_fn(|i| matrix[i][i].sqrt());
        if !roots.iter().all(|s| *s > 0.0 && s.is_finite()) {
            return None;
        }
        let scale = roots.map(|root| 1.0 / root);
        let mut lower = [[0.0; N]; N];
        let mut log_determinant = 0.0;
        for i in 0..N {
            for j in 0..=i {
                let scaled = matrix[i][j] * scale[i] * scale[j];
                let left = scaled - dot(&lower[i][..j], &lower[j][..j]);
                if j < i {
                    lower[i][j] = left * lower[j][j];
                } else if left > 1e-14 {
                    let root = left.sqrt();
                    lower[i][i] = 1.0 / root;
                    log_determinant += 2.0 * libm::log(root * roots[i]);
                } else {
                    return None;
                }
            }
        }
        Some(Self { lower, scale, log_determinant })
    }

    /// v^T M^-1 v.
    pub fn square_of(&self, vector: &[f64; N]) -> f64 {
        let mut solved = [0.0; N];
        let mut square = 0.0;
        for i in 0..N {
            let left = vector[i] * self.scale[i] - dot(&self.lower[i][..i], &solved[..i]);
            solved[i] = left * self.lower[i][i];
            square += solved[i] * solved[i];
        }
        square
    }

    /// The inverse of the matrix.
    pub fn inverse(&self) -> [[f64; N]; N] {
        // Column by column the inverse of L, then its products.
        let mut inverse_lower = [[0.0; N]; N];
        for (j, column) in inverse_lower.iter_mut().enumerate() {
            column[j] = self.lower[j][j];
            for i in j + 1..N {
                column[i] = -dot(&self.lower[i][j..i], &column[j..i]) * self.lower[i][i];
            }
        }
        let mut inverse = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..=i {
                let sum = dot(&inverse_lower[i][i..], &inverse_lower[j][i..]);
                inverse[i][j] = sum * self.scale[i] * self.scale[j];
                inverse[j][i] = inverse[i][j];
            }
        }
        inverse
    }
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(l, r)| l * r).sum()
}

/// Inverse and log determinant of a positive definite matrix. `None` where it is not.
pub fn invert<const N: usize>(matrix: &[[f64; N]; N]) -> Option<([[f64; N]; N], f64)> {
    let factored = Factorisation::of(matrix)?;
    Some((factored.inverse(), factored.log_determinant))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_inverse_and_determinant() {
        let matrix = [[4e6, 2e3, 0.0], [2e3, 3.0, 1e-3], [0.0, 1e-3, 1e-6]];
        let (inverse, log_determinant) = invert(&matrix).unwrap();
        for (i, row) in matrix.iter().enumerate() {
            for j in 0..3 {
                let column = inverse.iter().map(|row| row[j]);
                let product: f64 = row.iter().zip(column).map(|(a, b)| a * b).sum();
                let expected = if i == j { 1.0 } else { 0.0 };
                // Rounding of numbers twelve orders apart.
                assert!((product - expected).abs() < 1e-6, "{i} {j} {product}");
            }
        }
        // 4e6 (3e-6 - 1e-6) - 2e3 (2e3 1e-6) = 4.
        assert!((log_determinant - 4.0_f64.ln()).abs() < 1e-9);
        let vector = [2e3, -1.0, 1e-3];
        let by_inverse: f64 = (0..3)
            .flat_map(|i| (0..3).map(move |j| (i, j)))
            .map(|(i, j)| vector[i] * inverse[i][j] * vector[j])
            .sum();
        let square = Factorisation::of(&matrix).unwrap().square_of(&vector);
        assert!((square / by_inverse - 1.0).abs() < 1e-9);
        assert!(invert(&[[1.0, 1.0], [1.0, 1.0]]).is_none());
    }
}
