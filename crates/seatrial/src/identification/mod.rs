//! The result of an identification: what `seatrial identify` prints, the logbook keeps and the
//! report draws. Missing things are `None`, never 0 or NaN.

mod code;
mod earlier;
mod in_a_trial;
mod method;
mod reason;
#[cfg(test)]
mod reference_tests;
mod valid_range;

use std::collections::BTreeMap;

use seatrial_core::estimator::EstimatorSettings;
use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::state_variable_filter::Hold;
use seatrial_core::{Nomoto, RejectedCounts, YawModel};
use serde::{Deserialize, Serialize};

use crate::likelihood::steering_model::log_steady_gain;
use crate::likelihood::{SteeringModel, Structure, WeighedHypothesis};
pub use crate::propagation::{
    NORMAL_95, covariance_of_intervals, drawn, interval_95, with_steady_gain,
};
use crate::record::Window;
use crate::servo::Servo;
use crate::time_scale::LambdaReason;
pub use code::{Reader, ReasonCode, ReasonKind, Subject};
pub use method::EstimateMethod;
pub use reason::{Outcome, Reason, Verdict};
pub use valid_range::ValidRange;

/// Below this R^2 on validation data the paper repeats the run (section IV-C).
pub const LEAST_R2: f64 = 0.60;

/// Largest half width of the 95 % interval of a22, as a fraction of it, with which a model is accepted.
pub const WIDEST_A22: f64 = 0.5;

/// Largest half width of the 95 % interval of b2, as a fraction of it, with which a model is accepted.
pub const WIDEST_B2: f64 = 0.4;

/// A model of one speed with its uncertainty, its validation and a verdict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identification {
    /// The training window, half open.
    pub training: Window,
    /// Samples in the training window.
    pub samples_used: usize,
    /// Samples that the guard rejected, by cause.
    pub samples_rejected: RejectedSamples,
    /// How the estimate was made.
    pub settings: Settings,
    /// The estimate made sample by sample.
    pub online: Online,
    /// The estimate made from the whole training record.
    pub refined: Option<Refined>,
    /// Nomoto form of [`model`](Identification::model); of pitch there is none.
    pub nomoto: Option<Nomoto<f64>>,
    /// The moment that rights the vehicle, on the axis of pitch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restoring: Option<Restoring>,
    /// Simulation of validation data.
    pub validation: Option<Validation>,
    /// The model of the order that the record supports, where a first-order one misses something.
    #[serde(default)]
    pub higher_order: Option<HigherOrder>,
    /// What a lag of the rudder that the log does not contain would do to the refined model.
    #[serde(default)]
    pub lag_effect: Option<LagEffect>,
    /// What a heading loop of this vehicle waits for, as far as the record shows: a rudder asked for acts a sample later, through the lag
    /// that the model is behind, and is held over a sample. `None` for the paper's equations to the letter.
    #[serde(default)]
    pub loop_timing: Option<LoopTiming<f64>>,
    /// Over what rudder, headings, speeds and frequencies the model was seen.
    #[serde(default)]
    pub valid_range: Option<ValidRange>,
    /// May the model be used?
    pub verdict: Verdict,
}

impl Identification {
    /// The model that goes to the controller: the refined one where there is one.
    ///
    /// ```
    /// use seatrial::Window;
    /// use seatrial::identify::{IdentifySettings, identify};
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
    /// let found = identify(&record, Window::ALL, None, &IdentifySettings::default())?;
    /// // The estimate from the whole record, not the one made sample by sample.
    /// assert_eq!(Some(found.model()), found.refined.as_ref().map(|refined| refined.model));
    /// assert!((found.model().b2_per_s2 - 1.08).abs() < 0.02);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn model(&self) -> YawModel<f64> {
        self.refined.as_ref().map_or(self.online.model, |r| r.model)
    }

    /// The model with the rudder's lag, where that is the one that goes to the controller.
    pub fn lagging(&self) -> Option<&SteeringModel> {
        let found = self.higher_order.as_ref()?;
        (*self.method() == EstimateMethod::RudderLag).then_some(&found.model)
    }

    /// The model that predicts in the place of the first-order one: behind a lag, or beyond first order.
    pub fn simulated(&self) -> Option<&SteeringModel> {
        let is_beyond = *self.method() == EstimateMethod::WeighedHypotheses;
        let found = self.higher_order.as_ref().filter(|_| is_beyond);
        found.map(|found| &found.model).or_else(|| self.lagging())
    }

    /// The vehicle that the heading gain is made for, where the hypotheses decided it.
    pub fn gain_vehicle(&self) -> Option<GainVehicle> {
        self.higher_order.as_ref()?.gain_vehicle
    }

    /// a22 of the least damped vehicle that a heading gain allows for, 1/s: what the hypotheses decided, else the end of the 95 % interval.
    /// `None` where there is no interval.
    pub fn least_damped_per_s(&self) -> Option<f64> {
        let end = || Some(self.refined.as_ref()?.interval_95.a22_per_s[1]);
        self.gain_vehicle().map(|vehicle| vehicle.a22_per_s).or_else(end)
    }

    /// The steady turns of the hypotheses, where the model is not made of them.
    pub fn steady_turn(&self) -> Option<SteadyTurn> {
        let is_beyond = *self.method() == EstimateMethod::WeighedHypotheses;
        let found = self.higher_order.as_ref().filter(|_| !is_beyond)?;
        Some(SteadyTurn {
            log_gain: found.steady_log_gain?,
            at: found.steady_rudder_rad.map(|rudder_rad| (found.model, rudder_rad)),
        })
    }

    /// Do the validation data lie in the training window? A model of the rest of that window then predicted them.
    pub fn is_validated_within(&self) -> bool {
        let whole = self.training;
        self.validation.is_some_and(|validation| {
            let part = validation.window;
            part != whole && part.from_s >= whole.from_s && part.to_s <= whole.to_s
        })
    }

    /// The method of [`model`](Identification::model).
    pub fn method(&self) -> &EstimateMethod {
        let refined = self.refined.as_ref();
        refined.map_or(&self.online.method, |r| &r.method)
    }

    /// Says that the rudder of the record was the one behind this servo: a loop waits for it, too, and its lag is known.
    pub fn behind(&mut self, servo: Servo) {
        self.verdict.lag_is_known();
        if let Some(timing) = &mut self.loop_timing {
            timing.delay_s += servo.late_s();
        }
    }
}

/// The restoring moment of pitch, m in theta'' = a22 theta' + m theta + b2 delta + C0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Restoring {
    /// m of the online estimator, 1/s^2; negative where it rights the vehicle.
    pub online_per_s2: f64,
    /// m from the whole training record, 1/s^2.
    pub refined_per_s2: f64,
    /// 95 % interval of it, 1/s^2.
    pub interval_95_per_s2: [f64; 2],
}

/// The model beyond the first order, of which the first-order model is the nearest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HigherOrder {
    /// What it has besides linear damping.
    #[serde(default)]
    pub structure: Structure,
    /// The model.
    pub model: SteeringModel,
    /// 95 % interval of the gear's lag, s, where it lags.
    #[serde(default)]
    pub lag_interval_s: Option<[f64; 2]>,
    /// Mean and variance of ln |K|, K in 1/s, of the steady turns that the hypotheses have at the rudder of the record; `None` where they
    /// give none.
    #[serde(default)]
    pub steady_log_gain: Option<[f64; 2]>,
    /// The rudder of the record at which it holds, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steady_rudder_rad: Option<f64>,
    /// R^2 of the heading over the fifth of the record that the other four predict worst; `None` where none was left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_r2_left_out: Option<f64>,
    /// Hypotheses that were weighed, the heaviest first; empty where a lag explained all that first order does not.
    #[serde(default)]
    pub hypotheses: Vec<WeighedHypothesis>,
    /// The vehicle that the heading gain is made for, where the hypotheses decide it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain_vehicle: Option<GainVehicle>,
    /// Its simulation of validation data.
    pub validation: Option<Validation>,
}

/// The steady turns that the hypotheses have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyTurn {
    /// Mean and variance of ln |K|, K in 1/s.
    pub log_gain: [f64; 2],
    /// The vehicle that predicts and the rudder angle, rad, at which `log_gain` holds; `None` where a document does not say.
    pub at: Option<(SteeringModel, f64)>,
}

impl SteadyTurn {
    /// Mean and variance of ln |K| at a rudder angle, rad: damping that grows with the turn takes more of a larger one, play of a smaller.
    pub fn log_gain_at(&self, rudder_rad: f64) -> [f64; 2] {
        let [mean, variance] = self.log_gain;
        let further = self.at.map(|(model, own_rad)| {
            let log_gain = |rudder_rad: f64| log_steady_gain(&model.vehicle(), rudder_rad);
            log_gain(rudder_rad.abs()) - log_gain(own_rad)
        });
        let further = further.filter(|further| further.is_finite()).unwrap_or(0.0);
        [mean + further, variance]
    }
}

/// The first-order vehicle that the heading gain is made for, so that it holds on the vehicles of every hypothesis that weighs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GainVehicle {
    /// Its a22, 1/s; b2 and C0 are those of the model.
    pub a22_per_s: f64,
    /// Least and most overshoot of a course change of 40 deg on those vehicles, rad.
    pub overshoot_rad: [f64; 2],
}

/// The model if the rudder lagged behind what the log says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LagEffect {
    /// Time constant of the lag, s.
    pub lag_s: f64,
    /// a22 then, 1/s.
    pub a22_per_s: f64,
    /// b2 then, 1/s^2.
    pub b2_per_s2: f64,
}

/// Counts of samples that never reached the estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RejectedSamples {
    /// A value was NaN or infinite.
    pub non_finite: u32,
    /// The time of the sample before.
    pub repeated_time: u32,
    /// Earlier than the sample before.
    pub reversed_time: u32,
    /// A heading jump that no rudder makes.
    pub spike: u32,
    /// Gaps after which the filters were warmed again (these are not samples).
    pub gaps: u32,
}

impl RejectedSamples {
    /// Samples rejected, all causes.
    ///
    /// ```
    /// use seatrial::identification::RejectedSamples;
    ///
    /// // Gaps are no samples.
    /// let rejected = RejectedSamples { spike: 2, non_finite: 1, gaps: 5, ..RejectedSamples::default() };
    /// assert_eq!(rejected.total(), 3);
    /// ```
    pub fn total(&self) -> u32 {
        self.non_finite + self.repeated_time + self.reversed_time + self.spike
    }
}

impl From<RejectedCounts> for RejectedSamples {
    fn from(counts: RejectedCounts) -> Self {
        Self {
            non_finite: counts.non_finite,
            repeated_time: counts.repeated_time,
            reversed_time: counts.reversed_time,
            spike: counts.spike,
            gaps: counts.gaps + counts.discontinuities,
        }
    }
}

/// How an estimate was made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The paper's equations to the letter.
    pub as_paper: bool,
    /// Pole of the state variable filter, rad/s.
    pub lambda_rad_s: f64,
    /// Why this lambda.
    pub lambda_because: LambdaReason,
    /// How the heading is taken to run between samples.
    pub heading_hold: Hold,
    /// P0 = p I.
    pub initial_covariance: f64,
    /// 1 keeps every sample for ever.
    pub forgetting_factor: f64,
    /// The servo behind which the rudder of a trial's run was taken to act, where one was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub servo: Option<Servo>,
}

impl Settings {
    /// The settings of an online estimator.
    pub fn of(estimator: &EstimatorSettings<f64>) -> Self {
        Self {
            as_paper: false,
            lambda_rad_s: estimator.lambda_rad_s,
            lambda_because: LambdaReason::Given,
            heading_hold: estimator.heading_hold,
            initial_covariance: estimator.initial_covariance,
            forgetting_factor: estimator.forgetting_factor,
            servo: None,
        }
    }
}

/// The estimate made sample by sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Online {
    /// Least squares, or the instrumental variable where it took over after the excitation.
    pub method: EstimateMethod,
    /// The parameters.
    #[serde(flatten)]
    pub model: YawModel<f64>,
    /// delta0 = C0/b2, rad.
    pub delta0_rad: Option<f64>,
    /// P of the least squares recursion, before scaling by any noise.
    pub covariance: [[f64; 3]; 3],
    /// Recursive least squares on the same samples, without the instrument.
    pub least_squares: LeastSquares,
    /// Batch least squares (34) on the same filtered samples.
    pub batch: Option<YawModel<f64>>,
    /// The least squares estimate [a22, b2, C0] after so many samples, for comparison with other
    /// implementations.
    #[serde(default)]
    pub theta_at: BTreeMap<String, [f64; 3]>,
    /// Criterion (39).
    pub convergence: Convergence,
    /// The estimate after every sample, for plots.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trace: Vec<TracePoint>,
}

/// The estimate of recursive least squares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeastSquares {
    /// The parameters.
    #[serde(flatten)]
    pub model: YawModel<f64>,
    /// The recursion's P, before scaling by any noise.
    pub covariance: [[f64; 3]; 3],
}

/// When the step norm of the parameters stayed under a threshold (39).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// Seconds after the start of training at which it was met, `None` if never.
    pub detected_s: Option<f64>,
    /// The threshold on the step norm.
    pub threshold: f64,
    /// Times in a row it must be met.
    pub consecutive: u32,
}

/// The estimate after one sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TracePoint {
    /// Record time, s.
    pub time_s: f64,
    /// Estimate [a22, b2, C0].
    pub theta: [f64; 3],
    /// Euclidean norm of the change from the estimate before (39).
    pub step_norm: f64,
}

/// The estimate made from the whole training record, with its uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refined {
    /// By which method.
    pub method: EstimateMethod,
    /// The parameters.
    #[serde(flatten)]
    pub model: YawModel<f64>,
    /// delta0 = C0/b2, rad.
    pub delta0_rad: Option<f64>,
    /// 95 % intervals.
    pub interval_95: Intervals,
    /// Covariance of [a22, b2, C0].
    pub covariance: [[f64; 3]; 3],
    /// Standard deviation of the heading noise found, rad.
    pub heading_noise_rad: f64,
    /// Standard deviation of the yaw acceleration disturbance found, rad/s^2.
    pub disturbance_rad_s2: f64,
}

/// 95 % intervals, each `[low, high]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Intervals {
    /// a22, 1/s.
    pub a22_per_s: [f64; 2],
    /// b2, 1/s^2.
    pub b2_per_s2: [f64; 2],
    /// C0, rad/s^2.
    pub c0_rad_per_s2: [f64; 2],
    /// delta0, rad; `None` where b2 may be 0.
    pub delta0_rad: Option<[f64; 2]>,
}

/// How well the model simulates validation data, R^2 (35)-(37).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Validation {
    /// The validation window, half open.
    pub window: Window,
    /// R^2 of heading with the trained offset. `None` where the heading did not vary.
    pub r2_heading: Option<f64>,
    /// R^2 of heading with the offset estimated again.
    pub r2_heading_offset_refit: Option<f64>,
    /// R^2 of yaw rate.
    pub r2_yaw_rate: Option<f64>,
    /// Samples compared.
    pub samples: usize,
    /// How far the model runs free before it starts again from the vehicle, s; `None` where it does so over the whole window.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_s: Option<f64>,
}

impl Validation {
    /// The R^2 of heading on which a verdict rests: with the trained offset where that suffices, else with the offset
    /// estimated again where that is the larger.
    ///
    /// ```
    /// use seatrial::Window;
    /// use seatrial::identification::Validation;
    ///
    /// let validation = Validation {
    ///     window: Window::ALL,
    ///     r2_heading: Some(0.3),
    ///     r2_heading_offset_refit: Some(0.95),
    ///     r2_yaw_rate: Some(0.9),
    ///     samples: 320,
    ///     horizon_s: None,
    /// };
    /// // Wind or trim changed since the training: the offset is estimated again.
    /// assert_eq!(validation.judged_r2_heading(), Some(0.95));
    /// let same_trim = Validation { r2_heading: Some(0.93), ..validation };
    /// assert_eq!(same_trim.judged_r2_heading(), Some(0.93));
    /// ```
    pub fn judged_r2_heading(&self) -> Option<f64> {
        match self.is_judged_with_offset_again() {
            true => self.r2_heading_offset_refit,
            false => self.r2_heading,
        }
    }

    /// Does [`judged_r2_heading`](Self::judged_r2_heading) take the offset from the validation data?
    pub fn is_judged_with_offset_again(&self) -> bool {
        match (self.r2_heading, self.r2_heading_offset_refit) {
            (Some(trained), Some(again)) => trained < LEAST_R2 && trained < again,
            (trained, again) => trained.is_none() && again.is_some(),
        }
    }
}
