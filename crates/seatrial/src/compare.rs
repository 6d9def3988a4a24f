//! Every method on the identical record, side by side.

use std::time::Instant;

use seatrial_core::{Sample, YawModel};
use serde::Serialize;

use crate::identification::{Intervals, Validation};
use crate::identify::intervals::normal_intervals;
use crate::identify::output_error::output_error;
use crate::identify::refined::{prediction_error, refined_estimate};
use crate::identify::second_order;
use crate::identify::simplex;
use crate::identify::{
    IdentifyError, IdentifySettings, Training, ValidationData, online, validation,
};
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
    /// Name of the method.
    pub method: String,
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

/// How far apart the methods are, as a fraction of the middle value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Disagreement {
    /// Of a22.
    pub a22: Option<f64>,
    /// Of b2.
    pub b2: Option<f64>,
}

/// A model, with what else a method can say of it.
struct Found {
    model: YawModel<f64>,
    interval_95: Option<Intervals>,
    iterations: Option<u32>,
    /// Where the method simulates more than the model.
    validation: Option<Validation>,
}

/// Runs every method on the training window and validates each model on the validation data.
pub fn compare(
    record: &Record,
    training: Window,
    data: ValidationData,
    lambda_rad_s: Option<f64>,
) -> Result<Comparison, IdentifyError> {
    let settings = IdentifySettings {
        lambda_rad_s,
        ..IdentifySettings::default()
    };
    let prepared = Training::new(record, training, &settings)?;
    let paper = Training::new(record, training, &IdentifySettings::paper())?;
    let pass = prepared.estimate()?;
    let samples = pass.accepted.as_slice();
    let run = |prepared: &Training| {
        online::run(&prepared.segment, prepared.estimator, |_, _, _| {})
            .map_err(|error| error.to_string())
    };

    let validate = |row: MethodResult| -> Result<MethodResult, IdentifyError> {
        let validation = match (row.validation, row.model) {
            (None, Some(model)) => Some(validation::validate(model, data.record, data.window)?),
            (own, _) => own,
        };
        Ok(MethodResult { validation, ..row })
    };
    let methods = [
        timed("paper", || Ok(run(&paper)?.model().into())),
        timed("recursive_least_squares", || {
            Ok(run(&prepared)?.least_squares_model().into())
        }),
        timed("recursive_instrumental_variable", || {
            Ok(run(&prepared)?.model().into())
        }),
        timed("batch_least_squares", || {
            let pass = online::estimate(&prepared.segment, prepared.estimator, false)
                .map_err(|error| error.to_string())?;
            let model = pass.online.batch.ok_or("the regressors are dependent")?;
            Ok(model.into())
        }),
        timed("simplex", || by_simplex(samples)),
        timed("output_error", || {
            let found = output_error(samples, None).map_err(|error| error.to_string())?;
            Ok(Found {
                iterations: Some(found.iterations),
                ..Found::from(found.model)
            })
        }),
        timed("prediction_error", || {
            let (model, covariance) =
                prediction_error(samples, None).map_err(|error| error.to_string())?;
            Ok(Found {
                interval_95: Some(normal_intervals(&model, &covariance)),
                ..Found::from(model)
            })
        }),
        timed("refined", || {
            let refined = refined_estimate(samples, None).map_err(|error| error.to_string())?;
            Ok(Found {
                interval_95: Some(refined.interval_95),
                ..Found::from(refined.model)
            })
        }),
        timed("higher_order", || by_higher_order(samples, data)),
    ]
    .into_iter()
    .map(validate)
    .collect::<Result<Vec<_>, _>>()?;

    Ok(Comparison {
        training: training.known_part(prepared.samples),
        lambda_rad_s: prepared.estimator.lambda_rad_s,
        lambda_because: prepared.lambda_because,
        disagreement: Disagreement {
            a22: spread(&methods, |model| model.a22_per_s),
            b2: spread(&methods, |model| model.b2_per_s2),
        },
        methods,
    })
}

/// Splits a record with several strokes of the rudder into a first half for training and a second one for
/// validation, at the start of the second half's lead-in.
pub fn split(record: &Record) -> Option<(Window, Window)> {
    let manoeuvre = Manoeuvre::find(&record.samples)?;
    let middle = manoeuvre.strokes.len() / 2;
    let (before, after) = (
        manoeuvre.strokes.get(middle.checked_sub(1)?)?,
        manoeuvre.strokes.get(middle)?,
    );
    let lead_in_s = manoeuvre.half_period_s()?;
    let at_s = before.window.to_s.max(after.window.from_s - lead_in_s);
    let both_sides_turn = manoeuvre.strokes.len() >= 4;
    both_sides_turn.then_some((
        Window {
            to_s: at_s,
            ..Window::ALL
        },
        Window {
            from_s: at_s,
            ..Window::ALL
        },
    ))
}

/// The paper's simplex; a search that did not converge is a failure.
fn by_simplex(samples: &[Sample<f64>]) -> Result<Found, String> {
    let found = simplex::fit_as_paper(samples).ok_or("no samples")?;
    if !found.converged {
        return Err(format!(
            "not converged after {} iterations",
            found.iterations
        ));
    }
    Ok(Found {
        iterations: Some(found.iterations),
        ..Found::from(YawModel::from_theta(found.at))
    })
}

/// The model of more than the first order, where the record supports one; a22, b2 and C0 are its own.
fn by_higher_order(samples: &[Sample<f64>], data: ValidationData) -> Result<Found, String> {
    let found = second_order::fit(samples).map_err(|error| error.to_string())?;
    if !found.order.exceeds_first_order() {
        return Err(found.order.to_string());
    }
    let full = &found.model;
    let model = YawModel::from_theta([full.a22_per_s, full.b2_per_s2, full.c0_rad_per_s2]);
    let validation = second_order::validate(full, data.record, data.window)
        .map_err(|error| error.to_string())?;
    Ok(Found {
        interval_95: Some(normal_intervals(&model, &found.covariance.into())),
        validation: Some(validation),
        ..Found::from(model)
    })
}

fn timed(method: &str, estimate: impl FnOnce() -> Result<Found, String>) -> MethodResult {
    let begun = Instant::now();
    let found = estimate();
    let time_ms = begun.elapsed().as_secs_f64() * 1e3;
    let (found, failure) = match found {
        Ok(found) => (Some(found), None),
        Err(failure) => (None, Some(failure)),
    };
    MethodResult {
        method: method.into(),
        model: found.as_ref().map(|f| f.model),
        failure,
        interval_95: found.as_ref().and_then(|f| f.interval_95),
        validation: found.as_ref().and_then(|f| f.validation),
        iterations: found.and_then(|f| f.iterations),
        time_ms,
    }
}

impl From<YawModel<f64>> for Found {
    fn from(model: YawModel<f64>) -> Self {
        Self {
            model,
            interval_95: None,
            iterations: None,
            validation: None,
        }
    }
}

fn spread(methods: &[MethodResult], parameter: fn(&YawModel<f64>) -> f64) -> Option<f64> {
    let mut values: Vec<f64> = methods
        .iter()
        .filter_map(|row| row.model.as_ref().map(parameter))
        .collect();
    values.sort_by(f64::total_cmp);
    let (low, high) = (values.first()?, values.last()?);
    let middle = values.get(values.len() / 2)?;
    let spread = (high - low) / middle.abs();
    spread.is_finite().then_some(spread)
}
