//! Small symmetric systems.

/// Inverse and log determinant of a positive definite matrix, scaled by its diagonal first. `None` where it is not.
pub fn invert<const N: usize>(matrix: &[[f64; N]; N]) -> Option<([[f64; N]; N], f64)> {
    let scale: [f64; N] = core::array::from_fn(|i| matrix[i][i].sqrt());
    if !scale.iter().all(|s| *s > 0.0 && s.is_finite()) {
        return None;
    }
    let mut l = [[0.0; N]; N];
    let mut log_determinant = 0.0;
    for i in 0..N {
        for j in 0..=i {
            let left = matrix[i][j] / (scale[i] * scale[j])
                - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            if j < i {
                l[i][j] = left / l[j][j];
            } else if left > 1e-14 {
                l[i][i] = left.sqrt();
                log_determinant += 2.0 * (l[i][i] * scale[i]).ln();
            } else {
                return None;
            }
        }
    }
    let mut inverse = [[0.0; N]; N];
    for column in 0..N {
        let mut b = [0.0; N];
        b[column] = 1.0;
        for i in column..N {
            b[i] = (b[i] - (0..i).map(|k| l[i][k] * b[k]).sum::<f64>()) / l[i][i];
        }
        for i in (0..N).rev() {
            b[i] = (b[i] - (i + 1..N).map(|k| l[k][i] * b[k]).sum::<f64>()) / l[i][i];
        }
        for i in 0..N {
            inverse[i][column] = b[i] / (scale[i] * scale[column]);
        }
    }
    Some((inverse, log_determinant))
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
        assert!(invert(&[[1.0, 1.0], [1.0, 1.0]]).is_none());
    }
}
