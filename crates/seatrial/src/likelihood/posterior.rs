//! What all hypotheses together say: means and covariances of quantities of the vehicle.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::choice::{Candidate, Contest};
use super::fit::{Fit, Problem};
use super::hypothesis::Vehicle;
use crate::draw::Draw;

/// A hypothesis or a node of less weight is passed over.
const NEGLIGIBLE: f64 = 5e-3;

/// Quantities of the vehicle with what is not known of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments<const N: usize = 3> {
    /// Means.
    pub mean: SVector<f64, N>,
    /// Covariance.
    pub covariance: SMatrix<f64, N, N>,
}

impl<const N: usize> Moments<N> {
    /// Of weighed parts together. `None` where no part has weight.
    ///
    /// ```text
    /// m = sum w m_i,   cov = sum w (cov_i + (m_i - m)(m_i - m)')
    /// ```
    pub fn of(parts: &[(f64, Self)]) -> Option<Self> {
        let total: f64 = parts.iter().map(|(weight, _)| weight).sum();
        // Weights that are no numbers have no sum.
        if total.is_nan() || total <= 0.0 {
            return None;
        }
        let weighed = || parts.iter().map(|(weight, part)| (weight / total, part));
        let mean: SVector<f64, N> = weighed().map(|(weight, part)| part.mean * weight).sum();
        let of_part = |(weight, part): (f64, &Self)| {
            let away = part.mean - mean;
            (part.covariance + away * away.transpose()) * weight
        };
        Some(Self { mean, covariance: weighed().map(of_part).sum() })
    }
}

impl Contest<'_> {
    /// Mean and covariance of three quantities over all hypotheses. `None` where no hypothesis determines its parameters.
    ///
    /// ```text
    /// cov_i = G inv(H) G',   G = d quantity / d x
    /// ```
    ///
    /// A covariance is replaced by that of the jackknife over the blocks where this is clearly wider: the model is then wrong by more than
    /// its noise. Not that of a first-order vehicle in a sea that its own draws explain: there a block without the rudder says nothing.
    pub fn moments(&self, quantity: &dyn Fn(&Vehicle, f64) -> [f64; 3]) -> Option<Moments> {
        let mut parts: Vec<(f64, Moments)> = Vec::new();
        for candidate in self.candidates.iter().filter(|c| c.weight >= NEGLIGIBLE) {
            parts.extend(candidate.moments(quantity));
        }
        Moments::of(&parts)
    }
}

impl Candidate<'_> {
    /// Vehicles that the record does not tell apart: the best one, those found without one of the blocks, and draws of the posterior.
    pub fn vehicles(&self) -> Vec<Vehicle> {
        const DRAWS: usize = 8;
        let (problem, fit) = (&self.hypothesis.problem, self.hypothesis.best());
        let mut draw = Draw::new(1);
        let factor = fit.information.clone().cholesky();
        let drawn = factor.iter().flat_map(|factor| {
            (0..DRAWS)
                .filter_map(|_| {
                    let mut z = nalgebra::DVector::from_fn(problem.size(), |_, _| draw.normal());
                    let is_solved = factor.l().transpose().solve_upper_triangular_mut(&mut z);
                    is_solved.then(|| &fit.x + z)
                })
                .collect::<Vec<_>>()
        });
        let best = [fit.x.clone()].into_iter();
        best.chain(self.without.iter().cloned()).chain(drawn).map(|x| problem.vehicle(&x)).collect()
    }

    /// Weight and moments of each node.
    fn moments(&self, quantity: &dyn Fn(&Vehicle, f64) -> [f64; 3]) -> Vec<(f64, Moments)> {
        let problem = &self.hypothesis.problem;
        let of = |x: &nalgebra::DVector<f64>| -> Vector3<f64> {
            quantity(&problem.vehicle(x), problem.start_of(x, 0).offset_rad_s2).into()
        };
        let shares = self.hypothesis.shares();
        let mut nodes: Vec<(f64, Moments)> = (self.hypothesis.nodes.iter().zip(shares))
            .filter(|(_, share)| *share >= NEGLIGIBLE)
            .filter_map(|((_, fit), share)| {
                let covariance = covariance(problem, fit, &of)?;
                Some((share * self.weight, Moments { mean: of(&fit.x), covariance }))
            })
            .collect();
        let is_explained = self.is_of_first_order_in_a_sea();
        let times = (!is_explained).then(|| self.jackknife(&nodes, &of)).flatten();
        if let Some(times) = times {
            for (_, moments) in &mut nodes {
                let wider = Matrix3::from_diagonal(&times);
                moments.covariance = wider * moments.covariance * wider;
            }
        }
        nodes
    }

    /// Times by which each deviation of the nodes is too small by the jackknife over the blocks.
    fn jackknife(
        &self,
        nodes: &[(f64, Moments)],
        of: &dyn Fn(&nalgebra::DVector<f64>) -> Vector3<f64>,
    ) -> Option<Vector3<f64>> {
        let k = self.without.len() as f64;
        if self.without.len() < 3 {
            return None;
        }
        let values: Vec<Vector3<f64>> = self.without.iter().map(of).collect();
        let mean = values.iter().sum::<Vector3<f64>>() / k;
        let total: f64 = nodes.iter().map(|(weight, _)| weight).sum();
        // A jackknife of k blocks is itself uncertain by sqrt(2/k).
        let clearly = 1.0 + 2.0 * (2.0 / k).sqrt();
        Some(Vector3::from_fn(|i, _| {
            let scatter: f64 = values.iter().map(|v| (v[i] - mean[i]).powi(2)).sum();
            let jackknife = (k - 1.0) / k * scatter;
            let own: f64 = nodes.iter().map(|(w, m)| w * m.covariance[(i, i)]).sum::<f64>() / total;
            match jackknife > clearly * own && own > 0.0 {
                true => (jackknife / own).sqrt(),
                false => 1.0,
            }
        }))
    }
}

fn covariance(
    problem: &Problem,
    fit: &Fit,
    of: &dyn Fn(&nalgebra::DVector<f64>) -> Vector3<f64>,
) -> Option<Matrix3<f64>> {
    const STEP: f64 = 1e-4;
    let here = of(&fit.x);
    let slopes: Vec<Vector3<f64>> = (0..problem.size())
        .map(|i| {
            let mut x = fit.x.clone();
            x[i] += STEP;
            (of(&x) - here) / STEP
        })
        .collect();
    let gradient = nalgebra::DMatrix::from_fn(3, problem.size(), |i, j| slopes[j][i]);
    let factor = fit.information.clone().cholesky()?;
    let product = &gradient * factor.solve(&gradient.transpose());
    Some(Matrix3::from_fn(|i, j| product[(i, j)]))
}
