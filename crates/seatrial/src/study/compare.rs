//! Every method on the identical record, side by side.

use std::fmt;

use seatrial_core::InvalidSetting;
use seatrial_core::refine::RefineFailure;
use seatrial_core::{Sample, YawModel};
use serde::Serialize;

use crate::identification::{Intervals, Validation};
use crate::identify::intervals::normal_intervals;
use crate::identify::most_excited;
use crate::identify::output_error::output_error;
use crate::identify::refined::prediction_error;
use crate::identify::simplex;
use crate::identify::steering_validation;
use crate::identify::whole_record::robust_estimate;
use crate::identify::{
    IdentifyError, IdentifySettings, Training, ValidationData, identify, online, validation,
};
use crate::likelihood::{SteeringModel, contest_of};
use crate::manoeuvre::Manoeuvre;
use crate::record::{Record, Window};
use crate::time_scale::LambdaReason;

/// Each method's model of one training window, judged by the same validation data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The training window.
    pub training: Window,
    /// Pole of the state variable filter of every method but the paper's, rad/s.
    pub lambda_rad_s: f64,
    /// Why this lambda.
    pub lambda_because: LambdaReason,
    /// One row for each method.
    pub methods: Vec<MethodResult>,
    /// Largest less smallest value over the middle one, methods with a model only.
    pub disagreement: Disagreement,
}

/// What a method made of the record.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodResult {
    /// Which method.
    pub method: ComparedMethod,
    /// The model. `None` where the method found none.
    pub model: Option<YawModel<f64>>,
    /// Why there is no model.
    pub failure: Option<String>,
    /// 95 % intervals, where the method gives them.
    pub interval_95: Option<Intervals>,
    /// R^2 on the validation data.
    pub validation: Option<Validation>,
    /// Iterations of an iterative method.
    pub iterations: Option<u32>,
    /// Wall time of the estimate, ms.
    pub time_ms: f64,
}

/// A method that is compared. In documents its name is in snake case: `batch_least_squares`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ComparedMethod {
    /// Recursive least squares with the paper's settings.
    Paper,
    /// Recursive least squares.
    RecursiveLeastSquares,
    /// The recursive instrumental variable.
    RecursiveInstrumentalVariable,
    /// Batch least squares (34).
    BatchLeastSquares,
    /// The paper's offline search.
    Simplex,
    /// The simulation nearest to the heading.
    OutputError,
    /// The restricted likelihood at its most likely disturbance.
    PredictionError,
    /// The model that [`identify`] hands over, with its intervals.
    Refined,
    /// The model of the order that the record supports.
    HigherOrder,
}

impl ComparedMethod {
    const ALL: [Self; 9] = [
        Self::Paper,
        Self::RecursiveLeastSquares,
        Self::RecursiveInstrumentalVariable,
        Self::BatchLeastSquares,
        Self::Simplex,
        Self::OutputError,
        Self::PredictionError,
        Self::Refined,
        Self::HigherOrder,
    ];

    /// In words: `batch least squares`.
    ///
    /// ```
    /// use seatrial::study::ComparedMethod;
    ///
    /// assert_eq!(ComparedMethod::OutputError.words(), "output error");
    /// ```
    pub fn words(self) -> String {
        self.to_string().replace('_', " ")
    }
}

impl fmt::Display for ComparedMethod {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(f)
    }
}

/// Lead in log evidence that chance explains where several structures are tried.
const LEAST_LEAD: f64 = 5.0;

/// Why a method found no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
enum NoModel {
    #[error("{0}")]
    Setting(InvalidSetting),
    #[error("{0}")]
    Refine(RefineFailure),
    #[error("{0}")]
    Identify(IdentifyError),
    #[error("the whole record gives no estimate with an interval")]
    NotRefined,
    #[error("the regressors are dependent")]
    DependentRegressors,
    #[error("no samples")]
    NoSamples,
    #[error("not converged after {iterations} iterations")]
    NotConverged { iterations: u32 },
    #[error("first order is enough: it leaves no more than chance does, or too little to matter")]
    FirstOrderIsEnough,
}

/// How far apart the methods are, as a fraction of the middle value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Disagreement {
    /// Largest less smallest a22 over the middle one.
    pub a22: Option<f64>,
    /// Largest less smallest b2 over the middle one.
    pub b2: Option<f64>,
}

/// A model, with what else a method can say of it.
struct MethodEstimate {
    model: YawModel<f64>,
    interval_95: Option<Intervals>,
    iterations: Option<u32>,
    /// Where the method simulates more than the model.
    validation: Option<Validation>,
}

/// Runs every method on the training window and validates each model on the validation data.
///
/// `clock_ms` gives the time, ms, since any instant; each method is timed by it.
///
/// ```
/// use seatrial::Window;
/// use seatrial::identify::ValidationData;
/// use seatrial::study::compare;
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
/// let data = ValidationData { record: &record, window: Window { from_s: 16.5, to_s: 33.0 } };
/// let found = compare(&record, Window { from_s: 0.0, to_s: 16.5 }, data, None, &|| 0.0)?;
/// // Every method on the same record; each of them finds this vehicle.
/// let models = found.methods.iter().filter_map(|method| method.model);
/// assert!(models.map(|model| model.b2_per_s2).all(|b2| (b2 / 1.08 - 1.0).abs() < 0.1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn compare(
    record: &Record,
    training: Window,
    data: ValidationData,
    lambda_rad_s: Option<f64>,
    clock_ms: &dyn Fn() -> f64,
) -> Result<Comparison, IdentifyError> {
    let settings = IdentifySettings { lambda_rad_s, ..IdentifySettings::default() };
    let own = Training::new(record, training, &settings)?;
    let paper = Training::new(record, training, &IdentifySettings::paper())?;
    let pass = own.estimate()?;
    let candidates = Candidates {
        record,
        training,
        settings,
        paper: &paper,
        own: &own,
        samples: &pass.accepted,
        data,
    };
    let methods = ComparedMethod::ALL
        .map(|method| timed(method, clock_ms, || candidates.model(method)))
        .into_iter()
        .map(|row| validated(row, data))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(Comparison {
        training: training.known_part(own.samples),
        lambda_rad_s: own.estimator.lambda_rad_s,
        lambda_because: own.lambda_because,
        disagreement: Disagreement {
            a22: spread(&methods, |model| model.a22_per_s),
            b2: spread(&methods, |model| model.b2_per_s2),
        },
        methods,
    })
}

/// What the methods are given.
struct Candidates<'a> {
    record: &'a Record,
    training: Window,
    settings: IdentifySettings,
    paper: &'a Training<'a>,
    own: &'a Training<'a>,
    samples: &'a [Sample<f64>],
    data: ValidationData<'a>,
}

impl Candidates<'_> {
    fn model(&self, method: ComparedMethod) -> Result<MethodEstimate, NoModel> {
        let run = |prepared: &Training| {
            online::run(&prepared.segment, prepared.estimator, |_, _, _| {})
                .map_err(NoModel::Setting)
        };
        match method {
            ComparedMethod::Paper => Ok(run(self.paper)?.model().into()),
            ComparedMethod::RecursiveLeastSquares => {
                Ok(run(self.own)?.least_squares_model().into())
            }
            ComparedMethod::RecursiveInstrumentalVariable => Ok(run(self.own)?.model().into()),
            ComparedMethod::BatchLeastSquares => {
                let pass = online::estimate(&self.own.segment, self.own.estimator, false)
                    .map_err(NoModel::Setting)?;
                let batch = pass.online.batch.ok_or(NoModel::DependentRegressors)?;
                Ok(batch.into())
            }
            ComparedMethod::Simplex => by_simplex(self.samples),
            ComparedMethod::OutputError => {
                let found = output_error(self.samples, None).map_err(NoModel::Refine)?;
                Ok(found.model.into())
            }
            ComparedMethod::PredictionError => {
                let (model, covariance) =
                    prediction_error(self.samples, None).map_err(NoModel::Refine)?;
                Ok(MethodEstimate {
                    interval_95: Some(normal_intervals(&model, &covariance)),
                    ..MethodEstimate::from(model)
                })
            }
            ComparedMethod::Refined => self.refined(),
            ComparedMethod::HigherOrder => by_higher_order(self.samples, self.data),
        }
    }

    /// What [`identify`] hands over; a model behind a lagging rudder is validated behind it.
    fn refined(&self) -> Result<MethodEstimate, NoModel> {
        let is_training =
            std::ptr::eq(self.data.record, self.record) && self.data.window == self.training;
        let held_out = Some(self.data).filter(|_| !is_training);
        let found = identify(self.record, self.training, held_out, &self.settings)
            .map_err(NoModel::Identify)?;
        let refined = found.refined.as_ref().ok_or(NoModel::NotRefined)?;
        let behind_lag = found.simulated().map(|model| validation_of(model, self.data));
        Ok(MethodEstimate {
            interval_95: Some(refined.interval_95),
            validation: behind_lag.transpose()?,
            ..MethodEstimate::from(refined.model)
        })
    }
}

/// The validation of a model of more than the first order, or of one behind a lagging rudder.
fn validation_of(model: &SteeringModel, data: ValidationData) -> Result<Validation, NoModel> {
    steering_validation::validate(model, data.record, data.window).map_err(NoModel::Identify)
}

/// The row with the validation of its model, where the method has not made it.
fn validated(row: MethodResult, data: ValidationData) -> Result<MethodResult, IdentifyError> {
    let validation = match (row.validation, row.model) {
        (None, Some(model)) => Some(validation::validate(model, data.record, data.window)?),
        (own, _) => own,
    };
    Ok(MethodResult { validation, ..row })
}

/// Splits a record with several strokes of the rudder into a first half for training and a second one for
/// validation, at the start of the second half's lead-in.
///
/// ```
/// use seatrial::study::split;
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
/// // The second doublet validates, with its own lead-in.
/// let (training, validation) = split(&record).ok_or("two doublets")?;
/// assert!(training.to_s <= validation.from_s && validation.contains(16.6));
/// # Ok::<(), &str>(())
/// ```
pub fn split(record: &Record) -> Option<(Window, Window)> {
    let manoeuvre = Manoeuvre::find(&record.samples)?;
    let middle = manoeuvre.strokes.len() / 2;
    let (before, after) =
        (manoeuvre.strokes.get(middle.checked_sub(1)?)?, manoeuvre.strokes.get(middle)?);
    let lead_in_s = manoeuvre.half_period_s()?;
    let at_s = before.window.to_s.max(after.window.from_s - lead_in_s);
    let both_sides_turn = manoeuvre.strokes.len() >= 4;
    both_sides_turn
        .then_some((Window { to_s: at_s, ..Window::ALL }, Window { from_s: at_s, ..Window::ALL }))
}

/// The paper's simplex; a search that did not converge is a failure.
fn by_simplex(samples: &[Sample<f64>]) -> Result<MethodEstimate, NoModel> {
    let found = simplex::fit_as_paper(samples).ok_or(NoModel::NoSamples)?;
    let iterations = found.iterations;
    if !found.converged {
        return Err(NoModel::NotConverged { iterations });
    }
    Ok(MethodEstimate {
        iterations: Some(iterations),
        ..MethodEstimate::from(YawModel::from_theta(found.at))
    })
}

/// The model of more than the first order, where the record supports one; a22, b2 and C0 are its own.
fn by_higher_order(
    samples: &[Sample<f64>],
    data: ValidationData,
) -> Result<MethodEstimate, NoModel> {
    // As `identify` asks it.
    if robust_estimate(samples).is_ok_and(|found| !found.asks_for_more(samples)) {
        return Err(NoModel::FirstOrderIsEnough);
    }
    let mut legs = Vec::new();
    let contest = contest_of(most_excited(samples), &mut legs).ok_or(NoModel::NoSamples)?;
    let predictor = &contest.predictor().hypothesis;
    let lead = contest.lead_over_first_order();
    if lead < LEAST_LEAD || !predictor.problem.structure.exceeds_first_order() {
        return Err(NoModel::FirstOrderIsEnough);
    }
    let full = predictor.steering_model();
    let model = YawModel::from_theta([full.a22_per_s, full.b2_per_s2, full.c0_rad_per_s2]);
    Ok(MethodEstimate {
        validation: Some(validation_of(&full, data)?),
        ..MethodEstimate::from(model)
    })
}

fn timed(
    method: ComparedMethod,
    clock_ms: &dyn Fn() -> f64,
    estimate: impl FnOnce() -> Result<MethodEstimate, NoModel>,
) -> MethodResult {
    let begun_ms = clock_ms();
    let found = estimate();
    let time_ms = clock_ms() - begun_ms;
    let (found, failure) = match found {
        Ok(found) => (Some(found), None),
        Err(failure) => (None, Some(failure.to_string())),
    };
    MethodResult {
        method,
        model: found.as_ref().map(|f| f.model),
        failure,
        interval_95: found.as_ref().and_then(|f| f.interval_95),
        validation: found.as_ref().and_then(|f| f.validation),
        iterations: found.and_then(|f| f.iterations),
        time_ms,
    }
}

impl From<YawModel<f64>> for MethodEstimate {
    fn from(model: YawModel<f64>) -> Self {
        Self { model, interval_95: None, iterations: None, validation: None }
    }
}

fn spread(methods: &[MethodResult], parameter: fn(&YawModel<f64>) -> f64) -> Option<f64> {
    let values = methods.iter().filter_map(|row| row.model.as_ref().map(parameter));
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let (low, middle, high) = (values.first()?, values.get(values.len() / 2)?, values.last()?);
    let spread = (high - low) / middle.abs();
    spread.is_finite().then_some(spread)
}
