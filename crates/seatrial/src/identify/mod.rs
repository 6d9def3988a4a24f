//! From a record to a model: a chain of values, each made once from the one before.
//!
//! ```text
//! TrainingRecord -> Explanation -> ModelChoice -> ModelEvidence -> Verdict
//! ```
//!
//! | link | what it holds |
//! |---|---|
//! | `TrainingRecord` | the training record, the estimate made sample by sample |
//! | `Explanation` | which kind of vehicle explains the record |
//! | `ModelChoice` | the model that goes to the controller, and where it comes from |
//! | `ModelEvidence` | that model against its own record and against validation data |
//! | [`Verdict`] | may the model be used, and why |

pub mod batch;
mod beyond;
pub(crate) mod compass;
pub mod cramer_rao;
mod cross_validation;
#[cfg(test)]
mod disturbance_study;
mod edge_times;
pub(crate) mod error;
pub mod evenly_sampled;
mod excited_segment;
pub(crate) mod explanation;
mod gyro_heading;
mod heading_gain;
pub(crate) mod intervals;
pub mod joint_estimate;
mod late_yaw_rate;
pub(crate) mod log_statistics;
pub(crate) mod misfit;
mod mishap;
pub mod mission;
pub(crate) mod model_choice;
pub(crate) mod model_evidence;
pub mod online;
pub mod output_error;
pub(crate) mod pace;
mod proposal;
pub mod refined;
pub(crate) mod refusal;
pub mod residual_tests;
pub mod robust;
mod settings;
pub mod simplex;
pub(crate) mod steering_validation;
mod sums;
mod survey;
mod training;
pub(crate) mod training_record;
mod valid_range;
pub mod validation;
mod validation_estimate;
pub mod verdict;
pub mod whole_record;

use seatrial_core::heading_loop::LoopTiming;

use crate::figures::three_figures;
use crate::gain_allowance::sampled;
use crate::identification::{
    HigherOrder, Identification, LagEffect, Reason, ReasonCode, Refined, Settings, ValidRange,
    Validation, Verdict,
};
use crate::record::{Record, Window};
use crate::time_scale::ChosenLambda;
use beyond::hull_of;
use cross_validation::validated_by_legs;
pub use error::{IdentifyError, WindowUse};
pub(crate) use excited_segment::most_excited;
use explanation::{Explanation, predicts_much_better};
use gyro_heading::where_the_compass_jumped;
use joint_estimate::JointEstimate;
pub(crate) use mishap::heading_jump;
use mission::Steering;
use model_choice::ModelChoice;
use model_evidence::ModelEvidence;
use online::Pass;
pub use proposal::{Proposal, Single, propose, singles};
pub use settings::IdentifySettings;
pub use steering_validation::simulated;
pub use survey::RecordSurvey;
pub(crate) use training::Training;
use training::{choose_lambda, manoeuvre_to_learn_from};
use training_record::TrainingRecord;
pub use valid_range::valid_range;
pub use validation::ValidationData;
pub use validation_estimate::validation_estimate;

/// Manoeuvres that differ by more than chance would once in a hundred times are not of one vehicle at one speed.
const LEAST_PROBABILITY: f64 = 0.01;

/// Identifies the yaw model from the training window of a record, and validates it on validation data.
///
/// The filters are warmed on what the record holds before the window. The excitation counts as over when the
/// rudder has been deflected to both sides and comes back from the second: the end of a doublet, the end of
/// the first cycle of a zig-zag. From there on convergence is watched and the instrument is used.
///
/// ```
/// use seatrial::Window;
/// use seatrial::identify::{IdentifySettings, ValidationData, identify};
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
/// let training = Window { from_s: 0.0, to_s: 16.5 };
/// let window = Window { from_s: 16.5, to_s: 33.0 };
/// let data = ValidationData { record: &record, window };
/// let found = identify(&record, training, Some(data), &IdentifySettings::default())?;
/// assert!(found.verdict.accepted);
/// assert!(found.validation.is_some_and(|validation| validation.r2_heading > Some(0.99)));
/// // A rudder that lies still tells nothing.
/// let mut still = record.clone();
/// still.samples.iter_mut().for_each(|sample| sample.rudder_rad = 0.0);
/// assert!(identify(&still, training, None, &IdentifySettings::default()).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn identify(
    record: &Record,
    training: Window,
    data: Option<ValidationData>,
    settings: &IdentifySettings,
) -> Result<Identification, IdentifyError> {
    RecordSurvey::of(record).identify(training, data, settings)
}

/// [`identify`] of a record that was looked through.
fn model_of(
    record: &RecordSurvey,
    training: Window,
    data: Option<ValidationData>,
    settings: &IdentifySettings,
) -> Result<Identification, IdentifyError> {
    let by_its_heading = |record: &RecordSurvey, data: Option<ValidationData>| {
        Ok((by_this_heading(record, training, data, settings)?, None))
    };
    Ok(where_the_compass_jumped(record, &[training], data, by_its_heading)?.0)
}

/// [`identify`] by the heading of the record as it is.
fn by_this_heading(
    record: &RecordSurvey,
    training: Window,
    data: Option<ValidationData>,
    settings: &IdentifySettings,
) -> Result<Identification, IdentifyError> {
    if let Some(found) = steering_model_of(record, training, data, settings)? {
        return Ok(found);
    }
    let (alone, _) = identify_with(record, training, data, settings, &[], OrderSearch::Done)?;
    Ok(match data {
        None if settings.refine => validated_by_legs(alone, record, training, settings),
        _ => alone,
    })
}

/// The model of ordinary steering, where the window is that.
fn steering_model_of(
    record: &RecordSurvey,
    training: Window,
    data: Option<ValidationData>,
    settings: &IdentifySettings,
) -> Result<Option<Identification>, IdentifyError> {
    let is_asked_for = settings.refine && !settings.as_paper;
    let samples = record.record().window(training);
    if !(is_asked_for && mission::is_ordinary_steering(samples)) {
        return Ok(None);
    }
    let ready = Training::new(record.record(), training, settings)?;
    let pass = ready.estimate()?;
    let used = Settings { lambda_because: ready.lambda_because, ..Settings::of(&ready.estimator) };
    let Some(steering) = Steering::of(record, training, data, &pass)? else {
        return Ok(None);
    };
    let a22_per_s = steering.refined.model.a22_per_s;
    let hull = match steering.predicts() {
        true => None,
        false => hull_of(samples, a22_per_s),
    };
    let held_out = ValidationData {
        record: data.map_or(record.record(), |data| data.record),
        window: steering.held_out.window,
    };
    let is_hull = |hull: &HigherOrder| {
        predicts_much_better(&hull.model, &steering.steering_model(), Some(held_out))
    };
    let is_of_a_hull = hull.as_ref().is_some_and(is_hull);
    let verdict = verdict::judge_steering(&steering, is_of_a_hull);
    let validated = data.map_or(&[][..], |data| data.record.window(data.window));
    let mut found = steering.identification(training, pass, used, validated, verdict);
    if !found.verdict.accepted {
        // Course changes of a log that is refused tell no hull: on a tanker's random runs one predicted the other half worse than first order.
        let of_the_gear = |beyond: &HigherOrder| !beyond.structure.has_own_hull();
        found.higher_order = hull.or(found.higher_order.filter(of_the_gear));
    }
    Ok(Some(found))
}

/// [`identify`] with the refined estimates of other manoeuvres of the same speed joined to the record's own.
fn identify_with(
    record: &RecordSurvey,
    training: Window,
    data: Option<ValidationData>,
    settings: &IdentifySettings,
    others: &[(Window, Refined)],
    order: OrderSearch,
) -> Result<(Identification, Option<JointEstimate>), IdentifyError> {
    let ready = Training::new(record.record(), training, settings)?;
    let pass = ready.estimate()?;
    let used = Settings {
        as_paper: settings.as_paper,
        lambda_because: ready.lambda_because,
        ..Settings::of(&ready.estimator)
    };
    let window = training.known_part(ready.samples);
    let training_record = TrainingRecord::new(record, window, &pass, settings.refine)?;
    let assessment = Assessment::of(&training_record, data, others, order)?;
    Ok(assessment.identification(window, pass, used))
}

/// Identifies one model from several manoeuvres of one speed, validates it on validation data and judges it.
///
/// Each manoeuvre is refined by itself; [`joint_estimate`] says how they are put together. A manoeuvre that gives no model is left out.
///
/// ```
/// use seatrial::Window;
/// use seatrial::identify::{IdentifySettings, identify_joined};
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
/// let windows = [0.0, 16.5].map(|from_s| Window { from_s, to_s: from_s + 16.5 });
/// let (found, joined) = identify_joined(&record, &windows, None, &IdentifySettings::default())?;
/// // What two manoeuvres tell together, and each by itself.
/// assert!((found.model().b2_per_s2 - 1.08).abs() < 0.02);
/// assert_eq!(joined.map(|joined| joined.manoeuvres.len()), Some(2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn identify_joined(
    record: &Record,
    training: &[Window],
    data: Option<ValidationData>,
    settings: &IdentifySettings,
) -> Result<(Identification, Option<JointEstimate>), IdentifyError> {
    RecordSurvey::of(record).identify_joined(training, data, settings)
}

/// [`identify_joined`] of a record that was looked through.
fn joined_model(
    record: &RecordSurvey,
    training: &[Window],
    data: Option<ValidationData>,
    settings: &IdentifySettings,
) -> Result<(Identification, Option<JointEstimate>), IdentifyError> {
    where_the_compass_jumped(record, training, data, |record, data| {
        joined_by_this_heading(record, training, data, settings)
    })
}

fn joined_by_this_heading(
    record: &RecordSurvey,
    training: &[Window],
    data: Option<ValidationData>,
    settings: &IdentifySettings,
) -> Result<(Identification, Option<JointEstimate>), IdentifyError> {
    let (first, more) = match training {
        [] => (Window::ALL, &[][..]),
        [first, more @ ..] => (*first, more),
    };
    let others: Vec<(Window, Refined)> = more
        .iter()
        .filter_map(|window| {
            let (alone, _) =
                identify_with(record, *window, None, settings, &[], OrderSearch::Skipped).ok()?;
            Some((*window, alone.refined?))
        })
        .collect();
    let (identification, joined) =
        identify_with(record, first, data, settings, &others, OrderSearch::Done)?;
    let mut identification = match data {
        None if settings.refine => validated_by_legs(identification, record, first, settings),
        _ => identification,
    };
    if let Some(joined) = joined.as_ref().filter(|j| j.consistency < LEAST_PROBABILITY) {
        identification.verdict.reasons.push(Reason::new(
            ReasonCode::ManoeuvresDiffer,
            format!(
                "{} manoeuvres of this speed differ by more than chance explains (p = {}), and the interval is {} times as wide for it: was the speed, the load or the weather the same?",
                joined.manoeuvres.len(),
                three_figures(joined.consistency),
                three_figures(joined.birge_ratio)
            ),
        ));
    }
    Ok((identification, joined))
}

/// The pole of the state variable filter by a first estimate from a window; an error where it gives none.
pub fn lambda_of(record: &Record, window: Window) -> Result<ChosenLambda, IdentifyError> {
    let samples = record.window(window);
    let heading_range_rad = validation::heading_range_rad(samples);
    let manoeuvre = manoeuvre_to_learn_from(record, samples)?;
    let settings = IdentifySettings::default();
    Ok(choose_lambda(record, samples, &manoeuvre, heading_range_rad, &settings))
}

/// Refines an online estimate on its training record, validates it on validation data and gives the verdict.
///
/// The refined model, where there is one, is the one that is validated and goes to the controller: it uses
/// every sample at its true weight and states how sure it is. Where the record shows more than a first-order
/// model, the online estimate takes its place with a wider interval; where a lagging rudder explains all of it, the
/// model behind the lag. Where the rudder moved far while samples were lost, the heading shows when; where there is so
/// little noise that the mean of the rudder over such an interval is not enough, the online estimate is used as well. Under a
/// large disturbance the intervals reach the online estimate; where validation data give another
/// model, they reach it, and that of C0 takes the disturbance of the validation data into account.
pub fn assess(
    record: &Record,
    training: Window,
    data: Option<ValidationData>,
    pass: Pass,
    settings: Settings,
) -> Result<Identification, IdentifyError> {
    let record = RecordSurvey::of(record);
    let training_record = TrainingRecord::new(&record, training, &pass, !settings.as_paper)?;
    let assessment = Assessment::of(&training_record, data, &[], OrderSearch::Done)?;
    Ok(assessment.identification(training, pass, settings).0)
}

/// Is the structure of a vehicle of higher order looked for? It takes most of the time and changes no first-order model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OrderSearch {
    /// For the model that is handed over.
    Done,
    /// For a model that another one is joined with or validated by.
    Skipped,
}

/// What the chain found of a training record.
struct Assessment {
    refined: Option<Refined>,
    joined: Option<JointEstimate>,
    validation: Option<Validation>,
    higher_order: Option<HigherOrder>,
    lag_effect: Option<LagEffect>,
    loop_timing: Option<LoopTiming<f64>>,
    valid_range: Option<ValidRange>,
    verdict: Verdict,
}

impl Assessment {
    fn of(
        training_record: &TrainingRecord,
        data: Option<ValidationData>,
        others: &[(Window, Refined)],
        order: OrderSearch,
    ) -> Result<Self, IdentifyError> {
        let explanation = Explanation::of(training_record, order, data);
        let choice = ModelChoice::of(training_record, &explanation, others, data);
        let evidence = ModelEvidence::of(training_record, &explanation, &choice, data)?;
        let rudder_lag_s = choice
            .simulated()
            .map_or(0.0, |model| model.gear_delay_s(training_record.log.rudder_amplitude_rad));
        Ok(Self {
            verdict: verdict::judge(&evidence),
            valid_range: evidence.valid_range(training_record.accepted, data),
            refined: evidence.refined(),
            validation: evidence.validation,
            higher_order: evidence.higher_order,
            lag_effect: explanation.first_order().and_then(|fit| fit.lag_effect),
            loop_timing: training_record.interval_s.map(|h| sampled(h, rudder_lag_s)),
            joined: choice.joined,
        })
    }

    fn identification(
        self,
        training: Window,
        pass: Pass,
        settings: Settings,
    ) -> (Identification, Option<JointEstimate>) {
        let model = self.refined.as_ref().map_or(pass.online.model, |refined| refined.model);
        let identification = Identification {
            training,
            samples_used: pass.samples_used,
            samples_rejected: pass.rejected,
            nomoto: model.nomoto(),
            restoring: None,
            online: pass.online,
            refined: self.refined,
            validation: self.validation,
            higher_order: self.higher_order,
            lag_effect: self.lag_effect,
            loop_timing: self.loop_timing.filter(|_| !settings.as_paper),
            valid_range: self.valid_range,
            verdict: self.verdict,
            settings,
        };
        (identification, self.joined)
    }
}
