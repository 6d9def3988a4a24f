//! The estimate from a whole record: restricted likelihood averaged over the disturbance.

use nalgebra::Matrix3;
use seatrial_core::refine::{Hypotheses, RefineFailure};
use seatrial_core::{Sample, YawModel};

use super::excited_segment::most_excited;
use crate::identification::{EstimateMethod, Intervals, Refined};
use crate::record_series::RecordSeries;

/// [`seatrial_core::refine::refine`] of samples.
///
/// Only the most excited segment of a record of more than 10 000 samples is used. `samples` are finite and increase in
/// time; headings may be wrapped; a sample's rudder acts until the next.
///
/// ```
/// use seatrial::identify::refined::refined_estimate;
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
/// let found = refined_estimate(&record.samples, None)?;
/// let [low, high] = found.interval_95.b2_per_s2;
/// assert!(low < 1.08 && 1.08 < high && high - low < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn refined_estimate(
    samples: &[Sample<f64>],
    start: Option<YawModel<f64>>,
) -> Result<Refined, RefineFailure> {
    let found = hypotheses(samples, start)?.refinement();
    Ok(Refined {
        method: EstimateMethod::AveragedRestrictedLikelihood,
        model: found.model,
        delta0_rad: found.model.delta0_rad(),
        interval_95: Intervals {
            a22_per_s: found.a22_per_s,
            b2_per_s2: found.b2_per_s2,
            c0_rad_per_s2: found.c0_rad_per_s2,
            delta0_rad: found.delta0_rad,
        },
        covariance: found.covariance,
        heading_noise_rad: found.heading_noise_rad,
        disturbance_rad_s2: found.disturbance_rad_s2,
    })
}

/// The model and its covariance with the least prediction error of a Kalman filter: the one most likely disturbance, where
/// [`refined_estimate`] averages over all. Cheaper to explain, but its interval takes the disturbance for known.
///
/// ```
/// use seatrial::identify::refined::prediction_error;
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
/// let (model, covariance) = prediction_error(&record.samples, None)?;
/// assert!((model.a22_per_s + 1.07).abs() < 4.0 * covariance[(0, 0)].sqrt());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn prediction_error(
    samples: &[Sample<f64>],
    start: Option<YawModel<f64>>,
) -> Result<(YawModel<f64>, Matrix3<f64>), RefineFailure> {
    let hypotheses = hypotheses(samples, start)?;
    let (centre, covariance) = hypotheses.likeliest().normal();
    Ok((YawModel::from_theta(centre), covariance.into()))
}

fn hypotheses(
    samples: &[Sample<f64>],
    start: Option<YawModel<f64>>,
) -> Result<Hypotheses, RefineFailure> {
    Hypotheses::of(RecordSeries::new(most_excited(samples), 1).series(), start)
}
