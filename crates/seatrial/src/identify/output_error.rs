//! Output error: the likelihood without disturbance, and a covariance for residuals that are correlated in time.

use nalgebra::{Matrix3, Matrix5, Vector3, Vector5};
use seatrial_core::refine::{Disturbance, Peak, RefineFailure};
use seatrial_core::{Sample, YawModel};

use super::excited_segment::most_excited;
use crate::likelihood::leg::deviation;
use crate::record_series::{RecordSeries, RecordSpan};

/// A simulation that leaves more than this share of the heading's variance may be a neighbouring minimum.
const POOR_SHARE: f64 = 0.5;

/// Half the difference of a22 for a derivative to it, a share of the rate of the vehicle.
const NUDGE: f64 = 1e-4;

/// The output error estimate of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputError {
    /// The parameters.
    pub model: YawModel<f64>,
    /// Covariance of [a22, b2, C0], for residuals that are correlated in time.
    pub covariance: [[f64; 3]; 3],
    /// Root mean square of the residual, rad.
    pub residual_rms_rad: f64,
}

/// The model whose simulation is nearest to the measured heading, the initial state estimated too: cost (38) of the paper's offline
/// method, with the restricted likelihood's price of b2, C0, psi0 and r0.
///
/// From `start`, such as the online estimate. Without one, or where it leads to a poor simulation, the start is the best
/// damping of a grid.
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
    let samples = most_excited(samples);
    let span = RecordSpan::of(samples)?;
    let from = |a22_per_s: f64| {
        let record = span.prepare(samples, a22_per_s)?;
        let peak = span.nearest_simulation(&record, a22_per_s);
        Ok((record, peak.ok_or(RefineFailure::NotExcited)?))
    };
    let mean_square_rad2 =
        |record: &RecordSeries, peak: &Peak| peak.fit.residual / record.blocks() as f64;
    let is_near = |(record, peak): &(RecordSeries, Peak)| {
        mean_square_rad2(record, peak) < POOR_SHARE * deviation(&record.heading_rad).powi(2)
    };
    let from_start = start.map(|start| from(start.a22_per_s)).transpose();
    let (record, peak) = match from_start.ok().flatten().filter(is_near) {
        Some(found) => found,
        None => from(span.first_damping(samples, start)?)?,
    };
    let scale_per_s = span.rate_scale(peak.a22_per_s);
    Ok(OutputError {
        model: YawModel::from_theta(peak.normal().0),
        covariance: sandwich(&record, peak.a22_per_s, scale_per_s)
            .ok_or(RefineFailure::NotExcited)?,
        residual_rms_rad: mean_square_rad2(&record, &peak).sqrt(),
    })
}

/// Covariance of [a22, b2, C0] for residuals of any correlation (Newey and West 1987):
/// A^-1 B A^-1 with A = sum g g^T, B = sum over lags |l| <= L of (1 - |l|/(L+1)) sum u_k u_{k+l}^T, u = g e,
/// L = sqrt(n), g the derivatives of the simulated heading to [a22, b2, C0, psi0, r0] and e measured less simulated heading.
fn sandwich(record: &RecordSeries, a22_per_s: f64, scale_per_s: f64) -> Option<[[f64; 3]; 3]> {
    let linear = record.fit(a22_per_s, Disturbance::NONE)?.linear;
    let simulated = |row: &[f64; 5]| -> f64 {
        linear.iter().zip(row).map(|(by, response)| by * response).sum()
    };
    let nudge_per_s = NUDGE * scale_per_s;
    let [below, here, above] =
        [-nudge_per_s, 0.0, nudge_per_s].map(|nudge| record.comparisons(a22_per_s + nudge));
    let rows: Vec<(Vector5<f64>, f64)> = (here.iter().zip(below.iter().zip(&above)))
        .map(|(row, (below, above))| {
            let to_a22 = 0.5 * (simulated(above) - simulated(below)) / nudge_per_s;
            let [to_b2, to_c0, to_psi0, to_r0, heading] = *row;
            let gradient = Vector5::new(to_a22, to_b2, to_c0, to_psi0, to_r0);
            (gradient, heading - simulated(row))
        })
        .collect();
    let information: Matrix5<f64> = rows.iter().map(|(g, _)| g * g.transpose()).sum();
    let inverse = information.try_inverse()?;
    let of_parameters = inverse.fixed_rows::<3>(0).into_owned();
    let influences: Vec<Vector3<f64>> =
        (rows.iter()).map(|(g, e)| of_parameters * g * *e).collect();
    // L + 1 windows of L + 1 influences hold an influence, and L + 1 - |l| of them hold the one l places further as well.
    let lags = (influences.len() as f64).sqrt() as usize;
    let mut covariance = Matrix3::zeros();
    let mut of_window = Vector3::zeros();
    for k in 0..influences.len() + lags {
        of_window += influences.get(k).copied().unwrap_or_default();
        if let Some(left) = k.checked_sub(lags + 1) {
            of_window -= influences[left];
        }
        covariance += of_window * of_window.transpose() / (lags + 1) as f64;
    }
    Some(covariance.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial_core::model::YawState;

    #[test]
    fn exact_noise_free_record_gives_the_model_back() {
        for theta in [[-1.07, 1.08, 0.012], [-0.09, -0.015, 1e-4], [0.02, 0.8, -0.01]] {
            let truth = YawModel::from_theta(theta);
            let scale = 1.0 / f64::max(0.5, -theta[0]);
            let mut state = YawState { heading_rad: 3.0, yaw_rate_rad_s: 0.02 };
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
