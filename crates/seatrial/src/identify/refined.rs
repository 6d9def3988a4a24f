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
