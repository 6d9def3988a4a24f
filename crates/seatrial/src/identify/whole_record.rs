//! The robust estimate of samples, as the chain and its documents take it.

use nalgebra::Matrix3;
use seatrial_core::refine::RefineFailure;
use seatrial_core::{Sample, YawModel};

use super::excited_segment::most_excited;
use super::intervals::normal_intervals;
use super::pace::Pace;
use super::residual_tests::ResidualTests;
use super::robust::estimate::{RobustEstimate, Source};
use super::robust::record::Record;
use crate::identification::{EstimateMethod, HigherOrder, Intervals, LagEffect, Refined};
use crate::likelihood::{SteeringModel, Structure};
use crate::record_series::RecordSeries;

/// The lag whose effect is told, s: that of an ordinary servo.
const ORDINARY_LAG_S: f64 = 0.1;

/// A lag this many standard deviations away is ruled out by the record itself.
const RULED_OUT: f64 = 3.0;

/// Fewest samples to estimate from.
const LEAST_SAMPLES: usize = 20;

/// From a disturbance of this share of the rudder's effect on other structures are tried: sound records without a sea have at most 0.001, those
/// whose first-order model misses the steady turn by more than a tenth 0.03 and more.
pub const LEAST_SHARE: f64 = 0.03;

/// Noise of the heading so many times that between neighbouring samples, and beyond half a degree, is motion that the model does not explain.
const MANY_TIMES: f64 = 20.0;
const LEAST_NOISE_RAD: f64 = 0.0087;

/// Headings that repeat in more than this share of the rows are rounded or held, and their step tells their resolution.
const COARSE_SHARE: f64 = 0.1;

/// What a whole record says of its vehicle.
#[derive(Clone, Debug)]
pub struct WholeRecord {
    /// Model and intervals.
    pub refined: Refined,
    /// All that was found.
    pub robust: RobustEstimate,
    /// Are the prediction errors of the likeliest model white?
    pub residual: Option<ResidualTests>,
}

/// The robust estimate of a record: lag, timing, disturbance and error of the model in one likelihood, beside the nearest simulation.
///
/// A record of more than 10 000 samples is cut to its most excited segment. `samples` are finite and increase in time;
/// headings may be wrapped.
pub fn robust_estimate(samples: &[Sample<f64>]) -> Result<WholeRecord, RefineFailure> {
    robust_estimate_behind(samples, None)
}

/// [`robust_estimate`] of a rudder whose lag and shift together are known from elsewhere, s.
///
/// Two records of one vehicle share their lag: what is not known of it makes each of them uncertain, but not their difference.
pub fn robust_estimate_behind(
    samples: &[Sample<f64>],
    known_delay_s: Option<f64>,
) -> Result<WholeRecord, RefineFailure> {
    let samples = most_excited(samples);
    if samples.len() < LEAST_SAMPLES {
        return Err(RefineFailure::TooShort { found: samples.len() });
    }
    let record = record_of(samples).delayed_by(known_delay_s);
    let robust = RobustEstimate::of(&record).ok_or(RefineFailure::NotExcited)?;
    let rudder_rad: Vec<f64> = (record.rudder_rad.chunks_exact(robust.block))
        .map(|block| block.iter().sum::<f64>() / block.len() as f64)
        .collect();
    Ok(WholeRecord {
        refined: refined(&robust),
        residual: ResidualTests::of(&robust.innovations, &rudder_rad),
        robust,
    })
}

impl WholeRecord {
    /// Lag and shift of the rudder together, s.
    pub fn delay_s(&self) -> f64 {
        self.robust.lag_slope.delay_s[0]
    }

    /// Is what the model misses the hull's, not the sea's?
    pub fn is_nearest(&self) -> bool {
        self.robust.source == Source::Nearest
    }

    /// Is what a first-order vehicle misses more than chance explains, so that other structures are to be tried?
    pub fn asks_for_more(&self, samples: &[Sample<f64>]) -> bool {
        self.is_nearest() || self.robust.share > LEAST_SHARE || self.calls_motion_noise(samples)
    }

    /// Is what it takes for noise of the heading many times what differs from one sample to the next?
    fn calls_motion_noise(&self, samples: &[Sample<f64>]) -> bool {
        let heading_rad = RecordSeries::new(samples, 1).heading_rad;
        let square: f64 =
            heading_rad.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2)).sum();
        // The third difference of white noise has 20 times its variance.
        let white_rad = (square / (20.0 * heading_rad.len() as f64)).sqrt();
        self.refined.heading_noise_rad > (MANY_TIMES * white_rad).max(LEAST_NOISE_RAD)
    }

    /// The first-order vehicle, behind its rudder where that lags.
    pub fn steering_model(&self) -> SteeringModel {
        let lag_s = self.robust.lag.map_or(0.0, |lag| lag.delay_s);
        SteeringModel::first_order(&self.refined.model, lag_s)
    }

    /// The first-order vehicle behind its lagging rudder, where the record asks for one.
    pub fn lagging(&self) -> Option<HigherOrder> {
        let lag = self.robust.lag?;
        Some(HigherOrder {
            structure: Structure::LAG,
            model: self.steering_model(),
            lag_interval_s: Some(lag.interval_s),
            steady_log_gain: None,
            steady_rudder_rad: None,
            least_r2_left_out: None,
            hypotheses: Vec::new(),
            gain_vehicle: None,
            validation: None,
        })
    }

    /// What a lag of 0.1 s would do to the model, where the record does not rule it out.
    pub fn lag_effect(&self) -> Option<LagEffect> {
        let slope = &self.robust.lag_slope;
        let [delay_s, deviation_s] = slope.delay_s;
        let more_s = ORDINARY_LAG_S - delay_s;
        let model = &self.refined.model;
        (more_s.abs() < RULED_OUT * deviation_s).then_some(LagEffect {
            lag_s: ORDINARY_LAG_S,
            a22_per_s: model.a22_per_s + slope.slope[0] * more_s,
            b2_per_s2: model.b2_per_s2 + slope.slope[1] * more_s,
        })
    }
}

fn record_of(samples: &[Sample<f64>]) -> Record {
    let series = RecordSeries::new(samples, 1);
    let time_s = samples.iter().map(|s| s.time_s - samples[0].time_s);
    let resolution_rad = resolution_rad(&series.heading_rad);
    let record =
        Record::new(time_s.collect(), series.heading_rad, series.rudder_rad, resolution_rad);
    match Pace::of(samples) {
        Some(pace) => record.timed_to(pace.slowest_s()),
        None => record,
    }
}

/// The smallest step of headings that repeat, rad; 0 where they hardly do.
fn resolution_rad(heading_rad: &[f64]) -> f64 {
    let steps = heading_rad.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let repeats = steps.clone().filter(|step| *step == 0.0).count();
    if (repeats as f64) < COARSE_SHARE * heading_rad.len() as f64 {
        return 0.0;
    }
    steps.filter(|step| *step > 1e-9).fold(f64::INFINITY, f64::min).min(1.0)
}

fn refined(robust: &RobustEstimate) -> Refined {
    let model = YawModel::from_theta(robust.theta);
    let covariance = Matrix3::from(robust.covariance);
    Refined {
        method: match robust.source {
            Source::Nearest => EstimateMethod::OutputError,
            Source::Averaged if robust.lag.is_some() => EstimateMethod::RudderLag,
            Source::Averaged => EstimateMethod::AveragedRestrictedLikelihood,
        },
        model,
        delta0_rad: model.delta0_rad(),
        interval_95: Intervals {
            a22_per_s: robust.interval_95[0],
            b2_per_s2: robust.interval_95[1],
            c0_rad_per_s2: robust.interval_95[2],
            ..normal_intervals(&model, &covariance)
        },
        covariance: robust.covariance,
        heading_noise_rad: robust.heading_noise_rad,
        disturbance_rad_s2: robust.disturbance_rad_s2,
    }
}
