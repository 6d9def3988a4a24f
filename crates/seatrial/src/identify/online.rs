//! The core's online estimator, run over a recorded segment.

use std::collections::BTreeMap;

use seatrial_core::InvalidSetting;
use seatrial_core::estimator::{Estimator, EstimatorSettings, Intake};
use seatrial_core::{Real, Sample};

use super::batch::BatchLeastSquares;
use crate::identification::{
    Convergence, EstimateMethod, LeastSquares, Online, RejectedSamples, TracePoint,
};

/// Sample counts at which the least squares estimate is kept for comparison.
const CHECKPOINTS: [usize; 2] = [100, 200];

/// What the estimator is given.
#[derive(Clone, Copy, Debug)]
pub struct Segment<'a> {
    /// Samples before the training: they move the filters only.
    pub settling: &'a [Sample<f64>],
    /// The training samples.
    pub training: &'a [Sample<f64>],
    /// Training samples before this time move the filters only, s.
    pub learns_from_s: f64,
    /// When the rudder had been deflected to both sides and came back, s: convergence is watched and the instrument
    /// takes over from here. `None`: never.
    pub excited_by_s: Option<f64>,
}

/// What a pass over a segment gave.
#[derive(Clone, Debug)]
pub struct Pass {
    /// The estimate.
    pub online: Online,
    /// Training samples that the estimate learnt from.
    pub samples_used: usize,
    /// Samples that the guard rejected, settling included.
    pub rejected: RejectedSamples,
    /// m of the restoring moment, 1/s^2, where the settings have one.
    pub restoring_per_s2: Option<f64>,
    /// The training samples that it let through, headings unwrapped.
    pub accepted: Vec<Sample<f64>>,
}

/// Runs an estimator over the segment; `after_each` sees it after every training sample.
pub fn run(
    segment: &Segment,
    settings: EstimatorSettings<f64>,
    mut after_each: impl FnMut(&Estimator<f64>, &Sample<f64>, Intake),
) -> Result<Estimator<f64>, InvalidSetting> {
    let mut estimator = Estimator::new(settings)?;
    for s in segment.settling {
        let _ = estimator.warm(s.time_s, s.heading_rad, s.rudder_rad);
    }
    let mut excited_by_s = segment.excited_by_s;
    for s in segment.training {
        if s.time_s < segment.learns_from_s {
            let intake = estimator.warm(s.time_s, s.heading_rad, s.rudder_rad);
            after_each(&estimator, s, intake);
            continue;
        }
        if excited_by_s.is_some_and(|ended| s.time_s >= ended) {
            estimator.excitation_ended();
            excited_by_s = None;
        }
        let intake = estimator.update(s.time_s, s.heading_rad, s.rudder_rad);
        after_each(&estimator, s, intake);
    }
    Ok(estimator)
}

/// Runs an estimator over the segment and keeps what a report needs.
///
/// ```
/// use seatrial::identify::online::{Segment, estimate};
/// use seatrial_core::{EstimatorSettings, InvalidSetting};
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
/// let (settling, training) = record.samples[..330].split_at(20);
/// // The doublet ends after 6 s.
/// let segment = Segment { settling, training, learns_from_s: 1.0, excited_by_s: Some(6.0) };
/// let pass = estimate(&segment, EstimatorSettings::default(), false)?;
/// assert!((pass.online.model.b2_per_s2 - 1.08).abs() < 0.03);
/// assert!(pass.online.convergence.detected_s.is_some());
/// # Ok::<(), InvalidSetting>(())
/// ```
pub fn estimate(
    segment: &Segment,
    settings: EstimatorSettings<f64>,
    keep_trace: bool,
) -> Result<Pass, InvalidSetting> {
    let mut batch = BatchLeastSquares::default();
    let mut theta_at = BTreeMap::new();
    let mut trace = Vec::new();
    let mut samples_used = 0;
    let mut accepted = Vec::with_capacity(segment.training.len());
    let estimator = run(segment, settings, |estimator, sample, intake| {
        if !matches!(intake, Intake::Rejected(_)) {
            accepted.push(unwrapped(*sample, accepted.last(), estimator.filtered().yaw_rate_rad_s));
        }
        if intake != Intake::Used {
            return;
        }
        samples_used += 1;
        let filtered = estimator.filtered();
        batch.add(
            [filtered.yaw_rate_rad_s, filtered.rudder_rad, 1.0],
            filtered.yaw_acceleration_rad_s2,
        );
        if CHECKPOINTS.contains(&samples_used) {
            theta_at.insert(samples_used.to_string(), estimator.least_squares_model().theta());
        }
        if keep_trace {
            trace.push(TracePoint {
                time_s: sample.time_s,
                theta: estimator.model().theta(),
                step_norm: estimator.step_norm(),
            });
        }
    })?;
    Ok(Pass {
        online: Online { batch: batch.solve(), theta_at, trace, ..reported(&estimator, segment) },
        samples_used,
        rejected: estimator.rejected().into(),
        restoring_per_s2: estimator.restoring_per_s2(),
        accepted,
    })
}

/// What the estimator itself says at the end of a segment.
fn reported(estimator: &Estimator<f64>, segment: &Segment) -> Online {
    let model = estimator.model();
    let covariance = estimator.covariance();
    let criterion = estimator.settings().convergence;
    // The estimator counts from the first sample that it may learn from.
    let mut times = segment.training.iter().map(|s| s.time_s);
    let warming_s = times.clone().next().map_or(0.0, |first| {
        let learns = times.find(|time| *time >= segment.learns_from_s);
        learns.map_or(0.0, |from| from - first)
    });
    Online {
        method: match estimator.instrument() {
            Some(_) => EstimateMethod::InstrumentalVariable,
            None => EstimateMethod::LeastSquares,
        },
        model,
        delta0_rad: model.delta0_rad(),
        covariance,
        least_squares: LeastSquares { model: estimator.least_squares_model(), covariance },
        batch: None,
        theta_at: BTreeMap::new(),
        convergence: Convergence {
            detected_s: estimator.converged_s().map(|after_s| after_s + warming_s),
            threshold: criterion.threshold,
            consecutive: criterion.consecutive,
        },
        trace: Vec::new(),
    }
}

/// The sample with its heading continued from the one before, which the vehicle left at `yaw_rate_rad_s`.
fn unwrapped(sample: Sample<f64>, last: Option<&Sample<f64>>, yaw_rate_rad_s: f64) -> Sample<f64> {
    let Some(last) = last else {
        return sample;
    };
    let predicted = last.heading_rad + yaw_rate_rad_s * (sample.time_s - last.time_s);
    Sample { heading_rad: predicted + Real::wrapped(sample.heading_rad - predicted), ..sample }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial_core::YawModel;
    use seatrial_core::model::YawState;

    /// The estimator counts from where it learns, the result from where the window starts.
    #[test]
    fn exact_convergence_counts_from_the_start_of_training() {
        let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
        let mut state = YawState::default();
        let samples: Vec<Sample<f64>> = (0..330)
            .map(|k| {
                let time_s = 100.0 + f64::from(k) * 0.05;
                let rudder_rad = match k {
                    60..100 => 0.26,
                    100..140 => -0.26,
                    _ => 0.0,
                };
                let sample = Sample {
                    time_s,
                    heading_rad: state.heading_rad,
                    rudder_rad,
                    ..Sample::default()
                };
                state = model.advance(state, rudder_rad, 0.05);
                sample
            })
            .collect();
        let segment = Segment {
            settling: &[],
            training: &samples,
            learns_from_s: 102.0,
            excited_by_s: Some(107.0),
        };
        let pass = estimate(&segment, EstimatorSettings::default(), true).unwrap();
        let convergence = pass.online.convergence;
        let consecutive = f64::from(convergence.consecutive);
        let trace = &pass.online.trace;
        let met =
            |point: &&TracePoint| point.time_s >= 107.0 && point.step_norm < convergence.threshold;
        let first = trace.iter().find(met).unwrap().time_s - 100.0;
        // Noise-free, it stays met once it is: the last of the consecutive times is reported.
        let expected = first + (consecutive - 1.0) * 0.05;
        assert!((convergence.detected_s.unwrap() - expected).abs() < 1e-6);
    }
}
