//! The likelihood of a record under a sway-yaw model and a yaw acceleration disturbance, and its peak.

use nalgebra::{DMatrix, DVector, SMatrix};
use seatrial_core::refine::Disturbance;

use super::comparisons::Comparisons;
use super::simulation::{COLUMNS, Simulation};
use super::theta::{A11, CROSS_FLOW, LAG, PARAMETERS, Theta};
use super::whitening::Whitening;

/// A simulation that misses the heading by so many ranges of it has run away.
const RUNAWAY_RANGES: f64 = 30.0;

/// Gradient and curvature of a log likelihood.
pub(super) struct Likelihood {
    /// -1/2 [n log(RSS/n + floor) + sum log S_k].
    pub(super) log: f64,
    /// Whitened residual of each comparison, rad.
    pub(super) innovations: Vec<f64>,
    residual: f64,
    /// X^T e and X^T X of the whitened sensitivities X.
    gradient: SMatrix<f64, PARAMETERS, 1>,
    information: SMatrix<f64, PARAMETERS, PARAMETERS>,
}

/// The largest likelihood of a structure at one disturbance.
pub(super) struct Summit {
    pub(super) theta: Theta,
    pub(super) disturbance: Disturbance,
    pub(super) likelihood: Likelihood,
}

impl Comparisons {
    /// The likelihood of a model and a disturbance d of the yaw acceleration.
    ///
    /// ```text
    /// e_k = z_k - x_psi,  S_k = P_psi,psi + 1
    /// x+ = [F g; 0 m] (x + K e),  F = dx+/dx, g = dx+/d(yaw acceleration) along the simulation
    /// ```
    ///
    /// z is the measured less the simulated heading, and each of its sensitivities: a Kalman filter linearised on the
    /// simulation whitens all of them alike. Sensitivities to parameters that are not `free` may be left out. `None` where the simulation
    /// runs away.
    pub(super) fn likelihood(
        &self,
        theta: &Theta,
        free: &[usize],
        disturbance: Disturbance,
    ) -> Option<Likelihood> {
        let is_linear = !free.contains(&CROSS_FLOW) && theta[CROSS_FLOW] == 0.0;
        let mut simulation = Simulation::new(theta, is_linear);
        let mut whitening = Whitening::new(disturbance, self.block);
        let mut gram = [[0.0; COLUMNS]; COLUMNS];
        let mut log_variances = 0.0;
        let mut last = (0.0, 0.0);
        let mut innovations = Vec::with_capacity(self.count());
        let acting = self.acting(theta[LAG]);
        let runaway_rad = RUNAWAY_RANGES * self.range_rad();
        for (comparison, rudder) in self.all.iter().zip(&*acting) {
            let (row, passage) = simulation.pass(comparison, rudder);
            if row[PARAMETERS].abs() > runaway_rad {
                return None;
            }
            let (white, variance) = whitening.update(&row, passage);
            if variance != last.0 {
                last = (variance, libm::log(variance));
            }
            log_variances += last.1;
            for i in 0..COLUMNS {
                // By pairs.
                for j in i - i % 2..COLUMNS {
                    gram[i][j] += white[i] * white[j];
                }
            }
            innovations.push(white[PARAMETERS]);
        }
        let residual = gram[PARAMETERS][PARAMETERS];
        let n = self.count() as f64;
        let log = -0.5 * (n * libm::log(residual / n + self.floor_rad2) + log_variances);
        log.is_finite().then(|| Likelihood {
            log,
            innovations,
            residual,
            gradient: SMatrix::from_fn(|i, _| gram[i][PARAMETERS]),
            information: SMatrix::from_fn(|i, j| gram[i.min(j)][i.max(j)]),
        })
    }

    /// Climbs the likelihood in the parameters `free` (Levenberg and Marquardt) from `start`.
    ///
    /// The steps know nothing of sum log S_k, which changes with the parameters, too. Near the summit that makes a step that promises P
    /// give P - l, and the best part of it no more than P (1 - l/2P)^2: where that is not worth a step, the climb has arrived.
    pub(super) fn climb(
        &self,
        start: &Theta,
        free: &[usize],
        disturbance: Disturbance,
        most_steps: u32,
    ) -> Option<Summit> {
        const ARRIVED: f64 = 1e-3;
        /// A step that promises less than this is not tried.
        const WORTH_A_LOOK: f64 = 0.1 * ARRIVED;
        const MOST_DAMPING: f64 = 1e4;
        /// A step that promises less than this is near the summit, where the likelihood is a parabola.
        const NEAR: f64 = 1.0;
        let mut summit = Summit {
            theta: *start,
            disturbance,
            likelihood: self.likelihood(start, free, disturbance)?,
        };
        let mut damping = 1e-3;
        for _ in 0..most_steps {
            let before = summit.likelihood.log;
            while damping < MOST_DAMPING {
                let (mut theta, promised) = summit.likelihood.step(&summit.theta, free, damping)?;
                if promised < WORTH_A_LOOK {
                    break;
                }
                theta[A11] = theta[A11]
                    .min(-self.slowest_sway_per_s)
                    .max(-self.fastest_sway_per_s);
                match self.likelihood(&theta, free, disturbance) {
                    Some(likelihood) if likelihood.log > before => {
                        summit = Summit {
                            theta,
                            disturbance,
                            likelihood,
                        };
                        damping *= 0.2;
                        break;
                    }
                    Some(likelihood)
                        if promised < NEAR
                            && best_part(promised, likelihood.log - before) < ARRIVED =>
                    {
                        break;
                    }
                    _ => damping *= 5.0,
                }
            }
            if summit.likelihood.log - before < ARRIVED {
                break;
            }
        }
        Some(summit)
    }
}

/// What the best part of a step gives that promised more than it gave, where likelihood and loss are a parabola and a line.
fn best_part(promised: f64, gave: f64) -> f64 {
    (promised + gave).max(0.0).powi(2) / (4.0 * promised)
}

impl Likelihood {
    /// A damped Gauss-Newton step, inside what physics allows, and the gain of log likelihood that it promises.
    fn step(&self, theta: &Theta, free: &[usize], damping: f64) -> Option<(Theta, f64)> {
        let (normal, scale) = self.scaled_information(free);
        let right = DVector::from_fn(free.len(), |i, _| self.gradient[free[i]] / scale[i]);
        let damped = &normal + DMatrix::identity(free.len(), free.len()) * damping;
        let step = damped.cholesky()?.solve(&right);
        let explained = 2.0 * right.dot(&step) - step.dot(&(&normal * &step));
        let promised = 0.5 * self.innovations.len() as f64 * explained / self.residual;
        let mut next = *theta;
        for (i, parameter) in free.iter().enumerate() {
            next[*parameter] += step[i] / scale[i];
        }
        next[CROSS_FLOW] = next[CROSS_FLOW].min(0.0);
        next[LAG] = next[LAG].max(0.0);
        Some((next, promised))
    }

    /// Covariance of the parameters `free`, in their order. `None` where the record does not determine them.
    pub(super) fn covariance(&self, free: &[usize]) -> Option<DMatrix<f64>> {
        let degrees_of_freedom = self.innovations.len().checked_sub(free.len() + 1)? as f64;
        let (normal, scale) = self.scaled_information(free);
        let inverse = normal.cholesky()?.inverse();
        let noise = self.residual / degrees_of_freedom;
        Some(DMatrix::from_fn(free.len(), free.len(), |i, j| {
            noise * inverse[(i, j)] / (scale[i] * scale[j])
        }))
    }

    /// Variance of the heading noise of one sample, rad^2.
    pub(super) fn noise_variance_rad2(&self, free: &[usize]) -> f64 {
        self.residual / (self.innovations.len() - free.len().min(self.innovations.len() - 1)) as f64
    }

    /// X^T X with a unit diagonal, and the lengths of the columns of X.
    fn scaled_information(&self, free: &[usize]) -> (DMatrix<f64>, Vec<f64>) {
        let scale: Vec<f64> = free
            .iter()
            .map(|i| self.information[(*i, *i)].sqrt().max(f64::MIN_POSITIVE))
            .collect();
        let normal = DMatrix::from_fn(free.len(), free.len(), |i, j| {
            self.information[(free[i], free[j])] / (scale[i] * scale[j])
        });
        (normal, scale)
    }
}
