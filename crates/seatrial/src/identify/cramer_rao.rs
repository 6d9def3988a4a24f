//! The Cramer-Rao bound: what no unbiased estimator can beat on a given rudder record.

use nalgebra::{Matrix3, Vector3};
use seatrial_core::model::YawState;
use seatrial_core::refine::Disturbance;
use seatrial_core::{Sample, YawModel};
use serde::Serialize;

use crate::record_series::RecordSeries;

/// The noise on a record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Noise {
    /// Standard deviation of the white heading noise, rad.
    pub heading_rad: f64,
    /// Standard deviation of the yaw acceleration disturbance, rad/s^2.
    pub disturbance_rad_s2: f64,
    /// Time constant of the disturbance, s.
    pub disturbance_time_s: f64,
}

/// Smallest possible covariance of unbiased estimates of [a22, b2, C0] from these rudder angles and times.
///
/// ```text
/// var(a22) = sigma^2 / (s^T (I - X (X^T X)^-1 X^T) s),   s = whitened d psi/d a22
/// ```
///
/// X holds the whitened responses to b2, C0 and the initial state, which are estimated too. The headings of
/// the samples do not matter. `None` where the rudder does not excite the model.
///
/// ```
/// use seatrial::identify::cramer_rao::{Noise, cramer_rao_bound};
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
/// let bound = |heading_rad| {
///     let noise = Noise { heading_rad, disturbance_rad_s2: 0.0, disturbance_time_s: 1.0 };
///     cramer_rao_bound(&record.samples, vehicle, noise).map(|bound| bound[(0, 0)].sqrt())
/// };
/// // Twice the noise of the compass, twice the deviation of a22.
/// let (half, full) = bound(0.005).zip(bound(0.01)).ok_or("the rudder excites the model")?;
/// assert!((full / half - 2.0).abs() < 1e-6 && full < 0.05);
/// # Ok::<(), &str>(())
/// ```
pub fn cramer_rao_bound(
    samples: &[Sample<f64>],
    truth: YawModel<f64>,
    noise: Noise,
) -> Option<Matrix3<f64>> {
    if samples.is_empty() {
        return None;
    }
    let sensitivity = damping_sensitivity(samples, truth);
    let record = RecordSeries::from_headings(samples, sensitivity, 1);
    let fit = record.fit(
        truth.a22_per_s,
        Disturbance {
            relative: noise.disturbance_rad_s2 / noise.heading_rad,
            time_constant_s: noise.disturbance_time_s,
        },
    )?;
    let variance = noise.heading_rad * noise.heading_rad;
    let damping = variance / fit.residual;
    let along = Vector3::new(1.0, -fit.linear[0], -fit.linear[1]);
    let mut bound = damping * along * along.transpose();
    for i in 0..2 {
        for j in 0..2 {
            bound[(i + 1, j + 1)] += variance * fit.scaled_covariance[i][j];
        }
    }
    Some(bound)
}

/// d psi/d a22 by central differences of the exact simulation from rest.
fn damping_sensitivity(samples: &[Sample<f64>], truth: YawModel<f64>) -> Vec<f64> {
    let spread = 1e-5 * truth.a22_per_s.abs().max(1e-3);
    let heading = |a22_per_s: f64| {
        let model = YawModel { a22_per_s, ..truth };
        let mut state = YawState::default();
        let mut headings = vec![0.0];
        for pair in samples.windows(2) {
            state = model.advance(state, pair[0].rudder_rad, pair[1].time_s - pair[0].time_s);
            headings.push(state.heading_rad);
        }
        headings
    };
    heading(truth.a22_per_s + spread)
        .iter()
        .zip(heading(truth.a22_per_s - spread))
        .map(|(above, below)| (above - below) / (2.0 * spread))
        .collect()
}
