//! Output error: the model whose simulation is nearest to the measured heading.

use nalgebra::{Matrix3, Matrix5, Vector5};
use seatrial_core::{Sample, YawModel};

use super::peak::{Peak, RefineFailure, Span, liveliest};
use super::whitening::{Disturbance, Fit, Prepared};

/// The output error estimate of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputError {
    /// The parameters.
    pub model: YawModel<f64>,
    /// Covariance of [a22, b2, C0], for residuals that are correlated in time.
    pub covariance: [[f64; 3]; 3],
    /// Root mean square of the residual, rad.
    pub residual_rms_rad: f64,
    /// Newton steps.
    pub iterations: u32,
}

/// Minimises sum (psi - psi_sim)^2 over a22, b2, C0, psi0 and r0.
///
/// Given a22 the simulation is linear in the other four, which follow in closed form (variable projection), so
/// Newton's method runs in a22 alone, with the exact zero-order-hold discretisation. This is the cost (38)
/// of the paper's offline method with the initial state estimated too.
///
/// Efficient for white heading noise; the covariance also holds for residuals correlated in time.
pub fn output_error(
    samples: &[Sample<f64>],
    start: Option<YawModel<f64>>,
) -> Result<OutputError, RefineFailure> {
    let samples = liveliest(samples);
    let span = Span::of(samples)?;
    let damping = span.first_damping(samples, start)?;
    let record = span.prepare(samples, damping)?;
    let peak = Peak::find(
        &record,
        Disturbance::NONE,
        damping,
        span.rate_scale(damping),
    )
    .ok_or(RefineFailure::NotExcited)?;
    let (theta, _) = peak.normal();
    let scores = Scores::of(&record, &peak);
    Ok(OutputError {
        model: YawModel::from_theta(theta.into()),
        covariance: scores.sandwich().ok_or(RefineFailure::NotExcited)?,
        residual_rms_rad: root_mean_square(&peak.fit, record.blocks()),
        iterations: peak.iterations,
    })
}

fn root_mean_square(fit: &Fit, comparisons: usize) -> f64 {
    (fit.residual / comparisons as f64).sqrt()
}

/// Sensitivities g_k of the simulated heading to [a22, b2, C0, psi0, r0], and residuals e_k.
struct Scores {
    sensitivities: Vec<Vector5<f64>>,
    residuals: Vec<f64>,
}

impl Scores {
    fn of(record: &Prepared, peak: &Peak) -> Self {
        let spread = 1e-4 * peak.a22_per_s.abs().max(1e-3);
        let at = |a22_per_s: f64| record.residuals(a22_per_s, &peak.fit.linear);
        let sensitivities = record
            .columns(peak.a22_per_s)
            .into_iter()
            .zip(at(peak.a22_per_s - spread))
            .zip(at(peak.a22_per_s + spread))
            .map(|((columns, below), above)| {
                let to_damping = (below - above) / (2.0 * spread);
                Vector5::new(to_damping, columns[0], columns[1], columns[2], columns[3])
            })
            .collect();
        Self {
            sensitivities,
            residuals: at(peak.a22_per_s),
        }
    }

    /// Covariance of [a22, b2, C0] for residuals of any correlation (Newey and West 1987):
    /// A^-1 B A^-1 with A = sum g g^T, B = sum over lags |l| <= L of (1 - |l|/(L+1)) sum u_k u_{k+l}^T, u = g e,
    /// L = sqrt(n).
    fn sandwich(&self) -> Option<[[f64; 3]; 3]> {
        let information: Matrix5<f64> = self.sensitivities.iter().map(|g| g * g.transpose()).sum();
        let scores: Vec<Vector5<f64>> = self
            .sensitivities
            .iter()
            .zip(&self.residuals)
            .map(|(g, e)| g * *e)
            .collect();
        let lags = (scores.len() as f64).sqrt() as usize;
        let mut spread = Matrix5::zeros();
        for lag in 0..=lags.min(scores.len() - 1) {
            let product: Matrix5<f64> = scores
                .iter()
                .zip(&scores[lag..])
                .map(|(now, later)| now * later.transpose())
                .sum();
            let weight = 1.0 - lag as f64 / (lags + 1) as f64;
            spread += if lag == 0 {
                product
            } else {
                weight * (product + product.transpose())
            };
        }
        let inverse = information.try_inverse()?;
        let covariance = inverse * spread * inverse;
        let parameters: Matrix3<f64> = covariance.fixed_view::<3, 3>(0, 0).into();
        Some(parameters.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial_core::model::YawState;

    #[test]
    fn exact_noise_free_record_gives_the_model_back() {
        for theta in [
            [-1.07, 1.08, 0.012],
            [-0.09, -0.015, 1e-4],
            [0.02, 0.8, -0.01],
        ] {
            let truth = YawModel::from_theta(theta);
            let scale = 1.0 / f64::max(0.5, -theta[0]);
            let mut state = YawState {
                heading_rad: 3.0,
                yaw_rate_rad_s: 0.02,
            };
            let mut samples = Vec::new();
            for k in 0..330_u32 {
                let time_s = 0.05 * scale * f64::from(k);
                let rudder_rad = match k {
                    40..80 => 0.26,
                    80..120 => -0.26,
                    _ => 0.0,
                };
                samples.push(Sample {
                    time_s,
                    heading_rad: state.heading_rad,
                    rudder_rad,
                    ..Sample::default()
                });
                state = truth.advance(state, rudder_rad, 0.05 * scale);
            }
            let estimate = output_error(&samples, None).unwrap();
            for (found, expected) in estimate.model.theta().iter().zip(theta) {
                // Newton stops at 2 % of a standard error of rounding noise.
                assert!(
                    (found - expected).abs() < 1e-5 * expected.abs().max(0.01),
                    "{found} {expected}"
                );
            }
        }
    }
}
