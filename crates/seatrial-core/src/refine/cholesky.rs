//! Small symmetric systems.

use libm::{log, sqrt};

/// A = L L^T.
pub struct Cholesky<const N: usize>([[f64; N]; N]);

impl<const N: usize> Cholesky<N> {
    /// `None` where the matrix is not positive definite.
    pub fn of(matrix: &[[f64; N]; N]) -> Option<Self> {
        let mut l = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..N {
                let left = matrix[i][j] - below::<N>(j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
                if j < i {
                    l[i][j] = left / l[j][j];
                } else if j == i && left > 0.0 {
                    l[i][i] = sqrt(left);
                } else if j == i {
                    return None;
                }
            }
        }
        Some(Self(l))
    }

    /// ln det A.
    pub fn log_determinant(&self) -> f64 {
        (0..N).map(|i| 2.0 * log(self.0[i][i])).sum()
    }

    /// A^-1 b.
    pub fn solve(&self, mut b: [f64; N]) -> [f64; N] {
        let Self(l) = self;
        for i in 0..N {
            b[i] = (b[i] - below::<N>(i).map(|k| l[i][k] * b[k]).sum::<f64>()) / l[i][i];
        }
        for i in (0..N).rev() {
            let above = (0..N).filter(|k| *k > i);
            b[i] = (b[i] - above.map(|k| l[k][i] * b[k]).sum::<f64>()) / l[i][i];
        }
        b
    }

    /// A^-1.
    pub fn inverse(&self) -> [[f64; N]; N] {
        core::array::from_fn(|i| {
            self.solve(core::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
        })
    }
}

/// Columns left of the j-th, written so that the compiler sees them within bounds.
fn below<const N: usize>(j: usize) -> impl Iterator<Item = usize> {
    (0..N).filter(move |k| *k < j)
}
