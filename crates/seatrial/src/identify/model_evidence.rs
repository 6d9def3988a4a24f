//! Fourth link of the chain: the chosen model against its own record and against validation data.

use seatrial_core::{GoodnessOfFit, Sample, YawModel};

use super::compass::{CompassError, Jump};
use super::error::IdentifyError;
use super::explanation::Explanation;
use super::intervals::reaching_validation;
use super::late_yaw_rate::{record_in_time, with_yaw_rate_in_time};
use super::log_statistics::LogStatistics;
use super::misfit::disturbance_share;
use super::mishap::Mishaps;
use super::model_choice::ModelChoice;
use super::steering_validation;
use super::training_record::TrainingRecord;
use super::valid_range::valid_range;
use super::validation::{self, ValidationData};
use super::validation_estimate::validation_estimate_behind;
use super::whole_record::LEAST_SHARE;
use crate::identification::{EstimateMethod, HigherOrder, Refined, ValidRange, Validation};
use crate::likelihood::Parameter;
use crate::likelihood::leg::deviation;
use crate::manoeuvre::Manoeuvre;
use crate::plausibility::{self, Doubt};
use crate::record::{duration_s, mean};

/// R^2 of the yaw rate below which the model of a vehicle in a sea describes nothing.
pub const LEAST_R2_IN_A_SEA: f64 = 0.5;

/// The chosen model and what its own record and validation data say of it: all that a verdict weighs.
pub struct ModelEvidence<'a> {
    /// How good the log is.
    pub log: &'a LogStatistics,
    /// The estimate made sample by sample.
    pub online: YawModel<f64>,
    /// Must there be an estimate from the whole record with its interval?
    pub needs_interval: bool,
    /// Which kind of vehicle explains the record.
    pub explanation: &'a Explanation,
    /// The model that goes to the controller.
    pub choice: &'a ModelChoice,
    /// What in the log, or in that of the validation data, may not mean what it says.
    pub doubts: Vec<Doubt>,
    /// The model of higher order on validation data, where the record supports one.
    pub higher_order: Option<HigherOrder>,
    /// R^2 on the training record itself.
    pub training_fit: GoodnessOfFit<f64>,
    /// R^2 on validation data.
    pub validation: Option<Validation>,
    /// Half of the rudder's range in validation, rad.
    pub validation_rudder_amplitude_rad: Option<f64>,
    /// What validation data that are not those of the training say by themselves.
    pub independent: Option<Independent>,
    /// What happened once, where the model does not hold.
    pub mishaps: Mishaps,
}

/// What validation data say by themselves.
#[derive(Clone, Debug)]
pub struct Independent {
    /// Their length over that of the training.
    pub length: f64,
    /// Variance of their rudder over that of the training.
    pub rudder_variance_ratio: f64,
    /// Mean speeds of the training and of these data, m/s, where both were logged.
    pub surge_speeds_m_s: Option<[f64; 2]>,
    /// The largest jump of the heading from where the measured yaw rate takes it.
    pub largest_jump: Option<Jump>,
    /// The estimate made from them alone, where they give one that may be compared.
    pub estimate: Option<Refined>,
}

impl<'a> ModelEvidence<'a> {
    /// Simulates the chosen model over the training and over validation data.
    pub fn of(
        training_record: &'a TrainingRecord,
        explanation: &'a Explanation,
        choice: &'a ModelChoice,
        data: Option<ValidationData>,
    ) -> Result<Self, IdentifyError> {
        let late_s = training_record.log.compass.yaw_rate_late_s();
        let in_time = data.map(|data| record_in_time(&data, late_s));
        let data_in_time = data
            .zip(in_time.as_deref())
            .map(|(data, record)| ValidationData { record, window: data.window });
        let validation = data_in_time
            .map(|data| match choice.simulated() {
                Some(model) => steering_validation::validate(model, data.record, data.window),
                None => validation::validate(choice.model, data.record, data.window),
            })
            .transpose()?;
        let training = with_yaw_rate_in_time(training_record.accepted, late_s);
        let is_apart = |data: &ValidationData| {
            training_record.is_to_be_refined() && data.window != training_record.training
        };
        let independent = data
            .filter(is_apart)
            .map(|data| Independent::of(data, training_record, explanation, choice));
        let other = independent.as_ref().and_then(|apart| apart.estimate.as_ref());
        let held_out = data.map_or_else(Vec::new, |data| data.record.usable(data.window));
        let mut evidence = Self {
            mishaps: Mishaps::of(
                [training_record.accepted, &held_out],
                choice.model,
                other.map(|refined| refined.model),
            ),
            log: &training_record.log,
            online: training_record.online,
            needs_interval: training_record.is_to_be_refined(),
            explanation,
            doubts: doubts(training_record, explanation, choice, data),
            choice,
            higher_order: higher_order(explanation, data_in_time)?,
            training_fit: match choice.simulated() {
                Some(model) => steering_validation::goodness_of_fit(model, &training),
                None => validation::fit_by_the_clearer_rate(choice.model, &training),
            },
            validation,
            validation_rudder_amplitude_rad: data
                .and_then(|data| Manoeuvre::find(data.record.window(data.window)))
                .map(|manoeuvre| manoeuvre.amplitude_rad),
            independent,
        };
        evidence.make_gain();
        Ok(evidence)
    }

    /// Finds the vehicle that the heading gain is made for, where the hypotheses decide it.
    fn make_gain(&mut self) {
        let found = (self.refined().zip(self.explanation.vehicles()))
            .and_then(|(refined, vehicles)| vehicles.gain_vehicle(&refined));
        if let Some(higher_order) = &mut self.higher_order {
            higher_order.gain_vehicle = found;
        }
    }

    /// Does no heading gain hold on the vehicles of the hypotheses?
    pub fn has_no_gain(&self) -> bool {
        let found = self.higher_order.as_ref().and_then(|h| h.gain_vehicle);
        self.explanation.vehicles().is_some() && found.is_none()
    }

    /// Is the vehicle known to be turned by a sea as well as by its rudder? Its heading then wanders from any simulation.
    pub fn is_in_a_sea(&self) -> bool {
        self.choice.refined.as_ref().is_some_and(|refined| {
            refined.method != EstimateMethod::OutputError
                && disturbance_share(refined, self.log.rudder_amplitude_rad) > LEAST_SHARE
        })
    }

    /// Does a sea explain a low R^2 of validation data? Then the model leaves of their yaw rate about what it leaves of the training's.
    ///
    /// ```text
    /// (1 - R^2) var(delta) < 4 (1 - R^2_train) var(delta_train)
    /// ```
    pub fn sea_explains_validation(&self) -> bool {
        const MOST_TIMES: f64 = 4.0;
        let (Some(validation), Some(apart)) = (&self.validation, &self.independent) else {
            return false;
        };
        let left = |r2: Option<f64>| r2.map_or(f64::INFINITY, |r2| 1.0 - r2);
        let of_validation = left(validation.r2_yaw_rate);
        self.is_in_a_sea()
            && of_validation < 1.0 - LEAST_R2_IN_A_SEA
            && of_validation * apart.rudder_variance_ratio
                < MOST_TIMES * left(self.training_fit.r2_yaw_rate)
    }

    /// Over what the chosen model was seen, in training and validation.
    pub fn valid_range(
        &self,
        training: &[Sample<f64>],
        data: Option<ValidationData>,
    ) -> Option<ValidRange> {
        let refined = self.choice.refined.as_ref();
        let noise_rad = refined.map_or(0.0, |refined| refined.heading_noise_rad);
        let validation = data.map_or(&[][..], |data| data.record.window(data.window));
        valid_range(&[training, validation], &self.choice.model, noise_rad)
    }

    /// The chosen estimate, with intervals that reach the one of validation data.
    pub fn refined(&self) -> Option<Refined> {
        let refined = self.choice.refined.as_ref()?;
        let apart = self.independent.as_ref();
        Some(match apart.and_then(|apart| Some((apart.estimate.as_ref()?, apart.length))) {
            Some((estimate, length)) => reaching_validation(refined, estimate, length),
            None => refined.clone(),
        })
    }
}

/// The model beyond first order with its simulation of validation data.
fn higher_order(
    explanation: &Explanation,
    data: Option<ValidationData>,
) -> Result<Option<HigherOrder>, IdentifyError> {
    let Some(beyond) = explanation.beyond() else {
        return Ok(None);
    };
    let validate = |data: ValidationData| {
        steering_validation::validate(&beyond.model, data.record, data.window)
    };
    Ok(Some(HigherOrder { validation: data.map(validate).transpose()?, ..beyond.clone() }))
}

/// Doubts about the log that trains, about the one that validates, and about how often the vehicle was looked at.
fn doubts(
    training_record: &TrainingRecord,
    explanation: &Explanation,
    choice: &ModelChoice,
    data: Option<ValidationData>,
) -> Vec<Doubt> {
    let mut doubts = training_record.log.unit_doubts.clone();
    let others = data.map_or_else(Vec::new, |data| {
        let mut others = training_record.record.unit_doubts_of(data.record);
        others.extend(plausibility::heading_stood(&data.record.usable(data.window)));
        others
    });
    doubts.extend(
        others.into_iter().filter(|doubt| !training_record.log.unit_doubts.contains(doubt)),
    );
    // A model whose rudder may turn nothing has no time constant to hold the log against.
    let turns = |refined: &Refined| {
        let [low, high] = refined.interval_95.b2_per_s2;
        low * high > 0.0
    };
    let timing = plausibility::timing_doubts(training_record.accepted, choice.model.a22_per_s);
    if choice.refined.as_ref().is_none_or(turns) {
        doubts.extend(timing);
    } else {
        // It may be why the rudder seems to turn nothing.
        let is_held = |doubt: &Doubt| matches!(doubt, Doubt::HeadingHeld { .. }) && doubt.refuses();
        doubts.extend(timing.into_iter().filter(is_held));
    }
    if training_record.log.times_are_shared {
        doubts.extend(plausibility::shared_times(training_record.accepted, choice.model.a22_per_s));
    }
    doubts.extend(heading_smoothed(training_record, explanation, choice));
    doubts.extend(training_record.log.unchecked.iter().cloned());
    doubts
}

/// A smoothed heading, where that may be the lag behind which the vehicle is. Sway is none: real hulls have it.
fn heading_smoothed(
    training_record: &TrainingRecord,
    explanation: &Explanation,
    choice: &ModelChoice,
) -> Option<Doubt> {
    let lags = |beyond: &&HigherOrder| beyond.structure.has(Parameter::Lag);
    let late_s = explanation.beyond().filter(lags)?.model.rudder_lag_s;
    let record = training_record.record.record();
    let is_checked = record.units.are_given() || training_record.log.compass.shows_late;
    let effect = late_s * choice.model.a22_per_s.abs();
    (!is_checked && plausibility::heading_is_smoothed(&record.samples))
        .then_some(Doubt::HeadingSmoothed { late_s, effect })
}

fn rudder_variance(samples: &[Sample<f64>]) -> f64 {
    let rudder_rad: Vec<f64> = samples.iter().map(|sample| sample.rudder_rad).collect();
    deviation(&rudder_rad).powi(2)
}

impl Independent {
    fn of(
        data: ValidationData,
        training_record: &TrainingRecord,
        explanation: &Explanation,
        choice: &ModelChoice,
    ) -> Self {
        let samples = data.record.usable(data.window);
        let mean_speed_m_s =
            |of: &[Sample<f64>]| mean(of.iter().filter_map(|sample| sample.surge_speed_m_s));
        // What a lagging rudder leaves of a first-order model is no match for the model behind the lag.
        let is_comparable = |estimate: &Refined| {
            choice.lagging().is_none() || estimate.method != EstimateMethod::OutputError
        };
        Self {
            length: duration_s(&samples) / duration_s(training_record.samples()),
            rudder_variance_ratio: rudder_variance(&samples)
                / rudder_variance(training_record.samples()),
            surge_speeds_m_s: mean_speed_m_s(training_record.samples())
                .zip(mean_speed_m_s(&samples))
                .map(Into::into),
            largest_jump: CompassError::of(&samples).largest_jump,
            estimate: validation_estimate_behind(
                &samples,
                Some(choice.model),
                explanation.delay_s(),
            )
            .filter(is_comparable)
            .map(|estimate| match choice.lagging() {
                // It was made behind the training's lag.
                Some(_) => Refined { method: EstimateMethod::RudderLag, ..estimate },
                None => estimate,
            }),
        }
    }
}
