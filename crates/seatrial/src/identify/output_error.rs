//! Output error: the model whose simulation is nearest to the measured heading.

use nalgebra::{Matrix3, Vector3, Vector5};
use seatrial_core::refine::{Disturbance, RefineFailure};
use seatrial_core::{Sample, YawModel};

use super::excited_segment::most_excited;
use super::simulation::{Comparisons, Simulation, nearest};
use crate::record_series::{RecordSeries, RecordSpan};

/// A simulation that leaves more than this share of the heading's variance may be a neighbouring minimum.
const POOR_SHARE: f64 = 0.5;

/// The output error estimate of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputError {
    /// The parameters.
    pub model: YawModel<f64>,
    /// Covariance of [a22, b2, C0], for residuals that are correlated in time.
    pub covariance: [[f64; 3]; 3],
    /// Root mean square of the residual, rad.
    pub residual_rms_rad: f64,
    /// Passes over the record.
    pub iterations: u32,
}

/// Minimises sum (psi - psi_sim)^2 over a22, b2, C0, psi0 and r0.
///
/// Levenberg and Marquardt's method with the exact zero-order-hold discretisation and its exact derivatives: three or four
/// passes over the record from a start such as the online estimate. Without a start, or where it leads to a poor simulation,
/// the start is the best damping of a grid. This is the cost (38) of the paper's offline method with the initial
/// state estimated too.
///
/// Efficient for white heading noise; the covariance also holds for residuals correlated in time.
///
/// ```
/// use seatrial::identify::output_error::output_error;
///
/// # let vehicle = seatrial_core::YawModel::from_theta([-1.07, 1.08, 0.012]);
/// # let mut state = seatrial_core::model::YawState::<f64>::default();
/// # let sample = |k: u32| {
/// #     let rudder_rad = match k % 330 { 40..80 => 0.26, 80..120 => -0.26, _ => 0.0 };
/// #     let heading_rad = (1000.0 * state.heading_rad).round() / 1000.0;
/// #     state = vehicle.advance(state, rudder_rad, 0.05);
/// #     seatrial::Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Default::default() }
/// # };
/// # let record: seatrial::Record = (0..660).map(sample).collect();
/// // Two doublets of 0.26 rad on a vehicle with a22 = -1.07 1/s, b2 = 1.08 1/s^2.
/// let found = output_error(&record.samples, None)?;
/// assert!((found.model.a22_per_s + 1.07).abs() < 0.01);
/// // A compass that rounds to 0.001 rad leaves the deviation of a uniform distribution.
/// assert!((found.residual_rms_rad * 12_f64.sqrt() - 0.001).abs() < 2e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn output_error(
    samples: &[Sample<f64>],
    start: Option<YawModel<f64>>,
) -> Result<OutputError, RefineFailure> {
    let found = nearest_simulation(samples, start)?;
    Ok(OutputError {
        model: found.model(),
        covariance: found.sandwich().ok_or(RefineFailure::NotExcited)?,
        residual_rms_rad: found.residual_rms_rad(),
        iterations: found.passes,
    })
}

/// The simulation nearest to a record.
#[derive(Clone)]
pub struct NearestSimulation {
    record: RecordSeries,
    simulation: Simulation,
    passes: u32,
}

/// [`output_error`] without its covariance, which takes longer than the search.
///
/// ```
/// use seatrial::identify::output_error::{nearest_simulation, output_error};
///
/// # let vehicle = seatrial_core::YawModel::from_theta([-1.07, 1.08, 0.012]);
/// # let mut state = seatrial_core::model::YawState::<f64>::default();
/// # let sample = |k: u32| {
/// #     let rudder_rad = match k % 330 { 40..80 => 0.26, 80..120 => -0.26, _ => 0.0 };
/// #     let heading_rad = (1000.0 * state.heading_rad).round() / 1000.0;
/// #     state = vehicle.advance(state, rudder_rad, 0.05);
/// #     seatrial::Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Default::default() }
/// # };
/// # let record: seatrial::Record = (0..660).map(sample).collect();
/// // Two doublets of 0.26 rad on a vehicle with a22 = -1.07 1/s, b2 = 1.08 1/s^2.
/// // From a rough start; the same parameters in less time.
/// let start = seatrial_core::YawModel::from_theta([-0.8, 0.9, 0.0]);
/// let found = nearest_simulation(&record.samples, Some(start))?;
/// let full = output_error(&record.samples, Some(start))?;
/// assert_eq!(found.model(), full.model);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn nearest_simulation(
    samples: &[Sample<f64>],
    start: Option<YawModel<f64>>,
) -> Result<NearestSimulation, RefineFailure> {
    let samples = most_excited(samples);
    let span = RecordSpan::of(samples)?;
    if let Some(start) = start {
        let record = span.prepare(samples, start.a22_per_s)?;
        let [a22, b2, c0] = start.theta();
        if let Some((simulation, passes)) = nearest(&record, Vector5::new(a22, b2, c0, 0.0, 0.0)) {
            let found = NearestSimulation {
                record,
                simulation,
                passes,
            };
            if found.left_share() < POOR_SHARE {
                return Ok(found);
            }
        }
    }
    let a22_per_s = span.first_damping(samples, start)?;
    let record = span.prepare(samples, a22_per_s)?;
    let (simulation, passes) = record
        .fit(a22_per_s, Disturbance::NONE)
        .and_then(|fit| {
            let [b2, c0, heading, rate] = fit.linear;
            nearest(&record, Vector5::new(a22_per_s, b2, c0, heading, rate))
        })
        .ok_or(RefineFailure::NotExcited)?;
    Ok(NearestSimulation {
        record,
        simulation,
        passes,
    })
}

impl NearestSimulation {
    /// Its parameters.
    pub fn model(&self) -> YawModel<f64> {
        let [a22, b2, c0, ..]: [f64; 5] = self.simulation.parameters.into();
        YawModel::from_theta([a22, b2, c0])
    }

    /// Root mean square of measured less simulated heading, rad.
    pub fn residual_rms_rad(&self) -> f64 {
        (self.simulation.residual / self.record.blocks() as f64).sqrt()
    }

    /// Passes over the record that the search took.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// What is left of the heading's variance.
    fn left_share(&self) -> f64 {
        let heading = &self.record.heading_rad;
        let n = heading.len() as f64;
        let add = |(sum, squares), w: &f64| (sum + w, squares + w * w);
        let (sum, squares) = heading.iter().fold((0.0, 0.0), add);
        let variance = squares / n - (sum / n).powi(2);
        self.residual_rms_rad().powi(2) / variance
    }

    /// Covariance of [a22, b2, C0] for residuals of any correlation (Newey and West 1987):
    /// A^-1 B A^-1 with A = sum g g^T, B = sum over lags |l| <= L of (1 - |l|/(L+1)) sum u_k u_{k+l}^T, u = g e,
    /// L = sqrt(n).
    fn sandwich(&self) -> Option<[[f64; 3]; 3]> {
        let inverse = self.simulation.information.try_inverse()?;
        let of_parameters = inverse.fixed_rows::<3>(0).into_owned();
        let influences: Vec<Vector3<f64>> =
            Comparisons::of(&self.record, &self.simulation.parameters)
                .rows()
                .map(|(g, e)| of_parameters * Vector5::from(g) * e)
                .collect();
        let lags = (influences.len() as f64).sqrt() as usize;
        let mut covariance = Matrix3::zeros();
        for lag in 0..=lags.min(influences.len() - 1) {
            let product: Matrix3<f64> = influences
                .iter()
                .zip(&influences[lag..])
                .map(|(now, later)| now * later.transpose())
                .sum();
            let weight = 1.0 - lag as f64 / (lags + 1) as f64;
            covariance += if lag == 0 {
                product
            } else {
                weight * (product + product.transpose())
            };
        }
        Some(covariance.into())
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
