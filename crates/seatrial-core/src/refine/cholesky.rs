//! Small symmetric systems.

use libm::{log, sqrt};

use super::series::COLUMNS;

/// A = L L^T.
pub struct Cholesky([[f64; COLUMNS]; COLUMNS]);

impl Cholesky {
    /// `None` where the matrix is not positive definite.
    pub fn of(matrix: &[[f64; COLUMNS]; COLUMNS]) -> Option<Self> {
        let mut l = [[0.0; COLUMNS]; COLUMNS];
        for i in 0..COLUMNS {
            for j in 0..COLUMNS {
                let left = matrix[i][j] - below(j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
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

    pub fn log_determinant(&self) -> f64 {
        (0..COLUMNS).map(|i| 2.0 * log(self.0[i][i])).sum()
    }

    /// A^-1 b.
    pub fn solve(&self, mut b: [f64; COLUMNS]) -> [f64; COLUMNS] {
        let Self(l) = self;
        for i in 0..COLUMNS {
            b[i] = (b[i] - below(i).map(|k| l[i][k] * b[k]).sum::<f64>()) / l[i][i];
        }
        for i in (0..COLUMNS).rev() {
            let above = (0..COLUMNS).filter(|k| *k > i);
            b[i] = (b[i] - above.map(|k| l[k][i] * b[k]).sum::<f64>()) / l[i][i];
        }
        b
    }

    pub fn inverse(&self) -> [[f64; COLUMNS]; COLUMNS] {
        core::array::from_fn(|i| {
            self.solve(core::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
        })
    }
}

/// Columns left of the j-th, written so that the compiler sees them within bounds.
fn below(j: usize) -> impl Iterator<Item = usize> {
    (0..COLUMNS).filter(move |k| *k < j)
}
